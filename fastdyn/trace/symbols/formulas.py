"""The records' formulas on ids, and formulas that record conditions of the trace."""

import functools
import operator
from typing import Any

from ..operations import OPERATIONS
from ..operations.value import Value, by_rule, floor, fmod, select, sqrt

LARGE, SMALL = 1e300, 1e-280  # the square root of a sum of squares in this range is accurate


class OnIds:
    """The graph as the rules of `operations` see it, with ids and arrays of ids for values."""

    def __init__(self, g):
        self.g = g
        self.tables = g.tables

    def const(self, value):
        return self.g.const(value).key

    def call(self, name, *args, data=None):
        formula = OPERATIONS[name].formula
        return by_rule(self, formula, *args) if formula else self.g.map(name, *args, data=data)


def hypotenuse(g, *ids):
    """The square root of a sum of squares, valid if no square overflows or underflows."""
    values: list[Any] = [Value(OnIds(g), i) for i in ids]
    squares = functools.reduce(operator.add, [v * v for v in values])
    some = functools.reduce(operator.or_, [v != 0.0 for v in values])
    for beyond in (squares > LARGE, (squares < SMALL) & some):
        g.stays_below(g.anywhere(beyond.of))
    return sqrt(squares).of


def divided(g, x, y):
    """x // y and x % y; the caller has handled division by zero.

    The quotient is computed from the remainder of C's fmod, because fmod is exact, and a rounded
    quotient is not.
    """
    values: Any = [Value(OnIds(g), i) for i in (x, y)]
    x, y = values
    rest = fmod(x, y)
    other = ((rest < 0.0) & (y > 0.0)) | ((rest > 0.0) & (y < 0.0))
    exact = (x - rest) / y
    exact = select(other, exact - 1.0, exact)
    whole = floor(exact)
    whole = select(exact - whole > 0.5, whole + 1.0, whole)
    whole = select((y == 0.0) | (x == 0.0), x / y, select(whole == 0.0, 0.0, whole))
    signed = select(other, rest + y, rest)
    return whole.of, select(rest == 0.0, select(y < 0.0, -0.0, 0.0), signed).of
