"""Events that act, of functions that are exactly zero over intervals: the ends of these count."""

import numpy as np
import pytest

from fastdyn import solve_ivp

METHODS = ("Tsit5", "Vern9", "Rodas5P", "RK45", "DOP853", "Radau", "LSODA", "ode45")
TIGHT = {"rtol": 1e-8, "atol": 1e-8}
UP = np.pi * np.array([1 / 6, 13 / 6])  # where sin(t) passes 1/2
DOWN = np.pi * np.array([5 / 6, 17 / 6])
LOW = np.pi * np.array([7 / 6, 11 / 6, 19 / 6])  # where sin(t) passes -1/2
RESOLVED = 4 * np.finfo(float).eps * (1 + 10)  # of a root, as SciPy's; |y'| < 1
APART = 0.5  # less than half the least distance of two edges


def oscillates(t, y):
    return [np.cos(t), 0.0]


def count(t, y):
    return [y[0], y[1] + 1.0]


def above(t, y):
    return max(0.0, y[0] - 0.5)


def below(t, y):
    return np.clip(y[0], -0.5, 0.5) - 0.5 if y[0] > 0 else y[0] - 0.5


def outside(t, y):
    return y[0] - np.clip(y[0], -0.5, 0.5)


EDGES = {
    (above, 0): np.sort(np.r_[UP, DOWN]),
    (above, 1): UP,
    (above, -1): DOWN,
    (below, 0): np.sort(np.r_[UP, DOWN]),
    (below, 1): UP,
    (below, -1): DOWN,
    (outside, 0): np.sort(np.r_[UP, DOWN, LOW]),
    (outside, 1): np.sort(np.r_[UP, LOW[1]]),
    (outside, -1): np.sort(np.r_[DOWN, LOW[::2]]),
}


def directed(function, direction):
    def event(t, y):
        return function(t, y)

    event.direction = direction
    return event


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("function", "direction"), EDGES)
def test_an_event_acts_at_the_edges_of_an_interval_of_zeros(method, function, direction):
    for more in ({}, {"max_step": 0.3}):
        found = solve_ivp(
            oscillates, (0, 10), [0.0, 0.0], method, events=directed(function, direction),
            on_event=count, **TIGHT, **more,
        )  # fmt: skip
        edges = EDGES[function, direction]
        assert found.status == 0 and found.y[1, -1] == len(edges)
        assert found.t_events[0] == pytest.approx(edges, abs=APART)
        assert np.abs(np.abs(found.y_events[0][:, 0]) - 0.5).max() <= 2 * RESOLVED


@pytest.mark.parametrize("direction", [0, 1, -1])
def test_edges_inside_one_step_of_an_own_method_act(direction):
    edges = EDGES[outside, direction]
    found = solve_ivp(
        oscillates, (0, 10), [0.0, 0.0], "Vern9", events=directed(outside, direction),
        on_event=count, rtol=1e-4, atol=1e-4,
    )  # fmt: skip
    assert np.diff(found.t).max() > 1.2  # longer than the shortest interval of zeros
    assert found.t_events[0] == pytest.approx(edges, abs=APART)
    assert np.abs(np.abs(found.y_events[0][:, 0]) - 0.5).max() <= 2 * RESOLVED


def test_a_function_that_is_always_zero_never_acts():
    found = solve_ivp(
        oscillates, (0, 10), [0.0, 0.0], "Tsit5", events=lambda t, y: 0.0 * y[0], on_event=count
    )
    assert found.status == 0 and len(found.t_events[0]) == 0


@pytest.mark.parametrize("method", ["Tsit5", "RK45"])
def test_a_start_at_a_zero_by_itself_is_no_edge(method):
    found = solve_ivp(
        lambda t, y: [1.0, 0.0], (0, 1), [0.5, 0.0], method, events=lambda t, y: y[0] - 0.5,
        on_event=count,
    )  # fmt: skip
    assert len(found.t_events[0]) == 0
