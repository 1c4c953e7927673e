"""Reading tables: entries, searches, piecewise polynomials, interpolation.

The data of such a node are names of tables of the graph; `value` gets the contents instead.
"""

import numpy as np

from .record import Operation, add
from .value import Value, select

AT = "{}({{length}}, {{tables}}, {{0}})"  # the call of a helper in source


def _entry(table, x):
    i = np.nan_to_num(np.asarray(x, float), nan=0.0, posinf=0.0, neginf=0.0).astype(np.int64)
    return table[np.clip(np.where(i < 0, i + len(table), i), 0, len(table) - 1)]


def _place(knots, x):
    """The index of the piece that contains x."""
    return np.clip(np.searchsorted(knots, x, "right") - 1, 0, len(knots) - 2)


def _piecewise(data, x):
    knots, *coefficients = data
    i = _place(knots, x)
    at = np.asarray(x) - knots[i]
    result = coefficients[0][i]
    for c in coefficients[1:]:
        result = result * at + c[i]
    return result


def _interpolate(data, x):
    """np.interp for x between the first and the last knot."""
    knots, heights = data
    x = np.asarray(x, float)
    i = _place(knots, x)
    left = knots[i]
    right = knots[i + 1]
    low = heights[i]
    high = heights[i + 1]
    slope = (high - low) / (right - left)
    result = slope * (x - left) + low
    result = np.where(np.isnan(result), slope * (x - right) + high, result)
    result = np.where(np.isnan(result) & (low == high), low, result)
    return np.where(np.isnan(x), x, np.where(x == left, low, result))[()]


# -- derivatives


def _piece(knots, x):
    """The index of the piece that contains x."""
    i = x.read("search", (knots, "right")) - 1
    i = select(i < 0, 0.0, i)
    last = len(x.g.tables[knots]) - 2
    return select(i < last, i, last)


def _slope_of_polynomial(o, x):
    knots, *coefficients = o.of.data
    i = _piece(knots, x)
    slope = 0.0
    at = x - i.read("table", knots)
    for k, name in zip(range(len(coefficients) - 1, 0, -1), coefficients[:-1], strict=True):
        c = k * i.read("table", name)
        slope = slope * at + c if isinstance(slope, Value) else c
    return slope


def _slope_of_chord(o, x):
    """The slope of the piece that contains x."""
    i = _piece(o.of.data[0], x)
    knots, heights = ((i + 1).read("table", name) - i.read("table", name) for name in o.of.data)
    return heights / knots


def _inside_table(o, i):
    yield o.of.data, ((i, 1.0),)


def _inside_interpolation(o, x):
    knots, heights = o.of.data
    i = _piece(knots, x)
    odd = np.arange(len(o.g.tables[knots])) % 2
    of_odd = o.g.table(odd)
    at_odd = i.read("table", of_odd)
    teeth = x.read("interpolate", (knots, of_odd))
    share = at_odd + (1.0 - 2.0 * at_odd) * teeth  # of the piece that is before x
    hats = (i, 1.0 - share), (i + 1, share)
    slope = _slope_of_chord(o, x)
    yield heights, hats
    yield knots, tuple([(at, -(slope * hat)) for at, hat in hats])


add(
    Operation("table", _entry, (0.0,), tables=True, inside=_inside_table,
              c=AT.format("entry_of"), js=AT.format("entry_of"),
              words="a table that is read at a place that moves"),
    Operation("search", lambda data, x: np.searchsorted(data[0], x, data[1]) * 1.0, (0.0,),
              c=AT.format("search_{side}"), js=AT.format("search_{side}"),
              tables=True, whole=True, cost=20, decision=lambda o, x: o,
              words="a search in a table"),
    Operation("piecewise", _piecewise, (_slope_of_polynomial,), tables=True, cost=20,
              c="piecewise({length}, {count}, {tables}, {0})", js=AT.format("piecewise"),
              words="a spline"),
    Operation("interpolate", _interpolate, (_slope_of_chord,), tables=True, cost=20,
              c=AT.format("interpolate"), js=AT.format("interpolate"),
              inside=_inside_interpolation, words="interpolation in a table"),
)  # fmt: skip
