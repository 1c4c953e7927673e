"""Elementary functions.  A function that C lacks gets a `formula`."""

import math
from typing import Any

import numpy as np

from .domains import nowhere, outside, overflow, overflow_or_nan, poles_of_gamma
from .record import Operation, add
from .value import cos, cosh, exp, log, power, rint, select, sin, sinh, sqrt

LOG_2 = math.log(2.0)
LOG_10 = math.log(10.0)
BELL = 2 / math.sqrt(math.pi)
INFINITE = outside(lambda a: abs(a) == math.inf, math.inf)
BEYOND_ONE = outside(lambda a: abs(a) > 1, 2.0)
NOT_POSITIVE = outside(lambda a: a <= 0, -2.0)


def function(name, value, *factors, **facts):
    """The record of a function of C with a factor for each operand; without, none is known."""
    usual: dict[str, Any] = {
        "elementary": True, "cost": 20, "in_math": getattr(math, name, None),
        "raises": overflow_or_nan, "recurrence": "integral" if factors else "",
    }  # fmt: skip
    return Operation(name, value, factors or None, **usual | facts)


def _of_numbers(function):
    """A function of `math` on arrays; infinite or NaN where the function raises."""

    def of_one(x):
        try:
            return function(x)
        except OverflowError:
            return math.inf
        except ValueError:
            return math.nan

    of_arrays = np.vectorize(of_one, otypes=[float])
    return lambda x: of_arrays(x)[()]


def _whole(o, a, b):
    """The whole number of b's in a - o."""
    return rint((a - o) / b)


# Slopes keep their accuracy where a is near 1: (1 - a) (1 + a).  For recurrences, 1 - a^2 is less.
add(
    function("sin", np.sin, lambda o, a: cos(a),
             raises=INFINITE, llvm="llvm.sin", parity="odd", width=0.0),
    function("cos", np.cos, lambda o, a: -sin(a),
             raises=INFINITE, llvm="llvm.cos", parity="even", width=0.0),
    function("tan", np.tan, lambda o, a: 1 + o * o, raises=INFINITE, parity="odd"),
    function("asin", np.arcsin, lambda o, a: 1 / sqrt((1 - a) * (1 + a)),
             slopes=(lambda o, a: 1 / sqrt(1 - a * a),),
             raises=BEYOND_ONE, parity="odd", monotone=True),
    function("acos", np.arccos, lambda o, a: -1 / sqrt((1 - a) * (1 + a)),
             slopes=(lambda o, a: -(1 / sqrt(1 - a * a)),), raises=BEYOND_ONE, monotone=True),
    function("atan", np.arctan, lambda o, a: 1 / (1 + a * a),
             raises=nowhere, parity="odd", width=2.0, monotone=True),
    function("sinh", np.sinh, lambda o, a: cosh(a),
             raises=overflow, parity="odd", width=8.0, monotone=True),
    function("cosh", np.cosh, lambda o, a: sinh(a), raises=overflow, parity="even", width=8.0),
    function("tanh", np.tanh, lambda o, a: (1 - o) * (1 + o), slopes=(lambda o, a: 1 - o * o,),
             raises=nowhere, parity="odd", width=2.0, monotone=True),
    function("asinh", np.arcsinh, lambda o, a: 1 / sqrt(1 + a * a),
             raises=nowhere, parity="odd", width=2.0, monotone=True),
    function("acosh", np.arccosh, lambda o, a: 1 / sqrt(-((1 - a) * (1 + a))),
             slopes=(lambda o, a: 1 / sqrt(a * a - 1),),
             raises=outside(lambda a: a < 1, -2.0), monotone=True),
    function("atanh", np.arctanh, lambda o, a: 1 / ((1 - a) * (1 + a)),
             slopes=(lambda o, a: 1 / (1 - a * a),),
             raises=outside(lambda a: abs(a) >= 1, 2.0), parity="odd", monotone=True),
    function("exp", np.exp, lambda o, a: o,
             raises=overflow, llvm="llvm.exp", width=8.0, monotone=True),
    function("exp2", np.exp2, lambda o, a: LOG_2 * o, series=lambda a: exp(LOG_2 * a),
             js="Math.pow(2, {0})", raises=overflow, llvm="llvm.exp2", monotone=True),
    function("expm1", np.expm1, lambda o, a: exp(a), slopes=(lambda o, a: o + 1,),
             raises=overflow, width=8.0, monotone=True),
    function("log", np.log, lambda o, a: 1 / a,
             raises=NOT_POSITIVE, llvm="llvm.log", monotone=True),
    function("log2", np.log2, lambda o, a: 1 / LOG_2 / a, series=lambda a: 1 / LOG_2 * log(a),
             raises=NOT_POSITIVE, llvm="llvm.log2", monotone=True),
    function("log10", np.log10, lambda o, a: 1 / LOG_10 / a, series=lambda a: 1 / LOG_10 * log(a),
             raises=NOT_POSITIVE, llvm="llvm.log10", monotone=True),
    function("log1p", np.log1p, lambda o, a: 1 / (1 + a),
             raises=outside(lambda a: a <= -1, -2.0), monotone=True),
    function("cbrt", np.cbrt, lambda o, a: 1 / 3 / (o * o), series=lambda a: power(a, 1 / 3),
             raises=nowhere, monotone=True, root=True),
    function("pow", np.power, lambda o, a, e: e * power(a, e - 1),
             lambda o, a, e: select(o == 0, 0.0, o * log(a)),
             slopes=(lambda o, a, e: e * o / a, 0.0),  # for exponents that do not vary
             series=lambda a, e: exp(e * log(a)), in_math=None, llvm="llvm.pow",
             js="pow({0}, {1})"),
    function("atan2", np.arctan2, lambda o, y, x: x * (1 / (y * y + x * x)),
             lambda o, y, x: -(y * (1 / (y * y + x * x))),
             slopes=(lambda o, y, x: x / (x * x + y * y), lambda o, y, x: -(y / (x * x + y * y))),
             raises=nowhere, decision=lambda o, y, x: (y < 0) & (x < 0)),
    function("fmod", np.fmod, 1.0, lambda o, a, b: -_whole(o, a, b),
             js="{0} % {1}", recurrence="", decision=_whole),
    function("erf", _of_numbers(math.erf), lambda o, a: BELL * exp(-(a * a)), js="erf({0})",
             raises=nowhere, parity="odd", width=2.0, monotone=True),
    function("erfc", _of_numbers(math.erfc), lambda o, a: -BELL * exp(-(a * a)), js="erfc({0})",
             raises=nowhere, width=2.0, monotone=True),
    function("tgamma", _of_numbers(math.gamma), js="tgamma({0})", in_math=math.gamma,
             raises=poles_of_gamma),
    function("lgamma", _of_numbers(math.lgamma), js="lgamma({0})", aliases=("gammaln",),
             raises=poles_of_gamma),
    Operation("expit", formula=lambda a: 1 / (1 + exp(-a))),
)  # fmt: skip
