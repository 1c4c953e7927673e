"""A constant of the code that changes from 0.0 to -0.0, or from 1 to 1.0 or True, has changed."""

import math

import numpy as np
import pytest

import fastdyn

pytestmark = pytest.mark.filterwarnings("ignore")
OUTSIDE = {"zero": 0.0}
FACTORS = {0.0: 2.0, (0.0, 1.0): 2.0}


@pytest.fixture(autouse=True)
def _without_comparisons(monkeypatch):
    """Code is used as it is: a comparison would notice a wrong sign after some solves."""
    monkeypatch.setattr("fastdyn.run.functions.compared.WHEN", "never")


def sign(x):
    return math.copysign(1.0, x)


def argument(t, y, zero):
    return [-FACTORS[zero] * sign(zero) * y[0]]


def text(t, y, zero):
    return [-len(str(zero)) * y[0]]


def number(t, y):
    zero = OUTSIDE["zero"]
    return [-FACTORS[zero] * sign(zero) * y[0]]


def text_of_number(t, y):
    return [-len(str(OUTSIDE["zero"])) * y[0]]


def complex_number(t, y):
    zero = OUTSIDE["complex"]
    return [-FACTORS[zero] * sign(zero.imag) * y[0]]


def pair(t, y):
    zeros = OUTSIDE["pair"]
    return [-FACTORS[zeros] * sign(zeros[0]) * y[0]]


def frozen_set(t, y):
    return [-sign(next(iter(OUTSIDE["set"]))) * y[0]]


def in_numba(t, y):
    x, n = y[0], 0
    while abs(x) > 1e-3 and n < 60:
        x, n = 0.5 * x, n + 1
    return [-sign(OUTSIDE["zero"]) * y[0] + x]


def default(t, y, zero=0.0):
    return [-len(str(zero)) * y[0]]


FUNCTIONS = [
    argument, text, number, text_of_number, complex_number, pair, frozen_set, in_numba, default,
]  # fmt: skip


@pytest.mark.parametrize("fun", FUNCTIONS)
def test_a_sign_of_zero_counts(fun, monkeypatch):
    args = (0.0,) if fun in (argument, text) else ()
    for zero in (0.0, -0.0, 0.0, 0.0, -0.0, 0.0, -0.0, -0.0, 0.0):
        values = {"zero": zero, "complex": complex(0.0, zero), "pair": (zero, 1.0)}
        for name, value in (values | {"set": frozenset([zero])}).items():
            monkeypatch.setitem(OUTSIDE, name, value)
        monkeypatch.setattr(default, "__defaults__", (zero,))
        args = args and (zero,)
        slope = fun(0.0, np.array([1.0]), *args)[0]
        later = fastdyn.solve_ivp(fun, (0.0, 1e-6), [1.0], args=args or None).y[0, -1]
        assert np.sign(later - 1.0) == np.sign(slope)
        assert math.isclose((later - 1.0) / 1e-6, slope, rel_tol=1e-4)


def of_keys(t, y):
    return [-len(str(next(iter(OUTSIDE["dict"])))) * y[0]]


def of_a_set(t, y):
    return [-len(str(next(iter(OUTSIDE["set"])))) * y[0]]


def of_a_tuple(t, y):
    return [-len(str(next(iter(OUTSIDE["tuples"])))) * y[0]]


@pytest.mark.parametrize("fun", [of_keys, of_a_set, of_a_tuple])
def test_types_of_equal_constants_count(fun, monkeypatch):
    for one in (1, 1.0, True, 1, np.float64(1.0), True, 1.0):
        values = {"dict": {one: 0.0}, "set": {one}, "tuples": frozenset([(one, 2)])}
        for name, value in values.items():
            monkeypatch.setitem(OUTSIDE, name, value)
        slope = fun(0.0, np.array([1.0]))[0]
        later = fastdyn.solve_ivp(fun, (0.0, 1e-6), [1.0]).y[0, -1]
        assert math.isclose((later - 1.0) / 1e-6, slope, rel_tol=1e-4)
