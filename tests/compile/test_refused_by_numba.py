"""What Numba cannot take, or computes otherwise than Python, runs in Python, with a sentence."""

import enum
import os
import subprocess
import sys
import types
import warnings

import numba
import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.compile.by_numba.function import compiled_function
from fastdyn.compile.callables import parts_of
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.sentences import Uncompilable
from support.halving import halved  # noqa: F401  # by name, in texts


class Plain:
    def __init__(self):
        self.k = 2.0

    def rates(self, t, y):
        return self.k * y


class Colour(enum.Enum):
    RED = 1


class Money(float):
    def __mul__(self, other):
        return 2.0 * float(self) * other


table, objects, members, plain = {"k": 2.0}, [Plain(), Plain()], {1, 2}, Plain()
colour, money, rates, numbers = Colour.RED, Money(2.0), [1.0, 2.0], np.array([1.0, 2.0])
space = types.SimpleNamespace(k=2.0)


def helper(x):
    return table["k"] * x


def called(x, *, k=2.0):
    return k * x


def closed_over():
    inside = {"k": 1.0}
    return lambda t, y: inside["k"] * y


def counting():
    count = 0

    def fun(t, y):
        nonlocal count
        count += 1
        return -y * count

    return fun


def deep(x):
    return x if x < 0.5 else deep(x - 0.5)


VALUES = {  # refused before Numba is imported
    "global": (lambda t, y: table["k"] * y, (), "`table`, of type dict"),
    "closure": (closed_over(), (), "`inside`, of type dict"),
    "attribute": (lambda t, y: plain.k * y, (), "`plain`, of type Plain"),
    "class": (lambda t, y: Colour.RED.value * y, (), "`Colour`, of type EnumType"),
    "name space": (lambda t, y: space.k * y, (), "`space`, of type SimpleNamespace"),
    "module": (lambda t, y: fastdyn.__file__ and y, (), "`fastdyn`, of type module"),
    "method": (plain.rates, (), "no methods of objects"),
    "helper": (lambda t, y: helper(y), (), "`table`, of type dict"),
    "list": (lambda t, y: rates[0] * y, (), "`rates`, of type list"),
    "set": (lambda t, y: y * (1 in members), (), "`members`, of type set"),
    "enum": (lambda t, y: y if colour is Colour.RED else -y, (), "of type (Colour|EnumType)"),
    "own number": (lambda t, y: y * money, (), "`money`, of type Money"),
    "argument": (lambda t, y, p: p["k"] * y, (table,), "argument is of type dict"),
    "list among args": (lambda t, y, p: p[0] * y, (rates,), "argument is of type list"),
    "object": (lambda t, y, p: p.k * y, (plain,), "argument is of type Plain"),
    "random": (lambda t, y: y * np.random.rand(), (), "draws random numbers"),  # noqa: NPY002
    "writes": (counting(), (), "assigns to `count`, a variable outside itself"),
    "recursion": (lambda t, y: -y * deep(t), (), "calls itself"),
}


@pytest.mark.parametrize("name", VALUES)
def test_a_value_that_code_cannot_hold_is_named(name):
    fun, args, said = VALUES[name]
    with pytest.raises(Uncompilable, match=said):
        compiled_function(parts_of(fun, args), DERIVATIVE)


def test_values_are_refused_before_numba_is_imported():
    assert subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, text=True, timeout=120,
        env={**os.environ, "FASTDYN_BUDGET": "inf"}, check=True,
    ).stdout == "False\n"  # fmt: skip


SCRIPT = """
import sys, warnings
import fastdyn
from fastdyn.compile.bind import bind
from fastdyn.compile.mode import DERIVATIVE
table = {"k": 2.0}

def rates(t, y):
    x = y[0]
    while x < 50.0:
        x = x * 1.01 + abs(y[1])
    return [table["k"] * y[1], -y[0] + 1e-9 * x]

with warnings.catch_warnings(record=True):
    warnings.simplefilter("always")
    assert bind(rates, (), DERIVATIVE, 2).function is None
print("numba" in sys.modules)
"""


@numba.njit
def numbas_own(x):
    n = 1
    while x > 1e-3:
        x /= 2
        n *= 3
    return x * (n % 2)


def maybe_assigned(x):
    while x > 0.5:
        last = x
        x /= 2
    return last


OTHERWISE = {  # an expression of y, t: the sentence
    "halved(y[0]) * (len(y) * len(y))": "whole number that may exceed 64 bits",
    "halved(y[0]) * (len(y) ** 2)": "whole number that may exceed 64 bits",
    "halved(y[0]) * (len(y) << 2)": "whole number that may exceed 64 bits",
    "halved(y[0]) * pow(len(y), 2)": "whole number that may exceed 64 bits",
    "halved(y[0]) * (len(y) + len(y))": "whole number that may exceed 64 bits",
    "halved(y[0]) * int(1 + t)": "whole number that may exceed 64 bits",
    "halved(y[0]) * math.floor(1 + t)": "whole number that may exceed 64 bits",
    "halved(y[0]) * (6 // len(y))": "divides by a whole number that may be zero",
    "halved(y[0]) * ((t >= 0) + (t >= 0))": "computes with truth values",
    "halved(y[0]) * abs(~(t >= 0))": "computes with truth values",
    "halved(y[0]) * (2.0 if y is y else 1.0)": "compares identities",
    "maybe_assigned(y[0] + 1.0) + 0.1 * halved(y[0])": "may read `last` before it assigns it",
    "halved(y[0]) + 0 * called(t)": "keyword-only",
}
AS_IN_PYTHON = (
    "halved(y[0]) * (len(y) + 1)",
    "halved(y[0]) * (len(y) // 2 + 1) % 2",
    "halved(y[0]) * (2.0 if y is not None else 1.0)",
    "halved(y[0]) * min(len(y), 3)",
    "halved(y[0]) * numbers[len(y) - 1]",
    "numbas_own(y[0])",
    "halved(y[0]) + float(np.sum(y)) * ((t >= 0) & (y[0] > 0))",
)


def function_of(expression):
    scope = {**globals(), "math": __import__("math")}
    exec(f"def fun(t, y): return [-y[0] * ({expression}), y[0]]", scope)
    return scope["fun"]


def same_as_scipy(fun):
    ours = fastdyn.solve_ivp(fun, (0, 1), [1.0, 0.5])
    theirs = scipy.integrate.solve_ivp(fun, (0, 1), [1.0, 0.5])
    np.testing.assert_allclose(ours.y, theirs.y, rtol=1e-9)


@pytest.mark.parametrize("expression", OTHERWISE)
def test_what_numba_computes_otherwise_runs_in_python(expression):
    fun = function_of(expression)
    with pytest.raises(Uncompilable, match=OTHERWISE[expression]):
        compiled_function(parts_of(fun, ()), DERIVATIVE)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fastdyn.CompileWarning)
        same_as_scipy(fun)


@pytest.mark.parametrize("expression", AS_IN_PYTHON)
def test_what_numba_computes_as_python_is_compiled(expression):
    fun = function_of(expression)
    assert compiled_function(parts_of(fun, ()), DERIVATIVE)[0].address
    same_as_scipy(fun)
