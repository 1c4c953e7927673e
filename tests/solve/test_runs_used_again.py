"""solve_ivp uses the run of an earlier solve: whatever changes between two solves is seen."""

import types

import numpy as np
import pytest
import scipy.integrate

from fastdyn import solve_ivp
from fastdyn.run import solve_problem
from fastdyn.solve import repeated

START = np.array([0.4, 0.9])
RATE = 1.0


def agrees(fun, *args, t_span=(0.0, 1.0), y0=START, **options):
    mine = solve_ivp(fun, t_span, y0, args=args, **options)
    theirs = scipy.integrate.solve_ivp(fun, t_span, y0, args=args, **options)
    assert mine.status == theirs.status and mine.nfev == theirs.nfev
    # the rounding of a step, as a part of its error estimate, which decides on the next
    assert np.allclose(mine.t, theirs.t, rtol=1e-6, atol=0)
    assert np.allclose(mine.y, theirs.y, rtol=1e-6, atol=1e-6)
    for found, expected in zip(mine.t_events or (), theirs.t_events or (), strict=True):
        assert len(found) == len(expected) and np.allclose(found, expected, rtol=1e-6, atol=1e-6)


def of_global(t, y, k):
    return -RATE * k * y


def test_globals_arguments_spans_and_tolerances(monkeypatch):
    for rate in (1.0, 2.0, np.float64(0.5), 3, 1.0):
        monkeypatch.setitem(globals(), "RATE", rate)
        for k in (1.0, 2, np.array([1.0, 2.0])):
            agrees(of_global, k)
    agrees(of_global, 1.0, t_span=(0.0, -2.0))
    agrees(of_global, 1.0, rtol=1e-8, atol=np.array([1e-9, 1e-3]))
    agrees(of_global, 1.0, first_step=0.01, max_step=0.1)
    agrees(of_global, 1.0)
    for t_eval in ([0.1, 0.9], [0.3, 0.4], [1.0]):
        agrees(of_global, 1.0, t_eval=t_eval)
    agrees(of_global, 1.0, y0=START[:1])
    agrees(of_global, 1.0, dense_output=True)


def test_one_code_with_other_closures_and_objects():
    def made(k):
        return lambda t, y: -k * y

    for k in (1.0, 2.0, np.array([1.0, 3.0]), 4):
        agrees(made(k))
    thing, table, a = types.SimpleNamespace(k=1.0), {"k": 1.0}, np.ones(2)

    def fun(t, y):
        return -(thing.k + table["k"]) * a * y

    for _ in range(3):
        agrees(fun)
        thing.k += 1.0
        agrees(fun)
        table["k"] += 0.5
        agrees(fun)
        a[1] += 0.5
    a = np.array([0.5, 7.0])
    agrees(fun)
    fun.__code__ = (lambda t, y: y).__code__.replace(co_freevars=fun.__code__.co_freevars)
    agrees(fun)


def test_what_raises_is_asked_as_it_is_now():
    def made(limit):
        def fun(t, y):
            if t > limit:
                raise ValueError(f"beyond {limit}")
            return -y

        return fun

    agrees(made(5.0))
    for limit in (0.5, 0.25):
        with pytest.raises(ValueError, match=f"beyond {limit}"):
            solve_ivp(made(limit), (0, 1), START)
    agrees(made(6.0))


def test_long_after_short_and_back():
    def fun(t, y):
        return [y[1], -y[0]]

    for end in (1.0, 300.0, 1.0, 300.0, 2.0):  # more points than the first piece of the output
        agrees(fun, t_span=(0.0, end))


def test_a_solve_inside_a_solve():
    def inner(t, y):
        return -y

    def outer(t, y):
        return -y * solve_ivp(inner, (0, 1), [1.0]).y[0, -1]

    with pytest.warns(match="runs in Python"):
        agrees(outer)
    agrees(inner)


def turning(t, y):
    return [y[1], -y[0]]


def test_events_with_other_limits_directions_and_levels():
    def crossing(level, terminal=0, direction=0):
        def event(t, y):
            return y[0] - level

        event.terminal, event.direction = terminal, direction
        return event

    given = {"t_span": (0.0, 20.0), "rtol": 1e-8, "atol": 1e-8}
    for level in (0.0, 0.5):
        for how in ((0, 0), (0, 1), (0, -1), (True, 1), (2, 0), (0, 0)):
            agrees(turning, events=crossing(level, *how), **given)
    many = [crossing(0.1), crossing(0.2, 3)]
    agrees(turning, events=many, **given)
    agrees(turning, events=many[::-1], **given)
    event = crossing(0.1)
    for event.terminal in (0, 1):
        agrees(turning, events=event, **given)
    agrees(turning, events=[], **given)
    agrees(turning, events=event, dense_output=True, **given)
    agrees(turning, events=event, t_eval=[1.0, 2.0], **given)
    agrees(turning, **given)


def test_more_events_than_the_first_piece_of_the_output_holds():
    for end in (3.0, 600.0, 3.0, 600.0):
        agrees(turning, t_span=(0.0, end), events=lambda t, y: y[0], rtol=1e-8, atol=1e-8)


def test_what_acts_at_which_event_may_change():
    def low(t, y):
        return y[0] + 0.2

    def high(t, y):
        return y[0] - 0.2

    def back(t, y):
        return [y[0], -0.5 * y[1]]

    def solve(*on_event):
        events = [low, high]
        return solve_ivp(turning, (0, 3), START, events=events, on_event=on_event).y[:, -1]

    apart = [solve(back, None), solve(None, back)]
    assert not np.allclose(*apart)
    assert np.array_equal([solve(back, None), solve(None, back)], apart)


@pytest.mark.parametrize("options", [{}, {"events": lambda t, y, k: y[0] - 0.3}])
def test_a_run_is_used_again(options, monkeypatch):
    def fun(t, y, k):
        return [y[1], -k * y[0]]

    monkeypatch.setattr(repeated, "note", lambda *given: None)  # all calls go the long way
    first = solve_ivp(fun, (0, 1), START, args=(1.0,), **options)
    monkeypatch.delattr(solve_problem, "run_of")
    again = solve_ivp(fun, (0, 1), START, args=(1.0,), **options)
    assert np.array_equal(again.y, first.y)
    assert not np.array_equal(solve_ivp(fun, (0, 1), START, args=(2.0,), **options).y, first.y)


def test_attributes_and_defaults_that_a_function_gets_later_are_seen():
    def fun(t, y):
        return -getattr(fun, "k", 1.0) * y

    def other(t, y, k=1.0):
        return -k * y

    for _ in range(2):
        agrees(fun)
        fun.k = 3.0
    other.__defaults__ = (2.0,)
    agrees(other)
    fun.__defaults__ = (2.0,)
    agrees(fun)
