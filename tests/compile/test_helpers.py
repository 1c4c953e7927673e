"""What a function that cannot be traced may call: the loops end by a tolerance."""

import functools
import math
import warnings

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from support.halving import halved

WEIGHTS = [0.5, 0.25, 0.25]


def root(x, a=2.0, *, tol=1e-13, n=50):
    z = x
    for _ in range(n):
        step = (z * z - a - x) / (2 * z)
        z -= step
        if abs(step) < tol:
            break
    return z


def with_none(x, k=None, name="plain"):
    k = 2.0 if k is None else k
    return k * halved(x) if name == "plain" else 0.0


def required(x, *, k):
    return k * halved(x)


def of_function(x, f=math.sin, g=halved):
    return f(x) * g(x)


def weighted(x):
    total = 0.0
    for w in WEIGHTS:
        total += w * halved(x)
    return total + WEIGHTS[int(2 * (abs(x) % 1.0))]


class Body:
    k = 2.0

    def pull(self, x, m=3.0, *, n=1.0):
        return -self.k * m * n * halved(x)

    def __call__(self, t, y):
        return [self.pull(y[0]), self.pull(y[1])]


def keyword_only(t, y, k=1.0, *, m):
    return -k * m * halved(y[0]) * y


FUNCTIONS = {
    "default": lambda t, y: [-root(abs(y[0]) + 1), -root(1.5 + y[1] ** 2, 3.0)],
    "keyword": lambda t, y: [-root(abs(y[0]) + 1, tol=1e-9), -root(2.0 + y[1] ** 2, n=9, a=1.5)],
    "none": lambda t, y: [-with_none(y[0]), -with_none(y[1], 3.0) - with_none(t, name="other")],
    "required": lambda t, y: [-required(y[0], k=2.0), 0.0],
    "function": lambda t, y: [-of_function(y[0]), -of_function(y[1], math.cos)],
    "list": lambda t, y: [-weighted(y[0]), -weighted(y[1])],
    "method": Body(),
    "stacked": lambda t, y: np.hstack([y[1:], -halved(y[0]) * y[:1]]),
    "concatenated": lambda t, y: np.concatenate([y[1:], np.array([-halved(y[0])])]),
    "partial": functools.partial(keyword_only, m=2.0),
}
IN_PYTHON = {  # Numba as it is holds no keyword-only arguments, lists, objects, joined lists
    FUNCTIONS[name] for name in "default keyword required list method stacked concatenated".split()
}
PROBLEM = {"t_span": (0, 0.5), "y0": [1.0, 0.5], "rtol": 1e-8}


@pytest.mark.few(7)
@pytest.mark.parametrize("fun", FUNCTIONS.values(), ids=FUNCTIONS)
def test_it_agrees_with_scipy_and_compiles_or_says_why_not(fun):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        ours = fastdyn.solve_ivp(fun, **PROBLEM)
    assert [each.category for each in said] == [fastdyn.CompileWarning] * (fun in IN_PYTHON)
    theirs = scipy.integrate.solve_ivp(fun, **PROBLEM)
    assert ours.nfev == theirs.nfev
    np.testing.assert_allclose(ours.y, theirs.y, rtol=0, atol=1e-13)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_list_of_a_helper_is_a_list():
    def judged(x):
        return halved(x) * (
            2.0 if isinstance(WEIGHTS, list) and WEIGHTS == [0.5, 0.25, 0.25] else 1
        )

    def fun(t, y):
        return [-judged(y[0]), 0.0]

    ours = fastdyn.solve_ivp(fun, **PROBLEM).y
    np.testing.assert_allclose(ours, scipy.integrate.solve_ivp(fun, **PROBLEM).y, rtol=1e-12)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_defaults_and_lists_are_never_stale(monkeypatch):
    def end(fun):
        return fastdyn.solve_ivp(fun, **PROBLEM).y[0, -1]

    for fun, change in (
        (FUNCTIONS["default"], lambda: monkeypatch.setattr(root, "__defaults__", (1.0,))),
        (FUNCTIONS["default"], lambda: root.__kwdefaults__.update(n=1)),
        (FUNCTIONS["list"], lambda: WEIGHTS.__setitem__(0, 0.75)),
        (FUNCTIONS["partial"], lambda: monkeypatch.setattr(keyword_only, "__defaults__", (3.0,))),
    ):
        before = end(fun)
        change()
        theirs = scipy.integrate.solve_ivp(fun, **PROBLEM).y[0, -1]
        assert end(fun) == pytest.approx(theirs, abs=1e-13) != before
    root.__kwdefaults__["n"], WEIGHTS[0] = 50, 0.5
