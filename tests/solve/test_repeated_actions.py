"""Repeated calls of `solve_ivp` with functions that act between steps, and with arrays in options.

What acts is read at each call, as `fun` is.
"""

import functools
from typing import Any

import numpy as np
import pytest
import scipy.sparse

import fastdyn
from fastdyn import solve_ivp
from fastdyn.run import again
from fastdyn.solve import repeated
from support.repeated import assert_first, is_plain, plain, warm

SPAN, START = (0.0, 1.0), [1.0, 0.1]

pytestmark = pytest.mark.usefixtures("nothing_known")


def driven(t, y, k):
    return [y[1], -k * y[0]]


def falls(t, y, k):
    return y[0] - 0.8


def turned(t, y, k):
    return [y[0], -0.5 * y[1]]


def shrunk(t, y, k):
    return [0.9 * y[0], y[1]]


OPTIONS = {
    "on_event": {"events": falls, "on_event": turned},
    "several": {"events": [falls, falls], "on_event": (None, turned)},
    "every": {"every": 0.3, "on_event": shrunk},
    "every alone": {"every": 0.3},
    "at": {"at": [0.2, 0.7], "on_event": shrunk},
    "project": {"project": shrunk},
    "mass": {"mass": [2.0, 0.5], "method": "Radau"},
    "sensitivity": {"sensitivity": "k", "events": falls},
    "series": {"sensitivity": "k", "method": "Taylor"},
    "actions of a series": {"events": falls, "on_event": turned, "method": "Taylor"},
}


@pytest.mark.parametrize("name", OPTIONS)
def test_calls_are_plain(name):
    given = dict(OPTIONS[name])
    if "mass" in given:
        given["mass"] = np.diag(given["mass"])
    found = is_plain(solve_ivp, driven, SPAN, START, args=(2.0,), **given)
    has_own = "sensitivity" in given and "events" in given  # results of solves with other fields
    assert found or has_own
    for key in again.calls.entries.values():
        if isinstance(key.value, repeated.Repeated):
            assert key.value.idle


def closures(rate, level, factor):
    def fun(t, y):
        return [y[1], -rate * y[0]]

    def event(t, y):
        return y[0] - level

    def act(t, y):
        return [y[0], factor * y[1]]

    return fun, event, act


class Acts:
    """An action with a value of its own."""

    def __init__(self, factor):
        self.factor = factor

    def __call__(self, t, y):
        return [self.factor * y[0], y[1]]


def scaled(t, y, by):
    return [by * y[0], y[1]]


@pytest.mark.parametrize("method", ["RK45", "Vern7", "Radau"])
def test_what_acts_is_read_at_each_call(method):
    times = np.array([0.2, 0.45])
    own = Acts(0.9)
    values = [(2.0, 0.9, -0.5), (3.0, 0.8, 0.7), (2.0, 0.95, -0.5), (1.5, 0.9, 1.3)]
    for i, (rate, level, factor) in enumerate(values * 3):
        fun, event, act = closures(rate, level, factor)
        times[1] = 0.4 + 0.05 * (i % 3)
        own.factor = 0.9 + 0.01 * (i % 4)
        act_at = functools.partial(scaled, by=0.8 + 0.1 * (i % 2))
        given = {
            "method": method, "events": event, "at": times, "every": 0.3,
            "on_event": [act, own, act_at if i % 5 else None],
        }  # fmt: skip
        assert_first(solve_ivp(fun, SPAN, START, **given), plain(fun, SPAN, START, **given))


def test_spans_of_schedules():
    given = {"every": 0.3, "on_event": shrunk, "args": (2.0,)}
    for span in [SPAN] * 4 + [(0.5, 2.0)] * 6 + [SPAN, (0.5, 2.0), (1.0, 0.0)] * 3:
        found = solve_ivp(driven, span, START, **given)
        assert_first(found, plain(driven, span, START, **given))


def test_spans_of_schedules_of_a_prepared_solver():
    given = {"every": 0.3, "on_event": shrunk, "args": (2.0,)}
    solver = fastdyn.prepare(driven, SPAN, START, **given)
    for span in [SPAN] * 2 + [(0.5, 2.0)] * 9 + [SPAN, (0.5, 2.0)] * 9:
        found = solver(t_span=span)
        assert_first(found, plain(driven, span, START, **given))


@pytest.mark.parametrize("form", [np.array, scipy.sparse.csr_array])
def test_a_mass_that_changes_in_place(form):
    mass = form(np.diag([1.0, 2.0]))
    for i in range(9):
        mass[1, 1] = 1.0 + i % 3
        given = {"method": "BDF", "mass": mass, "args": (2.0,)}
        found = solve_ivp(driven, SPAN, START, **given)
        assert_first(found, plain(driven, SPAN, START, **given))


def test_a_mass_that_is_a_function_is_called():
    for i in range(9):
        given = {"method": "BDF", "mass": lambda t, y, k, i=i: np.diag([1.0, 1.0 + i % 3])}
        found = solve_ivp(driven, SPAN, START, args=(2.0,), **given)
        assert_first(found, plain(driven, SPAN, START, args=(2.0,), **given))


def test_the_order_of_a_series_with_sensitivities():
    """Values above 1 tighten the tolerances of the derivatives: here the order 17 becomes 25."""
    given = {"method": "Taylor", "sensitivity": "k", "rtol": 1.4e-9, "atol": 7e-7}
    orders = set()
    for k in [0.5] * 5 + [10.0, 0.5, 1.2, 30.0] * 3:
        for scale in (1.0, 1.5):
            call = given | {"args": (k,), "dense_output": True}
            found = solve_ivp(driven, SPAN, [scale, 0.1], **call)
            assert_first(found, plain(driven, SPAN, [scale, 0.1], **call))
            orders.add(found.sol.polynomials.shape[1] - 1)
    assert orders == {17, 25}


def test_actions_that_python_refuses():
    """A wrong state of an action ends each call with the words of the first."""
    given = {"events": falls, "on_event": lambda t, y, k: [np.inf, 0.0], "args": (2.0,)}
    first = plain(driven, SPAN, START, **given)
    assert "returned nan or inf" in first.message
    found = warm(solve_ivp, driven, SPAN, START, **given)
    assert found.message == first.message
    assert_first(found, first)


class Passes:
    """An event whose rules a trace of the function does not read."""

    terminal: Any = True

    def __call__(self, t, y, k):
        return y[0] - 0.8


def test_true_is_not_the_number_one_of_an_event_that_acts():
    """`terminal = True` does not end a run in which the event acts; the equal number 1 does."""
    passes = Passes()
    given = {"args": (2.0,), "events": passes, "on_event": turned, "compile": "shared"}
    warm(solve_ivp, driven, SPAN, START, **given)
    for terminal, status in ((True, 0), (1, 1), (1.0, 1), (np.True_, 0), (np.int64(1), 1), (2, 0)):
        passes.terminal = terminal
        first = plain(driven, SPAN, START, **given)
        for _ in range(3):
            assert_first(solve_ivp(driven, SPAN, START, **given), first)
        assert first.status == status


def test_tolerances_of_an_earlier_call_change_in_place():
    """A run that is kept has tolerances of its own: a long one is laid out anew by their order."""
    atol = np.array([1e-10, 1e-10])
    given = {"args": (2.0,), "rtol": 1e-10, "compile": "shared", "dense_output": True}
    span = (0.0, 30000.0)
    first = plain(driven, span, START, "Taylor", atol=atol.copy(), **given)
    warm(solve_ivp, driven, span, START, "Taylor", atol=atol, **given)
    atol[:] = 1.0
    for _ in range(3):
        found = solve_ivp(driven, span, START, "Taylor", atol=np.array([1e-10, 1e-10]), **given)
        assert_first(found, first)
