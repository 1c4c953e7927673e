"""Sorting, differences, running sums, interpolation and searches on symbols."""

import math
from typing import Any

import numpy as np

from ..symbols.arithmetic import call, stored, where
from ..symbols.lift import joint, symbol
from ..symbols.symbol import Symbol, graph_of, is_symbolic, refuse
from .arrays import array_of
from .ufuncs import as_numpy, reduced

MAX_SORTED = 32  # 496 comparisons of neighbours


def in_order(a, axis: Any = -1, *more, **options):
    """np.sort: exchanges of neighbours; NaN comes last."""
    if any(v is not None for v in (*more, *options.values())):
        refuse("np.sort with options")
    a = array_of(a)
    a = a.ravel() if axis is None else a
    rows = list(np.moveaxis(a, -1 if axis is None else axis, 0))
    if len(rows) > MAX_SORTED:
        refuse("np.sort of so much that depends on the state")
    for end in range(len(rows) - 1, 0, -1):
        for i in range(end):
            x, y = rows[i], rows[i + 1]
            exchanged = call("logical_or", call("less", y, x), call("isnan", x))
            rows[i], rows[i + 1] = where(exchanged, y, x), where(exchanged, x, y)
    return np.moveaxis(np.stack(rows), 0, -1 if axis is None else axis)


def median(a, axis: Any = None, out=None, overwrite_input=False, keepdims=False):
    if keepdims or np.ndim(axis):
        refuse("np.median in this way")
    ordered = in_order(a, axis)
    rows = np.moveaxis(ordered, -1 if axis is None else axis, 0)
    half = len(rows) // 2
    middle = rows[half] if len(rows) % 2 else (rows[half - 1] + rows[half]) / 2.0
    nan = reduced("logical_or", call("isnan", rows), axis=0)
    return stored(where(nan, math.nan, middle), out)


def gradient_of(f: Any, *spacing: Any, axis=None, edge_order=1):
    f = array_of(f)
    axes = range(f.ids.ndim) if axis is None else [int(a) % f.ids.ndim for a in np.atleast_1d(axis)]
    if edge_order not in (1, 2) or len(spacing) > len(axes):
        refuse("np.gradient in this way")
    steps = list(spacing or (1.0,))
    if len(steps) == 1:
        steps *= len(axes)
    found = [_slope(f, i, h, edge_order) for i, h in zip(axes, steps, strict=True)]
    return found[0] if len(found) == 1 else tuple(found)


def _has_axes(value):
    return value.many if type(value) is Symbol else np.ndim(value) > 0


def _slope(f, axis, h: Any, order):
    n = f.ids.shape[axis]
    if n < order + 1:
        raise ValueError("Shape of array too small to calculate a numerical gradient")
    inner = (slice(None),) * axis

    def at(key):
        return f[(*inner, key)]

    if _has_axes(h):
        gaps: Any = np.diff(h)
        known = gaps.plain() if type(gaps) is Symbol and not gaps.varies else gaps
        if not isinstance(known, np.ndarray) or order != 1:
            refuse("np.gradient on a grid that depends on the state")
        if (known == known[0]).all():
            return _slope(f, axis, float(known[0]), order)
        shape = [1] * f.ids.ndim
        shape[axis] = -1
        a, b = known[:-1].reshape(shape), known[1:].reshape(shape)
        middle = (-b / (a * (a + b))) * at(slice(None, -2)) + ((b - a) / (a * b)) * at(
            slice(1, -1)) + (a / (b * (a + b))) * at(slice(2, None))  # fmt: skip
        ends = known[0], known[-1]
    else:
        middle = (at(slice(2, None)) - at(slice(None, -2))) / (2.0 * h)
        ends = h, h
    result = np.zeros_like(f) if f.kind in "fc" else np.zeros_like(f, dtype=float)
    result[(*inner, slice(1, -1))] = middle
    if order == 1:
        result[(*inner, 0)] = (at(1) - at(0)) / ends[0]
        result[(*inner, -1)] = (at(-1) - at(-2)) / ends[1]
    else:
        a, b, c = -1.5 / h, 2.0 / h, -0.5 / h
        result[(*inner, 0)] = a * at(0) + b * at(1) + c * at(2)
        a, b, c = 0.5 / h, -2.0 / h, 1.5 / h
        result[(*inner, -1)] = a * at(-3) + b * at(-2) + c * at(-1)
    return result


def trapezoid(y, x=None, dx=1.0, axis=-1):
    y = np.moveaxis(array_of(y), axis, -1)
    steps = dx if x is None else np.diff(array_of(x) if is_symbolic(x) else x)
    return reduced("add", steps * (y[..., 1:] + y[..., :-1]) / 2.0, axis=-1)


def polynomial(p, x):
    """np.polyval."""
    coefficients = list(array_of(p)) if is_symbolic(p) else list(np.asarray(p))
    result: Any = np.zeros_like(x)
    for c in coefficients:
        result = result * x + c
    return result


def _accumulate(name):
    def function(a, axis=None, dtype=None, out=None, **_):
        a = array_of(a)
        a, axis = (a.ravel(), 0) if axis is None else (a, axis)
        return getattr(np, name).accumulate(a, axis, dtype=dtype, out=out)

    return function


def _interpolated(x, xp, fp, left=None, right=None, period=None):
    """np.interp."""
    g = graph_of(x, xp, fp, left, right)
    x, xp, fp = (as_numpy(symbol(g, v)) for v in (x, xp, fp))
    if period is not None:
        return _periodic(x, xp, fp, float(period))
    n = len(xp)
    if len(fp) != n:
        raise ValueError("fp and xp are not of the same length.")
    if fp.kind == "c":
        ends = [
            [None if v is None else symbol(g, v).part(i) for v in (left, right)] for i in (0, 1)
        ]
        return joint(*[_interpolated(x, xp, fp.part(i), *ends[i]) for i in (0, 1)])
    names = _table(g, xp), _table(g, fp)
    if n == 0 or None in names or not g.ascending(names[0]):
        refuse("np.interp in a table that does not increase")
    if n == 1:
        inside = fp[0]
    else:
        between = Symbol(g, g.map("interpolate", x.ids, data=names))
        inside = where(call("equal", x, xp[-1]), fp[-1], between)
    left, right = (fp[0] if left is None else left), (fp[-1] if right is None else right)
    return where(call("less", x, xp[0]), left, where(call("greater", x, xp[-1]), right, inside))


def _table(g, s):
    """The name of a table; numbers that are no part of one array become part of the code."""
    if not s.many or s.ids.ndim != 1 or s.kind not in "fi":
        return None
    name = g.table_name(s.ids)
    return g.constant_table(s.plain() + 0.0) if name is None and not s.varies else name


def _periodic(x, xp, fp, period):
    if period == 0:
        raise ValueError("period must be a non-zero value")
    period, knots, heights = abs(period), xp.plain(), fp.plain()
    knots = knots % period
    order = np.argsort(knots)
    knots, heights = knots[order], heights[order]
    knots = np.concatenate([knots[-1:] - period, knots, knots[:1] + period])
    heights = np.concatenate([heights[-1:], heights, heights[:1]])
    return _interpolated(np.remainder(x, period), knots, heights)


def whereabouts(a, v, side="left", sorter=None):
    """np.searchsorted."""
    if sorter is not None:
        refuse("np.searchsorted with a sorter")
    if side not in ("left", "right"):
        raise ValueError(f"search side must be 'left' or 'right' (got '{side}')")
    g = graph_of(v, a)
    a, v = symbol(g, a), symbol(g, v)
    name = _table(g, a)
    if name is None or not g.ascending(name):
        refuse("np.searchsorted in what does not increase")
    return Symbol(g, g.map("search", v.ids, data=(name, side)), "i")


def binned(x, bins, right=False):
    """np.digitize."""
    g, side = graph_of(x, bins), "left" if right else "right"
    table = symbol(g, bins)
    name = _table(g, table)
    if name is not None and g.ascending(name):
        return whereabouts(table, x, side)
    reverse = symbol(g, table.plain()[::-1].copy())
    found: Any = whereabouts(reverse, x, side)
    return len(table) - found


def bisected(plain, side):
    """A function of `bisect`; NaN comes first in bisect_left and last in bisect_right."""

    def function(a, x, lo=0, hi=None, *, key=None):
        if not is_symbolic([a, x]):
            return plain(a, x, lo, hi, key=key)
        if lo or hi is not None or key is not None:
            refuse("bisect in a part of a list, or with a key")
        found = whereabouts(a, x, side)
        found = where(call("isnan", x), 0, found) if side == "left" else found
        return Symbol(found.g, found.ids, "i", True) if type(found) is Symbol else found

    return function


def _sinc(x):
    s = as_numpy(symbol(graph_of(x), x))
    angle = s * math.pi
    return where(call("equal", s, 0.0), 1.0, call("sin", angle) / angle)


def angle(z, deg=False):
    z = symbol(graph_of(z), z)
    found = call("arctan2", z.part(1), z.part(0))
    return found * (180.0 / math.pi) if deg else found


TRAPEZOID: Any = getattr(np, "trapezoid", None) or vars(np)["trapz"]  # "trapz" before NumPy 2


FUNCTIONS: dict[Any, Any] = {
    np.cumsum: _accumulate("add"), np.cumprod: _accumulate("multiply"),
    np.sort: in_order, np.median: median, np.gradient: gradient_of, TRAPEZOID: trapezoid,
    np.polyval: polynomial, np.interp: _interpolated, np.searchsorted: whereabouts,
    np.digitize: binned, np.sinc: _sinc, np.angle: angle,
}  # fmt: skip
