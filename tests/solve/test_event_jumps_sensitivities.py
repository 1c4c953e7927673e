"""Derivatives of events whose functions jump over zero, against differences of solves."""

import numpy as np
import pytest

from fastdyn import solve_dae, solve_ivp

TIGHT = {"rtol": 1e-10, "atol": 1e-12}
K, STEP = 0.4, 1e-4  # differences of the second order: an error of some 1e-8


def decay(t, y, k):
    return [-k * y[0]]


def changed(t, y, k):
    return [y[0] * y[0] + 0.1 * t]


def at_a_time(t, y, k):
    return y[0] - (0.9 if t >= 1 else -0.3)


def at_a_moving_time(t, y, k):
    return y[0] - (0.9 if t >= 2 * k else -0.3)


def by_the_state(t, y, k):
    return 1.0 if y[0] > 0.7 else -1.0


def by_a_moving_state(t, y, k):
    return np.where(y[0] > k + 0.3, -1.0, 2.0 - 0.1 * y[0])


def by_rounding(t, y, k):
    return np.floor(2 * t) - 1.5


def by_a_remainder(t, y, k):
    return (0.5 if (t + k) % 1.5 < 1.4 else -0.5) + 0.1 * y[0]


def smooth(t, y, k):
    return y[0] - 0.7


EVENTS = (at_a_time, at_a_moving_time, by_the_state, by_a_moving_state, by_rounding,
          by_a_remainder, smooth)  # fmt: skip


def slope(of):
    return (of(K + STEP) - of(K - STEP)) / (2 * STEP)


@pytest.mark.few
@pytest.mark.parametrize("event", EVENTS)
@pytest.mark.parametrize("method", ["Tsit5", "Vern9", "Radau"])
def test_time_state_and_end_have_the_derivatives_of_differences(event, method):
    def solved(k, **more):
        given = {"events": event, "on_event": changed, "args": (k,), **TIGHT}
        return solve_ivp(decay, (0, 2.2), [1.0], method, **given, **more)

    run = solved(K, sensitivity="k")
    assert len(run.t_events[0])
    of_times = slope(lambda k: solved(k).t_events[0])
    of_end = slope(lambda k: solved(k).y[0, -1])
    assert run.event_sensitivity[0].t["k"].tolist() == pytest.approx(of_times, abs=1e-6)
    assert run.sensitivity["k"][0, -1] == pytest.approx(of_end, abs=1e-6)
    if method != "Radau":
        back = solved(K, adjoint="k", t_eval=[2.2])
        assert back.vjp(np.array([[1.0]]))["k"] == pytest.approx(of_end, abs=1e-6)


@pytest.mark.parametrize("event", [at_a_time, at_a_moving_time, by_the_state, smooth])
def test_those_of_an_implicit_equation(event):
    def solved(k, **more):
        given = {"events": event, "on_event": changed, "args": (k,), "rtol": 1e-9, "atol": 1e-11}
        return solve_dae(lambda t, y, yp, k: [yp[0] + k * y[0]], (0, 2.2), [1.0], **given, **more)

    run = solved(K, sensitivity="k")
    of_end = slope(lambda k: solved(k).y[0, -1])
    assert run.sensitivity["k"][0, -1] == pytest.approx(of_end, abs=1e-5)
