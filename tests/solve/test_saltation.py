"""Claims about sensitivities that pass events and schedules: they are those of differences."""

import math

import numpy as np
import pytest

from fastdyn import solve_ivp
from tests.support.impacts import marked
from tests.support.thermostat import SWITCH, heated

TIGHT = {"rtol": 1e-10, "atol": 1e-12}


def differences(solve, p, h=1e-5):
    """The derivatives of ``solve(p)`` by central differences, in columns."""
    columns = []
    for j in range(len(p)):
        ahead, back = np.array(p), np.array(p)
        ahead[j], back[j] = p[j] + h, p[j] - h
        columns.append((solve(ahead) - solve(back)) / (2.0 * h))
    return np.array(columns).T


def falling(t, y, g, e, k):
    return [y[1], -g - k * y[1]]


GROUND = marked(lambda t, y, g, e, k: y[0] - 0.1 * math.sin(t) * k, direction=-1)


@pytest.mark.parametrize("method", ["DOP853", "Radau", "Taylor"])
def test_sensitivities_pass_events_and_schedules(method):
    """The event's time depends on state, time and parameters, and so does the new state."""

    def solve(p, **options):
        return solve_ivp(
            falling, (0.0, 2.3), p[:2], method, args=tuple(p[2:]), events=[GROUND],
            at=[0.0, 0.7, 1.9], rtol=1e-11, atol=1e-13,
            on_event=[
                lambda t, y, g, e, k: [y[0], -e * y[1] + 0.1 * t],
                lambda t, y, g, e, k: [y[0], 5.0 * y[1] * k + e],
            ], **options,
        )  # fmt: skip

    p = [1.0, 0.0, 9.81, 0.8, 0.2]
    run = solve(p, sensitivity=("y0", "args"))
    assert len(run.t_events[0]) == 3 and len(run.t_events[1]) == 3
    s = run.sensitivity
    found = np.column_stack([s["y0"][:, :, -1], *(s[name][:, -1] for name in "gek")])
    exact = differences(lambda p: solve(p).y[:, -1], p)
    assert np.abs(found - exact).max() <= 1e-6 * np.abs(exact).max()


def test_sensitivities_pass_discrete_states():
    def thermostat(p, **options):
        return solve_ivp(
            heated, (0.0, 9.0), [p[0]], args=(p[1],), discrete=[p[2]], **SWITCH, **TIGHT, **options
        )

    run = thermostat([19.5, 4.0, 0.1], sensitivity=("y0", "heat"))
    s = run.sensitivity
    found = [s["y0"][0, 0, -1], s["heat"][0, -1], s["discrete"][0, 0, -1]]
    exact = differences(lambda p: thermostat(p).y[:, -1], [19.5, 4.0, 0.1])[0]
    assert len(run.t_events[0]) > 1 and np.allclose(found, exact, rtol=1e-6, atol=1e-7)

    def sampled_by(p, **options):
        return solve_ivp(
            lambda t, y, d, k: [-y[0] + d[0]], (0.0, 2.0), p[:1], args=(p[1],), every=0.3,
            discrete=[0.0], on_event=lambda t, y, d, k: (y, [k * (1.0 - y[0])]), **TIGHT, **options,
        )  # fmt: skip

    s = sampled_by([0.5, 1.3], sensitivity=("y0", "k")).sensitivity
    exact = differences(lambda p: sampled_by(p).y[:, -1], [0.5, 1.3])[0]
    assert np.allclose([s["y0"][0, 0, -1], s["k"][0, -1]], exact, rtol=1e-6)


def test_a_jump_that_is_not_finite_is_told_with_its_possible_cause():
    def falls(t, y):
        return [-1.0]

    ground = marked(lambda t, y: y[0], terminal=False)
    given = {"events": ground, "on_event": lambda t, y: [math.nan], "sensitivity": "y0"}
    result = solve_ivp(falls, (0, 2), [1.0], **given)
    assert result.status == -1
    assert "touches zero there without crossing it" in result.message
