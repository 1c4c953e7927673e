"""The length of a vector; a call with squares that overflow or underflow is left to Python."""

from .complex_pair import total
from .real import symbol

LARGE, SMALL = 1e300, 1e-280  # sums of squares in this range are accurate


def hypotenuse(a, *others):
    """The square root of a sum of squares, valid if no square overflows or underflows."""
    squares = total([v * v for v in (a, *others)])
    g, node = squares.g, squares.node
    g.stays_below(g.compare(node, g.const(LARGE), "gt"))
    nonzero = g.false
    for v in (a, *others):
        zero = g.compare(symbol(g, v).node, g.const(0.0), "eq")
        nonzero = g.both(nonzero, g.negation(zero), "or")
    g.stays_below(g.both(g.compare(node, g.const(SMALL), "lt"), nonzero))
    return squares.call("sqrt")
