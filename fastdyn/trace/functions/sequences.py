"""Sorting, differences, running sums, interpolation and searches on symbols."""

from typing import Any

import numpy as np

from ..graph.rows import ID
from ..symbols.arithmetic import call, where
from ..symbols.lift import joint, symbol
from ..symbols.symbol import Symbol, graph_of, is_symbolic, refuse
from .arrays import array_of, place_of
from .ufuncs import as_numpy

LEAST = 9  # entries of a table in which the nearest one is searched
MAX_SORTED = 32  # 191 exchanges; compiling takes a second for 100 numbers, 3 s for 1000


def in_order(a, axis: Any = -1, *more, **options):
    """np.sort by a network of exchanges; NaN comes last."""
    if any(v is not None for v in (*more, *options.values())):
        refuse("np.sort with options")
    a = array_of(a)
    a, axis = (a.ravel(), 0) if axis is None else (a, axis)
    rows: Any = np.moveaxis(a, axis, 0).copy()
    if len(rows) > MAX_SORTED:
        refuse("np.sort of so much that depends on the state")
    for low, high in _exchanges(len(rows)):
        x = rows[low]
        y = rows[high]
        exchanged = call("logical_or", call("less", y, x), call("isnan", x))
        rows[low], rows[high] = where(exchanged, y, x), where(exchanged, x, y)
    return np.moveaxis(rows, 0, axis)


def _exchanges(n):
    """The pairs of places that each pass of a sorting network compares.

    This is Batcher's merge exchange: D. E. Knuth, "The Art of Computer Programming", volume 3,
    section 5.2.2, algorithm M.
    """
    first = 1 << (n - 1).bit_length() >> 1
    p = first
    while p:
        q = first
        r = 0
        d = p
        while True:
            low = np.arange(n - d)
            low = low[low & p == r]
            yield low, low + d
            if q == p:
                break
            d = q - p
            q = q // 2
            r = p
        p //= 2


def _accumulate(name):
    def function(a, axis=None, dtype=None, out=None):
        a = array_of(a)
        a, axis = (a.ravel(), 0) if axis is None else (a, axis)
        return getattr(np, name).accumulate(a, axis, dtype=dtype, out=out)

    return function


def interpolated(x, xp, fp, left=None, right=None):
    """The functions in C behind np.interp."""
    g = graph_of(x, xp, fp, left, right)
    x, xp, fp = (as_numpy(symbol(g, v)) for v in (x, xp, fp))
    n = len(xp)
    if len(fp) != n:
        raise ValueError("fp and xp are not of the same length.")
    if fp.kind == "c":
        ends = [
            [None if v is None else symbol(g, v).part(i) for v in (left, right)] for i in (0, 1)
        ]
        return joint(*[interpolated(x, xp, fp.part(i), *ends[i]) for i in (0, 1)])
    names = _table(g, xp), _table(g, fp)
    if n == 0 or None in names or not g.ascending(names[0]):
        refuse("np.interp in a table that does not increase")
    if n == 1:
        inside = fp[0]
    else:
        between = Symbol(g, g.map("interpolate", x.ids, data=names))
        inside = where(call("equal", x, xp[-1]), fp[-1], between)
    left = fp[0] if left is None else left
    right = fp[-1] if right is None else right
    return where(call("less", x, xp[0]), left, where(call("greater", x, xp[-1]), right, inside))


def _table(g, s):
    """The name of a table; numbers that are no part of one array become part of the code."""
    if not s.many or s.ids.ndim != 1 or s.kind not in "fi":
        return None
    name = g.table_name(s.ids)
    return g.constant_table(s.plain() + 0.0) if name is None and not s.varies else name


def whereabouts(a, v, side="left", sorter=None):
    """np.searchsorted."""
    if sorter is not None:
        refuse("np.searchsorted with a sorter")
    if side not in ("left", "right"):
        raise ValueError(f"search side must be 'left' or 'right' (got '{side}')")
    g = graph_of(v, a)
    a = symbol(g, a)
    v = symbol(g, v)
    name = _table(g, a)
    if name is None or not g.ascending(name):
        refuse("np.searchsorted in what does not increase")
    return Symbol(g, g.map("search", v.ids, data=(name, side)), "i")


def binned(x, bins, right=False):
    """np.digitize."""
    g = graph_of(x, bins)
    side = "left" if right else "right"
    table = symbol(g, bins)
    name = _table(g, table)
    if name is not None and g.ascending(name):
        return whereabouts(table, x, side)
    reverse = symbol(g, table.plain()[::-1].copy())
    found: Any = whereabouts(reverse, x, side)
    return len(table) - found


def place_of_least(a, *args, **kwargs):
    """np.argmin, of the distances from a number to a table by searches."""
    found = None if args or kwargs else _nearest(array_of(a))
    return _place_of_minimum(a, *args, **kwargs) if found is None else found


_place_of_minimum = place_of("minimum")


def _nearest(distances):
    """The place of the nearest entry, of ``abs(table - x)``; None of anything else.

    The table never decreases, so that one of the two entries around x is the nearest.  Of equal
    entries the first one counts.  Where an earlier entry is as near by rounding, Python decides.
    """
    g = distances.g
    table, i = _of_distances(g, distances.ids)
    if table is None:
        return None
    name = g.table_name(table)
    if name is None or not g.ascending(name):
        return None
    x = Symbol(g, i)

    def search(v) -> Any:
        return Symbol(g, g.map("search", v.ids, data=(name, "left")))

    def entry(place):
        return Symbol(g, g.map("table", place.ids, data=name))

    def distance(v):
        return call("absolute", call("subtract", v, x))

    behind = search(x)
    low = entry(call("maximum", behind - 1.0, 0.0))
    high = entry(call("minimum", behind, table.size - 1.0))
    nearest = where(call("less_equal", distance(low), distance(high)), low, high)
    first = search(nearest)
    before = entry(call("maximum", first - 1.0, 0.0))
    as_near = call("equal", distance(before), distance(nearest))
    g.leaves_to_python_if(call("logical_and", call("greater", first, 0.0), as_near).ids)
    return Symbol(g, symbol(g, where(call("isnan", x), 0.0, first)).ids, "i")


def _of_distances(g, ids) -> Any:
    """The ids of a table and of x, whose distances are given; None, None if they are none."""
    if ids.ndim != 1 or ids.size < LEAST:
        return None, None
    row = g.row_at(int(ids[0]))
    if row is not None:
        inner: Any = row.args[0] if row.op == "abs" and row.size == ids.size else 0
        row = None if type(inner) is int else g.row_at(int(inner[0]))
        if row is None or row.op != "sub" or not np.array_equal(inner, g.ids(row).ravel()):
            return None, None
        pair = [np.broadcast_to(a, row.size).tolist() for a in row.args]
    else:
        inner = [node.args[0] for node in map(g.node, ids.tolist()) if node.op == "abs"]
        if len(inner) < ids.size or any(node.op != "sub" for node in inner):
            return None, None
        pair = [[node.args[k].key for node in inner] for k in (0, 1)]
    for table, x in (pair, pair[::-1]):
        if len(set(x)) == 1:
            return np.array(table, ID), x[0]
    return None, None


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


FUNCTIONS: dict[Any, Any] = {
    np.cumsum: _accumulate("add"), np.cumprod: _accumulate("multiply"),
    np.sort: in_order, np.partition: lambda a, kth, *axis, **named: in_order(a, *axis, **named),
    np.searchsorted: whereabouts, np.digitize: binned, np.argmin: place_of_least,
}  # fmt: skip
