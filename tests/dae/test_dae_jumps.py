"""Claims about events that change the state of F(t, y, y') = 0."""

import math

import numpy as np
import pytest

from fastdyn import solve_dae, solve_ivp
from tests.support.daes import linear, linear_solution
from tests.support.impacts import marked

TIGHT = {"rtol": 1e-9, "atol": 1e-11}


def ball(t, y, yp, bounce):
    """Height, velocity, and the energy, which is algebraic."""
    return [yp[0] - y[1], yp[1] + 9.81, y[2] - 9.81 * y[0] - 0.5 * y[1] ** 2]


def ground(t, y, bounce):
    return y[0]


def impact(t, y, bounce):
    return [0.0, -bounce * y[1], y[2]]


def test_a_ball_bounces():
    """Flights are a geometric series; the energy is computed anew behind each impact."""
    run = solve_dae(
        ball, (0, 3), [1.0, 0.0, 9.81], args=(0.8,), events=marked(ground, direction=-1),
        on_event=impact, dense_output=True, **TIGHT,
    )  # fmt: skip
    assert run.success
    flights = np.diff(run.t_events[0])
    assert len(flights) >= 3 and np.abs(flights[1:] - 0.8 * flights[:-1]).max() <= 1e-7
    assert run.t_events[0][0] == pytest.approx(math.sqrt(2 / 9.81), abs=1e-8)
    (twice,) = np.nonzero(np.diff(run.t) == 0)
    assert np.abs(run.y[2, twice + 1] / run.y[2, twice] - 0.64).max() <= 1e-7
    assert np.abs(run.yp[0, twice + 1] + 0.8 * run.yp[0, twice]).max() <= 1e-5
    residuals = [ball(t, y, yp, 0.8) for t, y, yp in zip(run.t, run.y.T, run.yp.T, strict=True)]
    assert np.abs(np.delete(residuals, twice, axis=0)).max() <= 1e-6
    heights = solve_ivp(
        lambda t, y, bounce: [y[1], -9.81], (0, 3), [1.0, 0.0], "DOP853", args=(0.8,),
        events=marked(ground, direction=-1), on_event=lambda t, y, b: [0.0, -b * y[1]], **TIGHT,
    )  # fmt: skip
    assert run.y[0, -1] == pytest.approx(heights.y[0, -1], abs=1e-6)


def test_a_thermostat_switches():
    """The heater is a component of the state, which only events change."""

    def room(t, y, yp):
        warmth, heater, loss = y
        return [yp[0] - heater + loss, yp[1], loss - 0.5 * warmth]

    low = marked(lambda t, y: y[0] - 1.0, direction=-1)
    high = marked(lambda t, y: y[0] - 1.5, direction=1)
    run = solve_dae(
        room, (0, 12), [1.2, 1.0, 0.6], events=[low, high],
        on_event=[lambda t, y: [y[0], 1.0, y[2]], lambda t, y: [y[0], 0.0, y[2]]], **TIGHT,
    )  # fmt: skip
    assert run.success and run.y[0].min() >= 1.0 - 1e-6 and run.y[0].max() <= 1.5 + 1e-6
    off, on = 2 * math.log(1.5), 2 * math.log((1.0 - 2.0) / (1.5 - 2.0))
    assert np.abs(np.diff(run.t_events[0]) - off - on).max() <= 1e-6


def test_the_constraint_of_the_time_of_the_event():
    """Behind the event, y0' = -2 y0 + sin t begins anew at half the value."""
    start = linear_solution(0.0)
    half = marked(lambda t, y: t - 1.0)
    run = solve_dae(
        linear, (0, 2), *start, events=half, on_event=lambda t, y: [0.5 * y[0], 9.0], **TIGHT
    )
    (i,) = np.flatnonzero(np.diff(run.t) == 0)
    before, _ = linear_solution(1.0)
    assert run.y[:, i + 1] == pytest.approx(
        [0.5 * before[0], math.sin(1) - 0.5 * before[0]], abs=1e-7
    )
    after, _ = linear_solution(2.0)
    assert run.y[0, -1] == pytest.approx(after[0] - 0.5 * before[0] * math.exp(-2), abs=1e-7)


def test_a_state_without_a_solution_is_a_sentence():
    def F(t, y, yp):
        return [yp[0] + 1.0, y[0] - y[1] ** 2]

    at_half = marked(lambda t, y: y[0] - 0.5)
    with pytest.raises(ValueError, match="equation 1 of `F` stays different from 0"):
        solve_dae(F, (0, 2), [1.0, 1.0], events=at_half, on_event=lambda t, y: [-3.0, 1.0])
    with pytest.raises(ValueError, match="`on_event` returned 1 value for a state of 2"):
        solve_dae(F, (0, 2), [1.0, 1.0], events=at_half, on_event=lambda t, y: [1.0])
    run = solve_dae(F, (0, 2), [1.0, 1.0], events=at_half, on_event=lambda t, y: [math.nan, 1.0])
    assert run.status == -1 and "`on_event` of event 0, `event`, returned nan" in run.message
