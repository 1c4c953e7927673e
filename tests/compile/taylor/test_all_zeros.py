"""Events of Taylor: none is missed, however long the steps are."""

import math

import numpy as np
import pytest

from fastdyn import solve_ivp


def oscillator(t, y):
    return [y[1], -y[0]]


OPTIONS = {"method": "Taylor", "rtol": 1e-10, "atol": 1e-10}


@pytest.mark.parametrize("rate", [1.0, 7.0, 40.0])
def test_all_zeros_of_a_fast_function(rate):
    """Of sin(rate t) (cos t - 2), which has many in a step of about 2."""
    run = solve_ivp(
        oscillator, (0.1, 30.0), [math.cos(0.1), -math.sin(0.1)], **OPTIONS,
        events=lambda t, y: math.sin(rate * t) * (y[0] - 2.0),
    )  # fmt: skip
    exact = np.arange(1, int(30.0 * rate / math.pi) + 1) * math.pi / rate
    exact = exact[(exact > 0.1) & (exact <= 30.0)]
    assert len(run.t_events[0]) == len(exact)
    assert np.abs(run.t_events[0] - exact).max() < 1e-9
    assert np.diff(run.t).max() > 1.0


def test_grazes_are_reported():
    """Double roots of the event function; those that lie above zero by a little are none."""
    run = solve_ivp(
        oscillator, (0.5, 20.0), [1.0, 0.0], **OPTIONS,
        events=[lambda t, y: (t - 3.1) ** 2 * (y[0] + 2.0), lambda t, y: (t - 3.1) ** 2 + 1e-6],
    )  # fmt: skip
    assert len(run.t_events[0]) == 1 and len(run.t_events[1]) == 0
    assert abs(run.t_events[0][0] - 3.1) < 1e-6  # the square root of the rounding


def test_random_events_beside_a_fine_scan():
    rng = np.random.default_rng(0)
    phases, rates, heights = rng.uniform(0, 6, 40), rng.uniform(0.5, 12, 40), rng.uniform(-1, 1, 40)
    events = [
        lambda t, y, a=a, w=w, h=h: math.cos(w * t + a) + 0.5 * y[0] - h
        for a, w, h in zip(phases, rates, heights, strict=True)
    ]
    run = solve_ivp(oscillator, (0.0, 40.0), [1.0, 0.0], events=events, **OPTIONS)
    t = np.linspace(0.0, 40.0, 400_001)
    for i, found in enumerate(run.t_events):
        g = np.cos(rates[i] * t + phases[i]) + 0.5 * np.cos(t) - heights[i]
        seen = t[1:][g[1:] * g[:-1] < 0]
        near = np.abs(found[:, None] - seen[None]).min(axis=0) if len(seen) else np.zeros(0)
        assert (near < 2e-4).all()
        assert len(found) - len(seen) in (0, 2)  # two within 1e-4 may escape the scan


def test_jumps_at_events():
    def fall(t, y):
        return [y[1], -10.0]

    run = solve_ivp(fall, (0.0, 4.5), [5.0, 0.0], events=lambda t, y: y[0],
                    on_event=lambda t, y: [0.0, -y[1]], **OPTIONS)  # fmt: skip
    assert np.abs(run.t_events[0] - [1.0, 3.0]).max() < 1e-9
    assert np.abs(run.y[:, -1] - [3.75, -5.0]).max() < 1e-8
