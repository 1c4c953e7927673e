"""Formulas of elementwise functions on ids, for numbers and arrays of any length."""

import functools
import math
from typing import Any

from ...operations import OPERATIONS
from ...operations.domains import LARGEST
from ...operations.value import by_rule

LARGE, SMALL = 1e300, 1e-280  # the square root of a sum of squares in this range is accurate


class OnIds:
    """The graph as the rules of `operations` see it, with ids and arrays of ids for values."""

    def __init__(self, g):
        self.g, self.tables = g, g.tables

    def const(self, value):
        return self.g.const(value).key

    def call(self, name, *args, data=None):
        formula = OPERATIONS[name].formula
        return by_rule(self, formula, *args) if formula else self.g.map(name, *args, data=data)


def _two(op, swap=False):
    return (lambda g, a, b: g.map(op, b, a)) if swap else (lambda g, a, b: g.map(op, a, b))


def rounded(how):
    return lambda g, a: g.map(how, a)


def _scaled(factor):
    return lambda g, a: g.map("mul", a, g.const(factor).key)


def _picked(first, other, missing):
    """The larger or smaller of two numbers; `missing` tells which NaN decides."""

    def formula(g, a, b):
        nan = g.map("not", g.map("eq", *((a, a) if missing == "a" else (b, b))))
        return g.map("select", g.map("or", g.map("le", *((b, a) if first else (a, b))), nan), a, b)

    return formula


def _is_nan(g, a):
    return g.map("not", g.map("eq", a, a))


def _below_zero(g, a):
    """Whether the sign of a number is set, also that of a zero."""
    zero = g.const(0.0).key
    inverse = g.map("div", g.const(1.0).key, a)
    at_zero = g.map("and", g.map("eq", a, zero), g.map("lt", inverse, zero))
    return g.map("or", g.map("lt", a, zero), at_zero)


def _by_sign(g, a, below, above, at):
    """`below`, `above` or `at` by the sign of a; NaN stays."""
    zero = g.const(0.0).key
    at = g.map("select", g.map("eq", a, zero), at, a)
    over = g.map("select", g.map("lt", zero, a), above, at)
    return g.map("select", g.map("lt", a, zero), below, over)


def _copysign(g, a, b):
    size = g.map("abs", a)
    return g.map("select", _below_zero(g, b), g.map("neg", size), size)


def hypotenuse(g, *ids):
    """The square root of a sum of squares, valid if no square overflows or underflows."""
    squares = functools.reduce(_two("add").__get__(g), [g.map("mul", a, a) for a in ids])
    zero = g.const(0.0).key
    g.stays_below(g.anywhere(g.map("lt", g.const(LARGE).key, squares)))
    some = functools.reduce(
        _two("or").__get__(g), [g.map("not", g.map("eq", a, zero)) for a in ids]
    )
    small = g.map("and", g.map("lt", squares, g.const(SMALL).key), some)
    g.stays_below(g.anywhere(small))
    return g.map("sqrt", squares)


def divided(g, x, y):
    """x // y and x % y; the caller has handled division by zero.

    The quotient is computed from the remainder of C's fmod, because fmod is exact, and a rounded
    quotient is not.
    """
    zero, m = g.const(0.0).key, g.map
    rest = m("fmod", x, y)
    below, above = m("lt", rest, zero), m("lt", zero, rest)
    other = m("or", m("and", below, m("lt", zero, y)), m("and", above, m("lt", y, zero)))
    ratio, exact = m("div", x, y), m("div", m("sub", x, rest), y)
    exact = m("select", other, m("sub", exact, g.const(1.0).key), exact)
    whole = m("floor", exact)
    down = m("lt", g.const(0.5).key, m("sub", exact, whole))
    whole = m("select", down, m("add", whole, g.const(1.0).key), whole)
    by_zero = m("or", m("eq", y, zero), m("eq", x, zero))
    whole = m("select", by_zero, ratio, m("select", m("eq", whole, zero), zero, whole))
    sign = m("select", m("lt", y, zero), g.const(-0.0).key, zero)
    signed = m("select", other, m("add", rest, y), rest)
    return whole, m("select", m("eq", rest, zero), sign, signed)


COMPARISONS: dict[str, Any] = {
    "less": _two("lt"), "less_equal": _two("le"), "greater": _two("lt", True),
    "greater_equal": _two("le", True), "equal": _two("eq"),
    "not_equal": lambda g, a, b: g.map("not", g.map("eq", a, b)),
}  # fmt: skip


FORMULAS: dict[str, Any] = {
    "add": _two("add"), "subtract": _two("sub"), "multiply": _two("mul"), "divide": _two("div"),
    "negative": lambda g, a: g.map("neg", a), "positive": lambda g, a: a,
    "absolute": lambda g, a: g.map("abs", a), "sqrt": lambda g, a: g.map("sqrt", a),
    "conjugate": lambda g, a: a, "square": lambda g, a: g.map("mul", a, a),
    "reciprocal": lambda g, a: g.map("div", g.const(1.0).key, a),
    **{how: rounded(how) for how in ("floor", "ceil", "trunc", "rint")},
    "maximum": _picked(True, None, "a"), "minimum": _picked(False, None, "a"),
    "fmax": _picked(True, None, "b"), "fmin": _picked(False, None, "b"),
    "sign": lambda g, a: _by_sign(g, a, g.const(-1.0).key, g.const(1.0).key, g.const(0.0).key),
    "heaviside": lambda g, a, at: _by_sign(g, a, g.const(0.0).key, g.const(1.0).key, at),
    "copysign": _copysign,
    "hypot": hypotenuse, "signbit": _below_zero, "isnan": _is_nan,
    "isfinite": lambda g, a: g.map("le", g.map("abs", a), g.const(LARGEST).key),
    "isinf": lambda g, a: g.map("eq", g.map("abs", a), g.const(math.inf).key),
    "deg2rad": _scaled(math.pi / 180.0), "rad2deg": _scaled(180.0 / math.pi),
    **COMPARISONS,
}  # fmt: skip
