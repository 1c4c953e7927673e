"""np.interp, np.searchsorted and np.digitize of symbols."""

import numpy as np

from ..graph.kinds import INT
from ..symbols.arrays import Array, elementwise
from ..symbols.complex_pair import Pair, is_complex, parts
from ..symbols.conditions import select
from ..symbols.lazy import complete
from ..symbols.real import Symbol, symbol
from ..symbols.symbolic import Lazy, graph_of, is_symbolic, refuse
from .operands import ascending, numbers, operand


def interpolated(x, xp, fp, left=None, right=None, period=None):
    """np.interp; the table may consist of parameters."""
    g = graph_of(x, xp, fp, left, right)
    x = complete(x)
    if period is not None:
        return _periodic(x, xp, fp, float(period))
    if len(fp) != len(xp):
        raise ValueError("fp and xp are not of the same length.")
    may_be_complex = fp.dtype.kind in "cO" if isinstance(fp, np.ndarray) else True
    if may_be_complex and not isinstance(fp, Lazy) and any(map(is_complex, fp)):
        return _of_complex(x, xp, complete(fp), left, right)
    knots, heights = operand(g, xp), operand(g, fp)
    n = len(knots.known)
    if n == 0 or not ascending(g, knots):
        refuse("np.interp in a table that does not increase")
    left = heights.at(0) if left is None else left
    right = heights.at(-1) if right is None else right

    def one(v):
        v = symbol(g, v)
        if n == 1:
            inside = heights.at(0)
        else:
            names = knots.name, heights.name
            between = Symbol(g, g.make("interpolate", (v.node,), names))
            inside = select(v == knots.at(-1), heights.at(-1), between)
        return select(v < knots.at(0), left, select(v > knots.at(-1), right, inside))

    return elementwise(one, x)


def _periodic(x, xp, fp, period):
    if period == 0:
        raise ValueError("period must be a non-zero value")
    period, knots, heights = abs(period), numbers(xp), numbers(fp)
    if len(knots) != len(heights):
        raise ValueError("fp and xp are not of the same length.")
    knots = knots % period
    order = np.argsort(knots)
    knots, heights = knots[order], heights[order]
    knots = np.concatenate([knots[-1:] - period, knots, knots[:1] + period])
    heights = np.concatenate([heights[-1:], heights, heights[:1]])
    return interpolated(np.remainder(x, period), knots, heights)


def _of_complex(x, xp, fp, left, right):
    real = [None if v is None else parts(v)[0] for v in (left, right)]
    imag = [None if v is None else parts(v)[1] for v in (left, right)]
    a = interpolated(x, xp, Array.of(fp).real, *real)
    b = interpolated(x, xp, Array.of(fp).imag, *imag)
    return elementwise(Pair, a, b)


def whereabouts(a, v, side="left", sorter=None):
    """np.searchsorted."""
    if sorter is not None:
        refuse("np.searchsorted with a sorter")
    if side not in ("left", "right"):
        raise ValueError(f"search side must be 'left' or 'right' (got '{side}')")
    g = graph_of(v, a)
    table = operand(g, a)
    if not ascending(g, table):
        refuse("np.searchsorted in what does not increase")

    def one(x):
        return Symbol(g, g.make("search", (symbol(g, x).node,), (table.name, side)), INT)

    return elementwise(one, complete(v))


def binned(x, bins, right=False):
    """np.digitize."""
    g, side = graph_of(x, bins), "left" if right else "right"
    table = operand(g, bins)
    if ascending(g, table):
        return whereabouts(bins, x, side)
    return len(table.known) - whereabouts(complete(bins)[::-1], x, side)


def bisected(plain, side):
    """A function of `bisect`; NaN comes first in bisect_left and last in bisect_right."""

    def function(a, x, lo=0, hi=None, *, key=None):
        if not is_symbolic([a, x]):
            return plain(a, x, lo, hi, key=key)
        if lo or hi is not None or key is not None:
            refuse("bisect in a part of a list, or with a key")
        x = symbol(graph_of(a, x), x)
        found = whereabouts(a, x, side)
        return select(x.nan(), 0, found) if side == "left" else found

    return function
