"""Repeated and prepared solves by methods for q'' = a(t, q): the form is known for all values."""

import math

import numpy as np
import pytest

from fastdyn import prepare, solve_ivp
from fastdyn.kernels.methods import METHODS
from support.repeated import assert_first, is_plain, plain, warm

SPAN, START, STEP = (0.0, 1.0), [1.0, 0.1], 0.125
OF_FORM = [name for name, method in METHODS.items() if method.second_order]

pytestmark = pytest.mark.usefixtures("nothing_known")


def pendulum(t, y, k):
    return [y[1], -k * math.sin(y[0])]


def faster(t, y, c):
    return [c * y[1], -y[0]]


def damped(t, y, c):
    return [y[1], -y[0] - c * y[1]]


def of_arrays(t, y, c):
    q, v = np.split(y, 2)
    return np.concatenate([v, -c * q])


def again_by(fun, method, **given):
    """``solve(args)`` by repeated calls."""
    return lambda *args: solve_ivp(fun, SPAN, START, method, args=args, step=STEP, **given)


def prepared_by(fun, method, **given):
    solver = prepare(fun, SPAN, START, method, args=(1.0,), step=STEP, **given)
    return lambda *args: solver(args=args)


WAYS = {"again": again_by, "prepared": prepared_by}


@pytest.mark.parametrize("method", OF_FORM)
@pytest.mark.parametrize("fun", [pendulum, of_arrays])
def test_calls_are_plain(fun, method):
    solve = again_by(fun, method)
    assert is_plain(solve, 1.0)
    for k in (2.0, 3, 1.0):
        assert_first(solve(k), plain(fun, SPAN, START, method, args=(k,), step=STEP))


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(("fun", "good", "bad"), [(faster, 1.0, 2.0), (damped, 0.0, 0.5)])
def test_values_that_break_the_form_are_refused(fun, good, bad, way):
    """The form holds for the first values alone: each solve is looked at."""
    solve = WAYS[way](fun, "VelocityVerlet") if good else again_by(fun, "VelocityVerlet")
    warm(solve, good)
    with pytest.raises(ValueError, match=r"takes (y = \[q, v\]|q'' = a\(t, q\))"):
        solve(bad)
    assert solve(good).success


def closure(c):
    def fun(t, y):
        return [y[1] if c == 1 else c * y[1], -c * y[0]]

    return fun


def test_closures_of_another_form_are_refused():
    def solve(c):
        return solve_ivp(closure(c), SPAN, START, "VelocityVerlet", step=STEP)

    warm(solve, 1)
    with pytest.raises(ValueError, match="not v"):
        solve(2)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("way", WAYS)
def test_functions_in_python_are_looked_at(way):
    scale = [1.0]

    def fun(t, y, k):
        scale.append(scale.pop())
        return [scale[0] * y[1], -k * y[0]]

    solve = WAYS[way](fun, "VelocityVerlet")
    warm(solve, 1.0)
    scale[0] = 2.0
    with pytest.raises(ValueError, match="not v"):
        solve(1.0)
