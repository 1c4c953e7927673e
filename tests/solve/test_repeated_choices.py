"""Repeated calls of `solve_ivp` with "auto": the choice of the method is that of a first solve."""

import math

import numpy as np
import pytest

import fastdyn
from fastdyn import solve_ivp
from fastdyn.solve import automatic
from support.repeated import CALLS, assert_first, is_plain, plain, warm

SPAN, START = (0.0, 1.0), [1.0, 0.1]

pytestmark = pytest.mark.usefixtures("nothing_known")


def pendulum(t, y, k):
    return [y[1], -k * math.sin(y[0])]


def falls(t, y, k):
    return y[0] - 0.8


def turned(t, y, k):
    return [y[0], -0.5 * y[1]]


def stops(t, y, k):
    return [y[1], -k * y[0] - (0.3 if y[1] > 0.05 else -0.3)]


def turning(t, y, k):
    return [1j * k * y[0], -y[1]]


def decays(t, y, k):
    """Slow and fast modes: stiff for a large k."""
    return [-k * (y[0] - math.cos(t)), -y[1]]


def rough(t, y, k):
    return [y[1], -k * round(4.0 * y[0])]


def rooted(t, y, k):
    return [y[1], -math.sqrt(y[0] + k)]


CASES = {
    "loose": (pendulum, {}, "Tsit5"),
    "tight": (pendulum, {"rtol": 1e-8, "atol": 1e-10}, "Taylor"),
    "times": (pendulum, {"rtol": 1e-8, "t_eval": [0.25, 1.0]}, "Taylor"),
    "events": (pendulum, {"events": falls, "dense_output": True}, "Tsit5"),
    "actions": (pendulum, {"events": falls, "on_event": turned, "rtol": 1e-7}, "Taylor"),
    "sensitivity": (pendulum, {"sensitivity": "k", "rtol": 1e-6}, "Taylor"),
    "adjoint": (pendulum, {"adjoint": "k", "rtol": 1e-8, "t_eval": [0.25, 1.0]}, "Vern7"),
    "switches": (stops, {}, "Taylor"),
    "mass": (pendulum, {"mass": np.diag([2.0, 0.5]), "rtol": 1e-6}, "Rodas5P"),
    "no series": (rough, {"rtol": 1e-6}, "Vern7"),
    "complex": (turning, {"rtol": 1e-7, "y0": [1.0 + 0.1j, 0.5]}, "Vern7"),
}


def solve(fun, k, y0=START, **given):
    return solve_ivp(fun, SPAN, y0, "auto", args=(k,), **given)


def first(fun, k, y0=START, **given):
    return plain(fun, SPAN, y0, "auto", args=(k,), **given)


@pytest.mark.parametrize("name", CASES)
def test_a_call_again_is_a_first_solve(name):
    fun, given, method = CASES[name]
    assert first(fun, 2.0, **given).method == method
    y0 = given.get("y0", START)
    for k in (2.0, 2.0, 2.0, 2.0, 3, 2.0, 0.7, 2.5, 2.0, 4.0):
        other = given | {"y0": [y0[0] + 0.01 * k, y0[1]]}
        found = solve(fun, k, **other)
        assert_first(found, first(fun, k, **other))


@pytest.fixture
def choices(monkeypatch):
    """The Arguments of solves for which "auto" chooses."""
    found = []
    choose = automatic.solved
    monkeypatch.setattr(automatic, "solved", lambda asked: found.append(asked) or choose(asked))
    return found


@pytest.mark.parametrize("name", ["loose", "tight", "times", "events", "actions", "complex"])
def test_calls_are_plain(name, choices):
    fun, given, _ = CASES[name]
    assert is_plain(solve, fun, 2.0, **given)
    choices.clear()
    for _ in range(3):
        solve(fun, 2.0, **given)
    assert not choices


def test_a_stiff_solve_among_others():
    span = 0.0, 40.0

    def ends(k):
        found = [
            by(decays, span, START, "auto", args=(k,), rtol=1e-6, max_step=math.inf)
            for by in (solve_ivp, plain)
        ]
        assert_first(*found)
        return found[0].method

    for _ in range(6):
        assert ends(1.0) == "Taylor"
    assert ends(1e5) == "Radau"
    for _ in range(4):
        assert ends(1.0) == "Taylor"


def test_a_function_that_raises_among_others():
    def ends(k):
        try:
            return solve(rooted, k, rtol=1e-3)
        except ValueError:
            return None

    for _ in range(6):
        assert ends(2.0).method == "Tsit5"
    assert ends(-2.0) is None
    assert ends(2.0).method == "Tsit5"


def test_errors_that_numpy_reports_have_no_part_in_later_choices():
    given = {"rtol": 1e-8}
    with np.errstate(invalid="raise"), pytest.warns(fastdyn.CompileWarning):
        assert warm(solve, pendulum, 2.0, **given).method == "Vern7"
    assert warm(solve, pendulum, 2.0, **given).method == "Taylor"


def test_a_function_in_python_goes_the_long_way(choices):
    """Its code may be made later, and "auto" then choose another method."""
    seen = []

    def fun(t, y, k):
        seen.append(t)
        return [y[1], -k * y[0]]

    with pytest.warns(fastdyn.CompileWarning):
        warm(solve, fun, 2.0, rtol=1e-8)
    assert len(choices) == CALLS
