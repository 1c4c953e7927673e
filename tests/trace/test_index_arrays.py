"""Arrays of whole numbers that depend on the state index other arrays, as in NumPy."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp as reference

import fastdyn
from fastdyn.compile.bind import bind
from fastdyn.compile.compare import machine_value
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.make import Near

RNG = np.random.default_rng(1)
A, B, LONG = RNG.normal(size=(7, 3)), RNG.normal(size=(5, 4, 2)), RNG.normal(size=(200, 3))
KNOTS, THREE = np.linspace(0, 3, 6), np.arange(3)


def whole(y, n):
    return (np.abs(y) * 9).astype(int) % n


FUNCTIONS = {
    "rows": lambda t, y: A[np.searchsorted(KNOTS, y)].sum(axis=1),
    "columns": lambda t, y: A[:, whole(y, 3)].sum(axis=0),
    "two arrays": lambda t, y: A[whole(y, 7), THREE],
    "two of the state": lambda t, y: A[whole(y, 7), whole(2 * y, 3)],
    "between": lambda t, y: B[1:3, whole(y, 4), 1].sum(0),
    "with a number apart": lambda t, y: B[whole(y, 5), :, 1].sum(1),
    "arrays apart": lambda t, y: B[whole(y, 5), 1:, np.array([0, 1, 0])].sum(1),
    "dots": lambda t, y: B[..., whole(y, 2)][0, :3, 1],
    "a list": lambda t, y: B[[int(abs(y[0]) * 9) % 5, 1, 2], :, 0].sum(1),
    "two axes": lambda t, y: A[np.array([[int(t * 3) % 7, 0], [1, 2]])].sum((0, 1)),
    "the state": lambda t, y: y[whole(y, 3)],
    "of the state": lambda t, y: np.outer(y, y)[whole(y, 3)].sum(1),
    "two numbers": lambda t, y: y * np.outer(y, y)[int(abs(y[0])) % 3, int(abs(y[1])) % 3],
    "a long array": lambda t, y: LONG[whole(y, 200)].sum(1),
    "from the end": lambda t, y: A[-1 - whole(y, 7)].sum(1),
    "whole numbers": lambda t, y: A[np.minimum(3 * whole(y, 9) // 4 + 1, 6), 0],
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_code_is_the_function(name):
    fun = FUNCTIONS[name]
    bound = bind(fun, (), DERIVATIVE, 3, Near(0.0, 1.0, np.array([0.3, 0.7, 1.1])))
    assert bound.function is not None and bound.function.traced is not None
    for t in np.linspace(0, 2, 40):
        y = RNG.uniform(0, 3, size=3)
        found: Any = machine_value(bound, t, y)
        np.testing.assert_allclose(found, fun(t, y), rtol=1e-13, atol=1e-13)


def test_places_outside_raise_as_in_numpy():
    def fun(t, y):
        return A[(y * 3).astype(int)].sum(axis=1) + 9.0

    with pytest.raises(IndexError) as theirs:
        reference(fun, (0, 5), [0.3, 0.7, 1.1])
    with pytest.raises(IndexError) as mine:
        fastdyn.solve_ivp(fun, (0, 5), [0.3, 0.7, 1.1])
    assert str(mine.value) == str(theirs.value)


def test_numbers_of_an_array_of_floats_are_no_indices():
    def fun(t, y):
        return A[np.array([int(y[0]), 0.5])[0]] - y

    for solver in (fastdyn.solve_ivp, reference):
        with pytest.raises(IndexError, match="only integers"):
            solver(fun, (0, 1), [0.3, 0.7, 1.1])
