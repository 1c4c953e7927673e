"""SciPy's maps of several variables on a grid, bilinear ones and tensor products of splines.

The value is a sum over the products of the weights of all axes: at the place v, an axis gives the
first coefficient that counts, and the weights of this coefficient and of those behind it.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ..symbols.arithmetic import call, where
from ..symbols.lift import joint, symbol
from ..symbols.symbol import Symbol, graph_of, refuse
from .arrays import array_of
from .ufuncs import as_numpy

OUT = "One of the requested xi is out of bounds in dimension {}"


class Axis(NamedTuple):
    """One axis of a grid.

    Parameters
    ----------
    weights : function
        ``weights(v)`` of a symbol v: the index of the first coefficient, and the weights.
    n : int
        The number of coefficients along the axis.
    ends : (number, number)
        The range of definition.
    """

    weights: Any
    n: int
    ends: tuple


def _row(g, row):
    """The name of a table: of constants, or of parameters, which has a name already."""
    return row if type(row) is str else g.constant_table(np.ascontiguousarray(row, float))


def _read(i, row) -> Any:
    return Symbol(i.g, i.g.map("table", i.ids, data=_row(i.g, row)))


def _piece(v, knots, n) -> Any:
    """The index of the piece between two of n knots that contains v; the outer ones have no end."""
    data = _row(v.g, knots), _row(v.g, np.arange(n))
    return Symbol(v.g, v.g.map("piecewise", v.ids, data=data))


def _pieces(knots, n, method):
    """The Axis of the nearest knot, or of chords between knots."""

    def weights(v):
        i = _piece(v, knots, n)
        low = _read(i, knots)
        share = (v - low) / (_read(i + 1.0, knots) - low)
        if method == "nearest":
            return i + where(share <= 0.5, 0.0, 1.0), [1.0]
        return i, [1.0 - share, share]

    return Axis(weights, n, ())


def _spline(t, k, nu=0):
    """The Axis of the B-splines of degree k with knots t, or of their nu-th derivatives.

    In each piece, k + 1 B-splines differ from zero.  Those with numbers that differ by k + 1 never
    meet, so that one conversion by SciPy gives the polynomials of all.  None for other knots.
    """
    from scipy import interpolate

    n = len(t) - k - 1
    ends = float(t[k]), float(t[n])
    inner = np.arange(k, n)[np.diff(t)[k:n] > 0]
    if np.any(np.diff(t) < 0) or not ends[0] < ends[1] or nu > k:
        return None
    if k == 0 or len(inner) < n - k:  # pieces of constants, and knots that meet
        return None
    colours = np.append(np.arange(n) % (k + 1), np.full(k + 1, -1))
    c = np.stack([
        interpolate.PPoly.from_spline((t, 1.0 * (colours == colour), k)).c[:, k:n]
        for colour in range(k + 1)
    ], axis=-1)  # fmt: skip
    for _ in range(nu):
        c = c[:-1] * np.arange(len(c) - 1, 0, -1.0)[:, None, None]
    pieces = np.arange(n - k)
    knots = t[k : n + 1]

    def weights(v):
        i = _piece(v, knots, len(knots))
        at = v - _read(i, knots)
        found = []
        for a in range(k + 1):
            coefficients = c[:, pieces, (pieces + a) % (k + 1)]
            total = _read(i, coefficients[0])
            for row in coefficients[1:]:
                total = total * at + _read(i, row)
            found.append(total)
        return i, found

    return Axis(weights, n, ends)


class Grid(NamedTuple):
    """The computation of a map.

    Parameters
    ----------
    axes : list of Axis
    columns : list of array or str
        The coefficients of each component in the order of C, or the name of their table.
    shape : tuple
        The shape of the value at one place.
    outside : None, "clip", "raise" or float
        The rule outside the grid: the outer pieces go on; the ends count; an exception; a value.
    stacked : bool
        Whether the map is called with one array whose last axis has the coordinates.
    outer : bool
        Whether the map is called with a row of each coordinate, and gives all pairs.
    """

    axes: list
    columns: Any
    shape: tuple = ()
    outside: Any = None
    stacked: bool = True
    outer: bool = False

    def __call__(self, *places) -> Any:
        g = graph_of(*places)
        places = self._split(g, *places) if self.stacked else [array_of(x) for x in places]
        places = [as_numpy(v + 0.0 if v.kind in "bi" else v) for v in places]
        if any(v.kind == "c" for v in places):
            refuse("a map of complex numbers")
        if self.outer and any(v.ids.size != 1 for v in places):
            refuse("a BivariateSpline at all pairs of two rows, where `ev` takes single pairs")
        shape = np.broadcast_shapes(*[v.ids.shape for v in places])
        if self.outer:
            shape = (1, 1)
            places = [v.reshape(1, 1) for v in places]
        beyond = self._beyond(g, places)
        if self.outside == "clip":
            places = [where(v < a, a, where(v > b, b, v)) for v, (a, b) in self._ranges(places)]
        found = self._values(places)
        if isinstance(self.outside, float):
            found = [where(beyond, self.outside, one) for one in found]
        missing = False
        for v in places:
            missing = missing | call("isnan", v)
        found = [where(missing, math.nan, one) for one in found]
        if not self.shape:
            return found[0]
        return np.stack(found, axis=-1).reshape(shape + self.shape)

    def _split(self, g, xi):
        """The coordinates of SciPy's argument xi, an array or a tuple of arrays."""
        n = len(self.axes)
        if isinstance(xi, tuple) and len(xi) == 1:
            (xi,) = xi
        if isinstance(xi, tuple):
            return [symbol(g, x) for x in np.broadcast_arrays(*map(array_of, xi))]
        xi = array_of(xi)
        if xi.ids.ndim == 1:
            xi = xi.reshape(-1, n if n > 1 else 1)
        if xi.ids.shape[-1] != n:
            refuse("places with another number of coordinates than the map has")
        return [xi[..., i] for i in range(n)]

    def _beyond(self, g, places):
        """Whether a place lies outside the grid; raises, or leaves infinite places to Python."""
        beyond: Any = False
        for i, (v, (low, high)) in enumerate(self._ranges(places)):
            outside = (v < low) | (v > high)
            if self.outside == "raise":
                bad = outside | call("isnan", v)
                g.raises_if(g.anywhere(bad.ids), lambda i=i: _raise(OUT.format(i)))
            elif self.outside is None:
                g.leaves_to_python_if(g.anywhere(call("isinf", v).ids))
            beyond = beyond | outside
        return beyond

    def _ranges(self, places):
        return list(zip(places, [axis.ends for axis in self.axes], strict=True))

    def _values(self, places):
        """The value of each component."""
        strides = np.cumprod([1, *[axis.n for axis in self.axes[:0:-1]]])[::-1].tolist()
        first: Any = 0.0
        weights = []
        for axis, v, stride in zip(self.axes, places, strides, strict=True):
            i, each = axis.weights(v)
            first = first + stride * i
            weights.append(each)

        def total(table, depth, offset):
            if depth == len(weights):
                return _read(first + float(offset), table)
            parts = [
                weight * total(table, depth + 1, offset + a * strides[depth])
                for a, weight in enumerate(weights[depth])
            ]
            return sum(parts[1:], parts[0])

        return [
            joint(total(np.real(column), 0, 0), total(np.imag(column), 0, 0))
            if type(column) is np.ndarray and column.dtype == complex
            else total(column, 0, 0)
            for column in self.columns
        ]


def _raise(sentence):
    raise ValueError(sentence)


def of_regular_grid(value, method=None, *, nu=None):
    """The Grid of a RegularGridInterpolator; None if there is none."""
    knots = value.grid
    values = np.asarray(value.values)
    method = value.method if method is None else method
    if values.dtype not in (float, complex) or any(np.any(np.diff(x) <= 0) for x in knots):
        return None
    n = len(knots)
    if method in ("linear", "nearest") and nu is None and min(map(len, knots)) > 1:
        axes: list = [_pieces(x, len(x), method) for x in knots]
    elif method in ("slinear", "cubic", "quintic"):
        spline = value._spline if method == value.method else value._construct_spline(method)
        orders = [0] * n if nu is None else [int(order) for order in nu]
        each = zip(spline.t, spline.k, orders, strict=True)
        axes = [_spline(t, int(k), order) for t, k, order in each]
        values = np.asarray(spline.c)
    else:
        return None
    if None in axes or values.dtype not in (float, complex):
        return None
    axes = [axis._replace(ends=(float(x[0]), float(x[-1])))
            for axis, x in zip(axes, knots, strict=True)]  # fmt: skip
    fill = None if value.fill_value is None else float(value.fill_value)
    columns = list(values.reshape(math.prod(values.shape[:n]), -1).T)
    return Grid(axes, columns, values.shape[n:], "raise" if value.bounds_error else fill)


def of_bivariate(value, dx=0, dy=0, grid=True):
    """The Grid of a spline of two variables by FITPACK; None if there is none."""
    tx, ty, c = value.tck[:3]
    kx, ky = value.degrees
    if not (0 <= dx < kx or dx == 0) or not (0 <= dy < ky or dy == 0):
        return None
    axes: list = [_spline(tx, kx, dx), _spline(ty, ky, dy)]
    if None in axes:
        return None
    columns = [np.asarray(c, float)[: axes[0].n * axes[1].n]]
    return Grid(axes, columns, (), "clip", stacked=False, outer=bool(grid))


def interpn(points, values, xi, method="linear", bounds_error=True, fill_value=np.nan):
    """scipy.interpolate.interpn, linear or nearest; the numbers of grid and values may change."""
    g = graph_of(xi)
    points = [array_of(x) for x in points]
    values = array_of(values)
    names = [_parameters(g, x) for x in (*points, values)]
    shape = tuple([x.ids.size for x in points])
    if method not in ("linear", "nearest") or None in names or values.ids.shape != shape:
        refuse("interpn in this way")
    if min(shape) < 2 or not all(map(g.ascending, names[:-1])):
        refuse("interpn on a grid that does not increase")
    axes = [
        _pieces(name, len(x), method)._replace(ends=(x[0], x[-1]))
        for name, x in zip(names, points, strict=False)
    ]
    fill = fill_value if fill_value is None else float(fill_value)
    return Grid(axes, [names[-1]], (), "raise" if bounds_error else fill)(xi)


def _parameters(g, s):
    """The name of the table of an array from outside; None for computed numbers."""
    return None if s.kind not in "fi" else g.table_name(s.ids.ravel())
