"""Taylor neither watches nor asks conditions that no numbers fulfil; all others still raise."""

import math

import numpy as np
import pytest
import scipy.integrate

from fastdyn import solve_ivp
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.taylor.recurrences.impossible_conditions import possible
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near, traced_function

START = [1.5, 0.7]
NEVER = {
    "squares": lambda x, y: math.sqrt(x * x + y * y),
    "many squares": lambda x, y: math.sqrt(sum((x + i) ** 2 + y * y for i in range(400))),
    "a constant": lambda x, y: math.sqrt(x**2 + 0.5),
    "sizes": lambda x, y: math.sqrt(abs(x) + abs(y - 2.0)),
    "products": lambda x, y: math.sqrt(x * x * abs(y)),
    "roots": lambda x, y: math.sqrt(math.sqrt(x * x + y * y) + x**2),
    "two": lambda x, y: math.sqrt(x * x) + math.sqrt(y * y),
}
SOMETIMES = {
    "a number": lambda x, y: math.sqrt(x),
    "a difference": lambda x, y: math.sqrt(x * x - y * y),
    "a product": lambda x, y: math.sqrt(x * y),
    "a negative constant": lambda x, y: math.sqrt(x * x + y * y + (-0.1)),
    "the negative": lambda x, y: math.sqrt(-(x * x) + 4.0),
    "one of two": lambda x, y: math.sqrt(x * x + y * y) + math.sqrt(y),
    "a logarithm": lambda x, y: math.log(x * x),
    "a cube": lambda x, y: math.sqrt(x**3),
    "an odd part": lambda x, y: math.sqrt(x * x * y),
}


def motion(rate):
    return lambda t, y: [rate(*y), -y[0]]


def can_raise(rate):
    found = traced_function(
        Attempt(motion(rate), (), DERIVATIVE, 2), Near(0.0, 1.0, np.array(START))
    )
    assert found is not None
    trace = found[0].traced.trace
    return possible(trace.graph, trace.failing) is not trace.graph.false


@pytest.mark.few(2)
@pytest.mark.parametrize("name", NEVER)
def test_what_never_raises(name):
    assert not can_raise(NEVER[name])
    given = {"rtol": 1e-10, "atol": 1e-10}
    mine = solve_ivp(motion(NEVER[name]), (0, 1), START, "Taylor", **given)
    other = scipy.integrate.solve_ivp(motion(NEVER[name]), (0, 1), START, "DOP853", **given)
    assert mine.success and np.allclose(mine.y[:, -1], other.y[:, -1], rtol=1e-8)


@pytest.mark.parametrize("name", SOMETIMES)
def test_what_raises_at_times(name):
    assert can_raise(SOMETIMES[name])


@pytest.mark.parametrize(
    "rate",
    [
        lambda x, y: math.sqrt(1.0 - x * x - y * y) + 1.0,
        lambda x, y: math.sqrt(x * x + y * y) + math.sqrt(0.9 - x),
    ],
)
def test_an_exception_comes_as_in_scipy(rate):
    for solve, method in ((solve_ivp, "Taylor"), (scipy.integrate.solve_ivp, "RK45")):
        with pytest.raises(ValueError, match=r"math domain error|expected a nonnegative"):
            solve(motion(rate), (0, 5), [0.1, 0.2], method)
