"""Reading tables: entries, searches, piecewise polynomials, interpolation.

The data of such a node are names of tables of the graph; `value` gets the contents instead.
"""

import numpy as np

from .record import Operation, add


def _entry(table, x):
    i = np.nan_to_num(np.asarray(x, float), nan=0.0, posinf=0.0, neginf=0.0).astype(np.int64)
    return table[np.clip(np.where(i < 0, i + len(table), i), 0, len(table) - 1)]


def _place(knots, x):
    """The index of the piece that contains x."""
    return np.clip(np.searchsorted(knots, x, "right") - 1, 0, len(knots) - 2)


def _piecewise(data, x):
    knots, *coefficients = data
    i = _place(knots, x)
    at, result = np.asarray(x) - knots[i], coefficients[0][i]
    for c in coefficients[1:]:
        result = result * at + c[i]
    return result


def _interpolate(data, x):
    """np.interp for x between the first and the last knot."""
    knots, heights = data
    x = np.asarray(x, float)
    i = _place(knots, x)
    left, right, low, high = knots[i], knots[i + 1], heights[i], heights[i + 1]
    slope = (high - low) / (right - left)
    result = slope * (x - left) + low
    result = np.where(np.isnan(result), slope * (x - right) + high, result)
    result = np.where(np.isnan(result) & (low == high), low, result)
    return np.where(np.isnan(x), x, np.where(x == left, low, result))[()]


# -- derivatives


def _piece(g, knots, x):
    """The index of the piece that contains x."""
    i = g.sub(g.make("search", (x,), (knots, "right")), g.const(1.0))
    i = g.select(g.compare(i, g.const(0.0), "lt"), g.const(0.0), i)
    last = g.const(len(g.tables[knots]) - 2)
    return g.select(g.compare(i, last, "lt"), i, last)


def _slope_of_polynomial(g, o, x):
    knots, *coefficients = o.data
    i, slope = _piece(g, knots, x), None
    at = g.sub(x, g.make("table", (i,), knots))
    for k, name in zip(range(len(coefficients) - 1, 0, -1), coefficients[:-1], strict=True):
        c = g.mul(g.const(float(k)), g.make("table", (i,), name))
        slope = c if slope is None else g.add(g.mul(slope, at), c)
    return g.const(0.0) if slope is None else slope


def _slope_of_chord(g, o, x):
    """The slope of the piece that contains x."""
    knots, heights = o.data
    i = _piece(g, knots, x)
    after = g.add(i, g.const(1.0))

    def rise(table):
        return g.sub(*[g.make("table", (at,), table) for at in (after, i)])

    return g.div(rise(heights), rise(knots))


def _inside_table(g, o, slots):
    for slot, unit in _units(g, o.data, slots):
        yield slot, g.make("table", o.args, unit)


def _inside_interpolation(g, o, slots):
    knots, heights = o.data
    for slot, unit in _units(g, heights, slots):
        yield slot, g.make("interpolate", o.args, (knots, unit))
    for slot, unit in _units(g, knots, slots):
        share = g.make("interpolate", o.args, (knots, unit))
        yield slot, g.neg(g.mul(_slope_of_chord(g, o, *o.args), share))


def _units(g, name, slots):
    """For each parameter in a table, yield (slot, name of a table with 1 there, 0 elsewhere)."""
    table = g.tables[name]
    if isinstance(table, range):
        for slot in slots:
            if slot in table:
                yield slot, g.table(np.arange(len(table)) == table.index(slot))


add(
    Operation("entry", lambda i, found: found[i]),  # of the results of a library
    Operation(
        "table", _entry, (None,), tables=True, inside=_inside_table,
        words="a table that is read at a place that moves",
    ),
    Operation(
        "search", lambda data, x: np.searchsorted(data[0], x, data[1]) * 1.0, (None,), tables=True,
        whole=True, cost=20, decision=lambda g, o, x: o, words="a search in a table",
    ),
    Operation(
        "piecewise", _piecewise, (_slope_of_polynomial,), tables=True, cost=20, words="a spline"
    ),
    Operation(
        "interpolate", _interpolate, (_slope_of_chord,), tables=True, cost=20,
        inside=_inside_interpolation, words="interpolation in a table",
    ),
    Operation("in c", words="a special function of SciPy"),
)  # fmt: skip
