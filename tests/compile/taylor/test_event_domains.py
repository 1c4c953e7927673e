"""Events of functions that leave their domain, or jump: found with the precision of all others."""

import math

import numpy as np
import pytest

import fastdyn

TIGHT = {"method": "Taylor", "rtol": 1e-10, "atol": 1e-12}


def oscillator(t, y):
    return [y[1], -y[0]]


def times_at(value, start, end=20.0):
    """The times in (0, end) at which y[0] of the oscillator has a value."""
    size, phase = math.hypot(*start), math.atan2(start[1], start[0])
    angle = math.acos(value / size)
    turns = 2 * np.pi * np.arange(-1, 5)
    times = np.sort(np.concatenate([phase + angle + turns, phase - angle + turns]))
    return times[(times > 0) & (times < end)]


DOMAINS = {  # the event, the start, and the value of y[0] at the event
    "sqrt": (lambda t, y: np.sqrt(y[0]) - 0.5, [1.0, 0.1], 0.25),
    "log": (lambda t, y: np.log(y[0] + 0.5), [1.0, 0.1], 0.5),
    "power": (lambda t, y: y[0] ** 1.5 - 0.125, [1.0, 0.1], 0.25),
    "pole": (lambda t, y: y[0] ** -0.5 - 2.0, [1.0, 0.1], 0.25),
    "arccosh": (lambda t, y: np.arccosh(y[0]) - 0.3, [2.0, 0.1], math.cosh(0.3)),
    "arctanh": (lambda t, y: np.arctanh(y[0]) - 1.5, [0.1, 2.0], math.tanh(1.5)),
}


@pytest.mark.parametrize("name", DOMAINS)
@pytest.mark.parametrize("terminal", [False, True])
def test_no_event_is_lost_where_its_function_is_nan_later(name, terminal):
    function, start, value = DOMAINS[name]

    def event(t, y):
        return function(t, y)

    event.terminal = terminal
    found = fastdyn.solve_ivp(oscillator, (0, 20), start, events=event, **TIGHT)
    expected = times_at(value, start)
    assert found.status == terminal
    np.testing.assert_allclose(found.t_events[0], expected[: 1 if terminal else None], 0, 1e-8)


def test_events_backwards_are_found_before_the_domain_ends():
    found = fastdyn.solve_ivp(
        oscillator, (0, -20), [1.0, -0.1], events=lambda t, y: np.sqrt(y[0]) - 0.5, **TIGHT
    )
    np.testing.assert_allclose(-found.t_events[0], times_at(0.25, [1.0, 0.1]), 0, 1e-8)


def test_a_jump_is_where_the_function_jumps():
    found = fastdyn.solve_ivp(
        lambda t, y: [1.0], (0, 8), [0.0],
        events=lambda t, y: np.arctan(np.tan(y[0])) - 0.3, **TIGHT,
    )  # fmt: skip
    expected = np.sort(np.concatenate([0.3 + np.pi * np.arange(3), np.pi * (0.5 + np.arange(3))]))
    np.testing.assert_allclose(found.t_events[0], expected, 0, 1e-10)


def test_an_event_acts_once_at_a_jump():
    start = [1.0, 0.1]
    found = fastdyn.solve_ivp(
        oscillator, (0, 20), start,
        events=lambda t, y: np.arctan2(-y[1], y[0]) - 3.1, on_event=lambda t, y: y, **TIGHT,
    )  # fmt: skip
    turns = math.atan2(0.1, 1.0) + 2 * np.pi * np.arange(3)
    assert found.status == 0
    expected = np.sort(np.concatenate([3.1 + turns, np.pi + turns]))
    np.testing.assert_allclose(found.t_events[0], expected, 0, 1e-8)


def test_events_of_series_need_no_kernel_that_looks_inside_steps(monkeypatch):
    """Four CPU seconds of a first solve on a new machine."""

    def refused():
        raise AssertionError

    monkeypatch.setattr("fastdyn.run.begin.roots_inside_kernel", refused)
    given = (lambda t, y: [y[1], -y[0]], (0, 4), [1.0, 0.0], "Taylor")
    run = fastdyn.solve_ivp(*given, events=lambda t, y: y[0])
    assert run.t_events[0].tolist() == pytest.approx([math.pi / 2], abs=1e-3)
