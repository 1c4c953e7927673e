"""Elementary functions.  A function that C lacks gets a `formula`."""

import math

import numpy as np

from .domains import nowhere, outside, overflow, overflow_or_nan, poles_of_gamma
from .record import Operation, add

LOG_2, LOG_10 = math.log(2.0), math.log(10.0)
NOT_FINITE = outside("eq", math.inf, True)


def function(name, value, *factors, **facts):
    """The record of a function of C with a factor for each operand; without, none is known."""
    more = {
        "elementary": True, "cost": 20, "in_math": getattr(math, name, None),
        "raises": overflow_or_nan, "recurrence": "integral" if factors else "",
    }  # fmt: skip
    return Operation(name, value, factors or None, **more | facts)


def _of_numbers(function):
    """A function of `math` on arrays; NaN for all elements if the function raises for one."""
    of_arrays = np.vectorize(function, otypes=[float])

    def value(x):
        try:
            return of_arrays(x)[()]
        except (ValueError, OverflowError):
            return np.nan * np.asarray(x)

    return value


def _over(g, number, a):
    return g.div(g.const(number), a)


def _square(g, a):
    return g.mul(a, a)


def _one_plus(g, a):
    return g.add(g.const(1.0), a)


def _one_minus(g, a):
    return g.sub(g.const(1.0), a)


def _one_minus_square(g, a):
    """(1 - a) (1 + a), which keeps its accuracy where a is near 1."""
    return g.mul(_one_minus(g, a), _one_plus(g, a))


def _root(g, a):
    return g.power(a, 0.5)


def _gauss(g, a, sign):
    bell = g.call("exp", g.neg(_square(g, a)))
    return g.mul(g.const(sign * 2 / math.sqrt(math.pi)), bell)


def _power_of_less(g, o, a, e):
    return g.mul(e, g.power(a, g.sub(e, g.const(1.0))))


def _by_exponent(g, o, a, e):
    zero = g.const(0.0)
    return g.select(g.compare(o, zero, "eq"), zero, g.mul(o, g.call("log", a)))


def _inverse_square(g, y, x):
    return _over(g, 1.0, g.add(_square(g, y), _square(g, x)))


def _quotient(g, o, a, b):
    """The whole number of b's in a - o."""
    return g.call("rint", g.div(g.sub(a, o), b))


add(
    function(
        "sin", np.sin, lambda g, o, a: g.call("cos", a),
        raises=NOT_FINITE, llvm="llvm.sin", parity="odd", width=0.0,
    ),
    function(
        "cos", np.cos, lambda g, o, a: g.neg(g.call("sin", a)),
        raises=NOT_FINITE, llvm="llvm.cos", parity="even", width=0.0,
    ),
    function(
        "tan", np.tan, lambda g, o, a: _one_plus(g, _square(g, o)), raises=NOT_FINITE, parity="odd"
    ),
    function(
        "asin", np.arcsin, lambda g, o, a: _over(g, 1.0, _root(g, _one_minus_square(g, a))),
        slopes=(lambda g, o, a: _over(g, 1.0, _root(g, _one_minus(g, _square(g, a)))),),
        raises=outside("gt", 1.0, True), parity="odd", monotone=True,
    ),
    function(
        "acos", np.arccos, lambda g, o, a: _over(g, -1.0, _root(g, _one_minus_square(g, a))),
        slopes=(lambda g, o, a: g.neg(_over(g, 1.0, _root(g, _one_minus(g, _square(g, a))))),),
        raises=outside("gt", 1.0, True), monotone=True,
    ),
    function(
        "atan", np.arctan, lambda g, o, a: _over(g, 1.0, _one_plus(g, _square(g, a))),
        raises=nowhere, parity="odd", width=2.0, monotone=True,
    ),
    function(
        "sinh", np.sinh, lambda g, o, a: g.call("cosh", a),
        raises=overflow, parity="odd", width=8.0, monotone=True,
    ),
    function(
        "cosh", np.cosh, lambda g, o, a: g.call("sinh", a),
        raises=overflow, parity="even", width=8.0,
    ),
    function(
        "tanh", np.tanh, lambda g, o, a: _one_minus_square(g, o),
        slopes=(lambda g, o, a: _one_minus(g, _square(g, o)),),
        raises=nowhere, parity="odd", width=2.0, monotone=True,
    ),
    function(
        "asinh", np.arcsinh, lambda g, o, a: _over(g, 1.0, _root(g, _one_plus(g, _square(g, a)))),
        raises=nowhere, parity="odd", width=2.0, monotone=True,
    ),
    function(
        "acosh", np.arccosh,
        lambda g, o, a: _over(g, 1.0, _root(g, g.neg(_one_minus_square(g, a)))),
        slopes=(lambda g, o, a: _over(g, 1.0, _root(g, g.sub(_square(g, a), g.const(1.0)))),),
        raises=outside("lt", 1.0), monotone=True,
    ),
    function(
        "atanh", np.arctanh, lambda g, o, a: _over(g, 1.0, _one_minus_square(g, a)),
        slopes=(lambda g, o, a: _over(g, 1.0, _one_minus(g, _square(g, a))),),
        raises=outside("ge", 1.0, True), parity="odd", monotone=True,
    ),
    function(
        "exp", np.exp, lambda g, o, a: o,
        raises=overflow, llvm="llvm.exp", width=8.0, monotone=True,
    ),
    function(
        "exp2", np.exp2, lambda g, o, a: g.mul(g.const(LOG_2), o),
        series=lambda g, a: g.call("exp", g.mul(g.const(LOG_2), a)),
        raises=overflow, llvm="llvm.exp2", monotone=True,
    ),
    function(
        "expm1", np.expm1, lambda g, o, a: g.call("exp", a),
        slopes=(lambda g, o, a: _one_plus(g, o),), raises=overflow, width=8.0, monotone=True,
    ),
    function(
        "log", np.log, lambda g, o, a: _over(g, 1.0, a),
        raises=outside("le", 0.0), llvm="llvm.log", monotone=True,
    ),
    function(
        "log2", np.log2, lambda g, o, a: _over(g, 1 / LOG_2, a),
        series=lambda g, a: g.mul(g.const(1 / LOG_2), g.call("log", a)),
        raises=outside("le", 0.0), llvm="llvm.log2", monotone=True,
    ),
    function(
        "log10", np.log10, lambda g, o, a: _over(g, 1 / LOG_10, a),
        series=lambda g, a: g.mul(g.const(1 / LOG_10), g.call("log", a)),
        raises=outside("le", 0.0), llvm="llvm.log10", monotone=True,
    ),
    function(
        "log1p", np.log1p, lambda g, o, a: _over(g, 1.0, _one_plus(g, a)),
        raises=outside("le", -1.0), monotone=True,
    ),
    function(
        "cbrt", np.cbrt, lambda g, o, a: _over(g, 1 / 3, _square(g, o)),
        series=lambda g, a: g.power(a, 1 / 3), raises=nowhere, monotone=True, root=True,
    ),
    function(
        "pow", np.power, _power_of_less, _by_exponent,
        slopes=(lambda g, o, a, e: g.div(g.mul(e, o), a), None),  # for exponents that do not vary
        series=lambda g, a, e: g.call("exp", g.mul(e, g.call("log", a))), llvm="llvm.pow",
    ),
    function(
        "atan2", np.arctan2,
        lambda g, o, y, x: g.mul(x, _inverse_square(g, y, x)),
        lambda g, o, y, x: g.neg(g.mul(y, _inverse_square(g, y, x))),
        slopes=(
            lambda g, o, y, x: g.div(x, g.add(_square(g, x), _square(g, y))),
            lambda g, o, y, x: g.neg(g.div(y, g.add(_square(g, x), _square(g, y)))),
        ),
        raises=nowhere,
        decision=lambda g, o, *operands: g.both(
            *[g.compare(a, g.const(0.0), "lt") for a in operands]
        ),
    ),
    function(
        "fmod", np.fmod, lambda g, o, a, b: g.const(1.0),
        lambda g, o, a, b: g.neg(_quotient(g, o, a, b)), recurrence="", decision=_quotient,
    ),
    function(
        "erf", _of_numbers(math.erf), lambda g, o, a: _gauss(g, a, 1.0),
        raises=nowhere, parity="odd", width=2.0, monotone=True,
    ),
    function(
        "erfc", _of_numbers(math.erfc), lambda g, o, a: _gauss(g, a, -1.0),
        raises=nowhere, width=2.0, monotone=True,
    ),
    function("tgamma", _of_numbers(math.gamma), in_math=math.gamma, raises=poles_of_gamma),
    function("lgamma", _of_numbers(math.lgamma), aliases=("gammaln",)),
    Operation("expit", formula=lambda g, a: _over(g, 1.0, _one_plus(g, g.call("exp", g.neg(a))))),
)  # fmt: skip
