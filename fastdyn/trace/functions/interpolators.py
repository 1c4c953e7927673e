"""SciPy's interpolators of one variable, by pieces: polynomials between knots, or constants.

Each `form_of` an interpolator is written once for numbers and arrays of any length.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ..symbols.arithmetic import call, where
from ..symbols.lift import joint, symbol
from ..symbols.symbol import Symbol, graph_of, refuse
from .grids import of_bivariate, of_regular_grid
from .ufuncs import as_numpy

RULES = {"extrapolate": 0, "zeros": 1, "raise": 2, "const": 3}  # FITPACK's, outside the range


class Form(NamedTuple):
    """The computation of an interpolator.

    Parameters
    ----------
    columns : list
        For each component, a function of a symbol.
    shape : tuple
        Shape of the value at one number.
    ends : (float, float)
        The range of definition.
    outside : None, str or (sequence, sequence)
        Values of the components below and above the range.  With None, the components extrapolate.
        A str is the message of the exception that the interpolator raises outside the range.
    axis : int
        The place in `shape` at which the axes of the argument are inserted.
    period : float or None
    finite : bool
        Whether infinite arguments are left to Python, because their result depends on the order of
        operations.
    """

    columns: list
    shape: tuple
    ends: tuple
    outside: Any = None
    axis: int = 0
    period: Any = None
    finite: bool = True

    def __call__(self, x) -> Any:
        g = graph_of(x)
        v: Any = as_numpy(symbol(g, x))
        v = v + 0.0 if v.kind in "bi" else v
        low, high = self.ends
        if self.finite and self.outside is None:
            infinite = g.map("eq", g.map("abs", v.ids), g.const(math.inf).key)
            g.leaves_to_python_if(g.anywhere(infinite))
        if self.period is not None:
            v = low + call("remainder", v - low, self.period)
        if isinstance(self.outside, str):
            for beyond in ((v.ids, g.const(low).key), (g.const(high).key, v.ids)):
                g.raises_if(g.anywhere(g.map("lt", *beyond)), self._raise)
        values = [at(v) for at in self.columns]
        if isinstance(self.outside, tuple):
            ends = zip(values, *self.outside, strict=True)
            values = [where(v < low, a, where(v > high, b, inside)) for inside, a, b in ends]
        if not self.shape:
            return values[0]
        found = symbol(g, values)
        found = found.reshape(self.shape + found.ids.shape[1:])
        n = range(len(self.shape), found.ids.ndim)
        return np.moveaxis(found, n, range(self.axis, self.axis + len(n)))

    def _raise(self):
        raise ValueError(self.outside)


def polynomials(x, c, nu=0, nan=True):
    """The nu-th derivative of the sum over k of c[k] (v - x_i)^(m - k) between knots x.

    `nan` tells whether the value at NaN is NaN even if the pieces are constant.
    """
    for _ in range(nu):
        c = c[:-1] * np.arange(len(c) - 1, 0, -1.0)[:, None] if len(c) > 1 else 0 * c
    rows = [np.ascontiguousarray(row, float) for row in (x, *c)]

    def at(v):
        names = tuple([v.g.constant_table(row) for row in rows])
        found = Symbol(v.g, v.g.map("piecewise", v.ids, data=names))
        return where(call("isnan", v), math.nan, found) if len(c) == 1 and nan else found

    return at


def steps(bounds, heights, side, shift=0, nan=False):
    """``heights[searchsorted(bounds, v, side) + shift]``, with the index clipped to `heights`."""
    bounds = np.ascontiguousarray(bounds, float)
    places = np.arange(len(bounds) + 1) + shift
    heights = np.ascontiguousarray(heights[np.clip(places, 0, len(heights) - 1)], float)

    def at(v):
        g = v.g
        place = g.map("search", v.ids, data=(g.constant_table(bounds), side))
        found = Symbol(g, g.map("table", place, data=g.constant_table(heights)))
        return where(call("isnan", v), math.nan, found) if nan else found

    return at


def _columns(c, axes, made):
    """``made(coefficients)`` for each component; axes from `axes` on count the components."""
    each = np.moveaxis(c.reshape(*c.shape[:axes], -1), -1, 0)
    return [_complex(made(one.real), made(one.imag)) if c.dtype == complex else made(one)
            for one in each]  # fmt: skip


def _complex(real, imag):
    return lambda v: joint(real(v), imag(v))


def n_places(value, name):
    """The number of arguments of a method that are places of an interpolator; 0: has no Form."""
    from scipy import interpolate

    if isinstance(
        value, interpolate.BivariateSpline | interpolate._fitpack2._DerivedBivariateSpline
    ):
        return 2 if name in ("__call__", "ev") else 0
    return int(name == "__call__")


def form_of(value, name, *args, **kwargs) -> Any:
    """The computation of a method of an interpolator with these further arguments, or None."""
    from scipy import interpolate

    made = {
        interpolate.PPoly: _of_polynomials, interpolate.BSpline: _of_b_spline,
        interpolate.UnivariateSpline: _of_univariate, interpolate.interp1d: _of_interp1d,
        interpolate.RegularGridInterpolator: of_regular_grid,
        interpolate.BivariateSpline: of_bivariate,
        interpolate._fitpack2._DerivedBivariateSpline: of_bivariate,
    }  # fmt: skip
    make = next((make for kind, make in made.items() if isinstance(value, kind)), None)
    if name == "ev":
        kwargs = kwargs | {"grid": False}
    return make and make(value, *args, **kwargs)


def _are_knots(x):
    return x.dtype.kind in "fiu" and len(x) > 1 and bool(np.all(np.diff(x) > 0))


def _bounded(columns, shape, ends, extrapolate, axis):
    ends = tuple(map(float, ends))
    n = len(columns)
    period = ends[1] - ends[0] if extrapolate == "periodic" else None
    outside = None if extrapolate else ([math.nan] * n, [math.nan] * n)
    return Form(columns, shape, ends, outside, axis, period)


def _of_polynomials(value, nu=0, extrapolate=None):
    extrapolate = value.extrapolate if extrapolate is None else extrapolate
    x = value.x
    c = value.c
    if not _are_knots(x) or c.dtype not in (float, complex):
        return None
    columns = _columns(c, 2, lambda each: polynomials(x, each, nu))
    return _bounded(columns, c.shape[2:], (x[0], x[-1]), extrapolate, value.axis)


def _of_b_spline(value, nu=0, extrapolate=None):
    t = value.t
    c = value.c
    k = value.k
    extrapolate = value.extrapolate if extrapolate is None else extrapolate
    n = len(t) - k - 1
    columns = _of_knots(t, c[:n], k, nu)
    if columns is None or nu > k:
        return None
    return _bounded(columns, c.shape[1:], (t[k], t[n]), extrapolate, value.axis)


def _of_knots(t, c, k, nu=0, nan=True):
    """The components of a spline with knots t; None if SciPy would divide by zero."""
    from scipy import interpolate

    n = len(t) - k - 1
    if c.dtype not in (float, complex) or np.any(np.diff(t) < 0) or not t[k] < t[n]:
        return None
    if k == 0:
        return _columns(c, 1, lambda each: steps(t, 0 * each if nu else each, "right", -1, nan))
    if t[k] == t[k + 1] or t[n - 1] == t[n]:
        return None
    inner = np.arange(k, n)[np.diff(t)[k:n] > 0]
    x = np.append(t[inner], t[inner[-1] + 1])

    def pieces(each):
        whole = interpolate.PPoly.from_spline((t, np.append(each, np.zeros(k + 1)), k))
        return polynomials(x, whole.c[:, inner], nu, nan)

    return _columns(c, 1, pieces)


def _of_univariate(value, nu=0, ext: Any = None):
    return _of_fitpack(value._eval_args, nu, value.ext if ext is None else ext, value)


def _of_fitpack(tck, nu, ext, value_at: Any = None):
    """The Form of a spline with FITPACK's rule `ext` outside the range; None if there is none."""
    t, c, k = tck
    n = len(t) - k - 1
    ext = RULES.get(ext, ext)
    columns = _of_knots(t, c[:n], k, nu, nan=False)
    if columns is None or ext not in (0, 1, 2, 3) or (ext == 3 and (nu or not value_at)):
        return None
    ends = float(t[k]), float(t[n])
    outside: Any = [None, ([0.0], [0.0]), "outside the range of the interpolation"]
    if ext == 3:
        outside.append(tuple([float(value_at(end))] for end in ends))
    return Form(columns, (), ends, outside[ext])


def _of_interp1d(value):
    x = value.x
    y = value._y
    shape = value._y_extra_shape
    how = value._call.__name__
    if not _are_knots(x) or y.dtype not in (float, complex) or type(x) is not np.ndarray:
        return None
    if how == "_call_linear_np":
        plain = np.asarray(value.y)
        columns = [lambda v: np.interp(v, x, plain)] if plain.shape == x.shape else None
    elif how == "_call_linear":
        slopes = np.diff(y, axis=0) / np.diff(x)[:, None]
        columns = _columns(np.array([slopes, y[:-1]]), 2, lambda c: polynomials(x, c))
    elif how == "_call_nearest":
        columns = _columns(y, 1, lambda c: steps(value.x_bds, c, value._side))
    elif how == "_call_previousnext":
        shift = value._ind - 1
        columns = _columns(y, 1, lambda c: steps(value._x_shift, c, value._side, shift))
    else:
        spline = value._spline
        columns = _of_knots(spline.t, spline.c.reshape(len(spline.c), -1), spline.k)
    if columns is None:
        return None
    outside: Any = None
    if value.bounds_error and not value._extrapolate:
        outside = "A value in x_new is outside the interpolation range."
    elif not value._extrapolate:
        fills = value._fill_value_below, value._fill_value_above
        outside = tuple([_filled(fill, shape) for fill in fills])
    finite = how in ("_call_spline", "_call_linear")  # SciPy 1.18 changed their operations
    ends = float(x[0]), float(x[-1])
    return Form(columns, shape, ends, outside, value._y_axis, None, finite)


def _filled(fill, shape):
    """A value outside the range for each component; SciPy's own end values are flat."""
    fill = fill if np.size(fill) == math.prod(shape) else np.broadcast_to(fill, shape)
    return np.ravel(fill).tolist()


def evaluated(x, tck, der=0, ext=0):
    """scipy.interpolate.splev."""
    t, c, k = tck
    t, c = (v.plain() if type(v) is Symbol else np.asarray(v) for v in (t, c))
    form: Any = _of_fitpack((t, c, int(k)), int(der), ext)
    if form is None:
        refuse("splev in this spline")
    return form(x)
