"""Division with remainder, and rounding to decimals, with the bits of Python and NumPy."""

import operator

import numpy as np

from ..graph.kinds import INT
from .symbolic import refuse

EXACT = 2.0**50  # below this size, the rounding error of x 10^k is less than 1/2


def not_caught(a, b):
    """Refuse a division of integers in a handler: Python's raise for zero, NumPy's do not."""
    if any(v.kind == INT and v.node.varies for v in (a, b)) and a.g.in_handler():
        refuse("a division of whole numbers where an exception may be caught")


def floor_division(a, b):
    """The nodes of a // b and a % b; the caller has handled division by zero.

    The quotient is computed from the remainder of C's fmod, because fmod is exact, and a rounded
    quotient is not.
    """
    g, zero = a.g, a.g.const(0.0)
    x, y = a.node, b.node
    rest = g.call("fmod", x, y)
    below, above = g.compare(rest, zero, "lt"), g.compare(rest, zero, "gt")
    other_sign = g.both(
        g.both(below, g.compare(y, zero, "gt")), g.both(above, g.compare(y, zero, "lt")), "or"
    )
    ratio, exact = g.div(x, y), g.div(g.sub(x, rest), y)
    exact = g.select(other_sign, g.sub(exact, g.const(1.0)), exact)
    whole = g.call("floor", exact)
    rounded_down = g.compare(g.sub(exact, whole), g.const(0.5), "gt")
    whole = g.select(rounded_down, g.add(whole, g.const(1.0)), whole)
    by_zero_or_zero = g.both(g.compare(y, zero, "eq"), g.compare(x, zero, "eq"), "or")
    whole = g.select(by_zero_or_zero, ratio, g.select(g.compare(whole, zero, "eq"), zero, whole))
    sign = g.select(g.compare(y, zero, "lt"), g.const(-0.0), zero)
    signed = g.select(other_sign, g.add(rest, y), rest)
    return whole, g.select(g.compare(rest, zero, "eq"), sign, signed)


def to_decimals(a, digits, python=False):
    """round(a, digits); near a tie, and for large values, a Python float is left to Python."""
    digits = operator.index(digits)
    factor = 10.0 ** abs(digits)
    scaled = a * factor if digits > 0 else a / factor
    whole = scaled.to_whole("rint")
    if python:
        g = a.g
        away, size = abs(scaled - whole).node, abs(scaled).node
        certain = g.compare(
            away, g.sub(g.const(0.5), g.mul(size, g.const(2 * np.finfo(float).eps))), "lt"
        )
        g.leaves_to_python_if(g.negation(g.both(certain, g.compare(size, g.const(EXACT), "lt"))))
    return whole / factor if digits > 0 else whole * factor
