"""SciPy's interpolators of one variable."""

import math
from typing import Any

import numpy as np

from ..graph.kinds import INT
from ..numpy.interpolation import interpolated
from ..numpy.operands import numbers
from ..numpy.plain_arrays import lowered, raised
from ..symbols.arrays import Array
from ..symbols.lazy import complete
from ..symbols.real import Symbol
from ..symbols.symbolic import Unwritten, graph_of, is_symbolic, refuse
from .interpolator_forms import Form
from .piecewise import ComplexColumn, Line, Polynomials, Steps

NUMBERS = float, complex  # types of coefficients that have a Form
METHODS = {"derivative", "antiderivative", "integrate", "solve", "roots", "integral", "derivatives"}


def _known():
    """{type of interpolators: (attributes that determine an interpolator, maker of its Form)}."""
    from scipy import interpolate

    return {
        interpolate.PPoly: ("x c extrapolate axis", _of_polynomials),
        interpolate.BSpline: ("t c k extrapolate axis", _of_b_spline),
        interpolate.UnivariateSpline: ("_eval_args ext", _of_univariate),
        interpolate.interp1d: (
            "x y _y _call _kind _extrapolate _y_axis _y_extra_shape bounds_error _spline x_bds "
            "_x_shift _side _ind _fill_value_below _fill_value_above",
            _of_interp1d,
        ),
    }


def _of_type(cls) -> Any:
    """(attributes, maker of a Form) of a type of interpolators; (None, None) for another type."""
    known = _known()
    return next((known[base] for base in cls.__mro__ if base in known), (None, None))


def numbers_in(value):
    """The names of the attributes that determine an interpolator; None for an unknown type."""
    names, _ = _of_type(type(value))
    return names and tuple(name for name in names.split() if hasattr(value, name))


class Interpolator(Unwritten):
    """The stand-in of a SciPy interpolator."""

    _original: Any

    def __init__(self, original: Any):
        vars(self).update(_original=original)

    def __call__(self, x, *args, **kwargs):
        args, kwargs = tuple(map(_as_now, args)), {k: _as_now(v) for k, v in kwargs.items()}
        if not is_symbolic(x):
            return raised(self._original(lowered(complete(x)), *args, **kwargs))
        g, key = graph_of(x), ("form", id(self._original), args, tuple(kwargs.items()))
        if key not in g.kept:  # the object is kept, so that its id stays unique
            g.kept[key] = form_of(self._original, *args, **kwargs), self._original
        form = g.kept[key][0]
        if form is None:
            refuse(f"it uses an object of type {type(self._original).__name__}", final=True)
        return form(x)

    def __getattr__(self, name):
        if name not in METHODS:
            refuse(f"it uses `{name}` of an interpolator")

        def method(*args, **kwargs):
            now = {name: _as_now(v) for name, v in kwargs.items()}
            found = getattr(self._original, name)(*map(_as_now, args), **now)
            return Interpolator(found) if callable(found) else raised(found)

        return method


def maker_of(cls):
    """A function that makes interpolators of a class from constants; None for another class."""
    if _of_type(cls) == (None, None):
        return None

    def made(*args, **kwargs):
        plain = {name: _as_now(v) for name, v in kwargs.items()}
        return Interpolator(cls(*map(_as_now, args), **plain))

    return made


def _as_now(value) -> Any:
    if not is_symbolic(value):
        return lowered(complete(value))
    if isinstance(value, Symbol):
        return int(value) if value.kind == INT else float(value)
    value = Array.of(value)
    return numbers(value).reshape(value.shape)


def form_of(value, *args, **kwargs):
    """The Form of an interpolator that is called with these arguments; None for an unknown type."""
    _, make = _of_type(type(value))
    return make and make(value, *args, **kwargs)


def _is_ascending(x, least=2):
    x = np.asarray(x)
    return len(x) >= least and x.dtype.kind in "fiu" and bool(np.all(np.diff(x) > 0))


def _columns(c, at, made) -> list:
    """``made(coefficients)`` for each component; axes from `at` on count the components.

    Complex coefficients give a ComplexColumn of two components; `made` gets floats.
    """
    each = np.moveaxis(c.reshape(*c.shape[:at], -1), -1, 0)
    if c.dtype == complex:
        return [ComplexColumn(made(one.real), made(one.imag)) for one in each]
    return [made(one) for one in each]


def _of_polynomials(value, nu=0, extrapolate=None):
    extrapolate = value.extrapolate if extrapolate is None else extrapolate
    x, c = value.x, value.c
    if not _is_ascending(x) or c.dtype not in NUMBERS:
        return None
    columns = _columns(c, 2, lambda each: Polynomials(x, each).derivative(nu))
    return _bounded(columns, c.shape[2:], (x[0], x[-1]), extrapolate, value.axis)


def _bounded(columns, shape, ends, extrapolate, axis):
    ends, n = tuple(map(float, ends)), len(columns)
    period = ends[1] - ends[0] if extrapolate == "periodic" else None
    go_on = extrapolate and period is None
    outside = None if go_on else ([np.nan] * n, [np.nan] * n)
    return Form(columns, shape, ends, outside, axis, period, finite=True)


def _of_b_spline(value, nu=0, extrapolate=None):
    t, c, k = value.t, value.c, value.k
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
    if c.dtype not in NUMBERS or np.any(np.diff(t) < 0) or not t[k] < t[n]:
        return None
    if k == 0:
        return _columns(c, 1, lambda each: Steps(t, each, "right", -1, nan=nan).derivative(nu))
    if t[k] == t[k + 1] or t[n - 1] == t[n]:
        return None  # SciPy divides by zero there

    def pieces(each):
        whole = interpolate.PPoly.from_spline((t, np.append(each, np.zeros(k + 1)), k))
        inner = np.arange(k, n)
        inner = inner[np.diff(t)[k:n] > 0]
        x = np.append(t[inner], t[inner[-1] + 1])
        return Polynomials(x, whole.c[:, inner], nan).derivative(nu)

    return _columns(c, 1, pieces)


def _of_univariate(value, nu=0, ext: Any = None):
    ext = value.ext if ext is None else ext
    ext = {"extrapolate": 0, "zeros": 1, "raise": 2, "const": 3}.get(ext, ext)
    return _of_fitpack(value._eval_args, nu, ext, value)


def _of_fitpack(tck, nu, ext, value_at):
    """The Form of a spline with FITPACK's rule `ext` outside the range; None if there is none."""
    t, c, k = tck
    n = len(t) - k - 1
    columns = _of_knots(t, c[:n], k, nu, nan=False)
    if columns is None or (ext == 3 and nu):
        return None
    ends = float(t[k]), float(t[n])
    outside: Any = {0: None, 1: ([0.0], [0.0]), 2: "outside the range of the interpolation"}
    if ext == 3:
        outside[3] = tuple([float(value_at(end))] for end in ends)
    return Form(columns, (), ends, outside[ext], finite=True)


def _of_interp1d(value):
    x, shape, how = value.x, value._y_extra_shape, value._call.__name__
    if not _is_ascending(x) or value._y.dtype not in NUMBERS or type(x) is not np.ndarray:
        return None
    ends = float(x[0]), float(x[-1])
    columns = _ways(value, how)
    if columns is None:
        return None
    outside: Any = None
    if value.bounds_error and not value._extrapolate:
        outside = "A value in x_new is outside the interpolation range."
    elif not value._extrapolate:
        below, above = value._fill_value_below, value._fill_value_above
        outside = [_filled(f, shape) for f in (below, above)]
    finite = how in ("_call_spline", "_call_linear")  # SciPy 1.18 changed their operations
    return Form(columns, shape, ends, outside, value._y_axis, finite=finite)


def _filled(fill, shape):
    """A value outside the range for each component; SciPy's own end values are flat."""
    if np.size(fill) != math.prod(shape):
        fill = np.broadcast_to(fill, shape)
    return np.ravel(fill).tolist()


def _ways(value, how):
    """The components of an interp1d that calls the method `how`; None for an unknown method."""
    x = value.x
    if how == "_call_linear_np":
        y = np.asarray(value.y)
        same = y.shape == x.shape and y.dtype == float
        return [_ByNumPy(x, y)] if same else None
    if how == "_call_linear":
        return _columns(value._y, 1, lambda y: Line(x, y))
    if how == "_call_nearest":
        return _columns(value._y, 1, lambda y: Steps(value.x_bds, y, value._side))
    if how == "_call_previousnext":
        shift = value._ind - 1
        return _columns(value._y, 1, lambda y: Steps(value._x_shift, y, value._side, shift))
    if how == "_call_spline":
        spline = value._spline
        return _of_knots(spline.t, spline.c.reshape(len(spline.c), -1), spline.k)
    return None


class _ByNumPy:
    def __init__(self, x, y):
        self._table = x, y

    def at(self, v):
        return interpolated(v, *self._table)


def evaluated(x, tck, der=0, ext=0):
    """splev."""
    t, c, k = tck
    form = (
        _of_fitpack((numbers(t), numbers(c), int(k)), int(der), ext, None)
        if ext in (0, 1, 2)
        else None
    )
    if form is None:
        refuse("splev in this spline")
    return form(x)
