"""Tables and splines: polynomials between knots."""

import numpy as np

from .arrays import Array, elementwise
from .conditions import select
from .looking_up import table_of
from .symbolic import is_symbolic, refuse
from .symbols import Symbol


class Piecewise:
    """sum of c[k] (x - x_i)^(m - k) between knots, as SciPy's PPoly has it.

    Parameters
    ----------
    x : array_like, shape (n + 1,)
        Knots, increasing.
    c : array_like, shape (m + 1, n, ...)
    left, right : float, optional
        The values outside; the end pieces go on where they are not given.
    fails : bool
        Whether a point outside is an error.
    """

    def __init__(self, x, c, left=None, right=None, fails=False):
        self.x, self.c = np.ascontiguousarray(x, float), np.ascontiguousarray(c, float)
        self.left, self.right, self.fails = left, right, fails

    def derivative(self, nu):
        """The nu-th derivative of each piece."""
        c = self.c
        for _ in range(nu):
            factors = np.arange(len(c) - 1, 0, -1.0).reshape((-1,) + (1,) * (c.ndim - 1))
            c = c[:-1] * factors if len(c) > 1 else 0 * c
        outside = (None if end is None else end * 0.0 for end in (self.left, self.right))
        return Piecewise(self.x, c, *outside, fails=self.fails)

    def __call__(self, v, nu=0, *args, **kwargs):
        if args or kwargs or is_symbolic(nu):
            refuse("an interpolator with further arguments")
        if nu:
            return self.derivative(int(nu))(v)
        if isinstance(v, np.ndarray | list | tuple):
            return elementwise(self, v)
        if self.c.ndim > 2:
            flat = self.c.reshape(*self.c.shape[:2], -1)
            ends = self.left, self.right, self.fails
            columns = [Piecewise(self.x, flat[:, :, j], *ends)(v) for j in range(flat.shape[2])]
            return Array.of(columns).reshape(self.c.shape[2:])
        if not isinstance(v, Symbol):
            return self._number(float(v))
        if self.fails and ((v < self.x[0]) | (v > self.x[-1])):
            raise ValueError("outside the range of the interpolation")
        g = v.g
        tables = tuple([table_of(g, row) for row in (self.x, *self.c)])
        result = Symbol(g, g.make("piecewise", (v.node,), tables))
        if self.left is not None:
            result = select(v < self.x[0], float(self.left), result)
        if self.right is not None:
            result = select(v > self.x[-1], float(self.right), result)
        return result

    def _number(self, v):
        if v < self.x[0] and (self.fails or self.left is not None):
            return self._outside(self.left)
        if v > self.x[-1] and (self.fails or self.right is not None):
            return self._outside(self.right)
        i = min(max(int(np.searchsorted(self.x, v, "right")) - 1, 0), len(self.x) - 2)
        result = 0.0
        for c in self.c[:, i]:
            result = result * (v - self.x[i]) + c
        return result

    def _outside(self, value):
        if self.fails:
            raise ValueError("outside the range of the interpolation")
        return value


def of_scipy(value):
    """An interpolator of SciPy as a Piecewise; None if it is none."""
    from scipy import interpolate

    if isinstance(value, interpolate.interp1d):
        return _of_interp1d(value)
    if isinstance(value, interpolate.PPoly):
        if value.extrapolate == "periodic":
            return None
        outside = None if value.extrapolate else np.nan
        return Piecewise(value.x, value.c, outside, outside)
    if isinstance(value, interpolate.BSpline) and value.extrapolate is True:
        pieces = interpolate.PPoly.from_spline(value)
        return _without_empty(pieces)
    if isinstance(value, interpolate.UnivariateSpline):
        pieces = _without_empty(interpolate.PPoly.from_spline(value._eval_args))  # pyright: ignore
        if value.ext == 3:  # pyright: ignore
            pieces.left, pieces.right = float(value(pieces.x[0])), float(value(pieces.x[-1]))  # pyright: ignore
        elif value.ext == 1:  # pyright: ignore
            pieces.left = pieces.right = 0.0
        pieces.fails = value.ext == 2  # pyright: ignore
        return pieces
    return None


def _without_empty(pieces):
    kept = np.flatnonzero(np.diff(pieces.x) > 0)
    return Piecewise(np.append(pieces.x[kept], pieces.x[kept[-1] + 1]), pieces.c[:, kept])


def _of_interp1d(value):
    from scipy import interpolate

    x, y = np.asarray(value.x, float), np.moveaxis(np.asarray(value.y, float), value.axis, 0)
    if value._kind == "linear":
        width = np.diff(x).reshape((-1,) + (1,) * (y.ndim - 1))
        c = np.array([np.diff(y, axis=0) / width, y[:-1]])
    elif value._kind in ("previous", "zero"):
        x, c = np.append(x, np.inf), y[None]
    elif hasattr(value, "_spline"):
        t, coefficients, k = value._spline.tck
        columns = coefficients.reshape(len(coefficients), -1).T
        pieces = [_without_empty(interpolate.PPoly.from_spline((t, c, k))) for c in columns]
        x = pieces[0].x
        c = np.stack([p.c for p in pieces], -1).reshape(*pieces[0].c.shape, *y.shape[1:])
    else:
        return None
    if value._extrapolate:
        return Piecewise(x, c)
    fill = value.fill_value
    left, right = fill if isinstance(fill, tuple) else (fill, fill)
    if any(len(np.unique(end)) > 1 for end in (left, right)):
        return None  # another value of each component
    ends = float(np.ravel(left)[0]), float(np.ravel(right)[0])
    return Piecewise(x, c, *ends, fails=bool(value.bounds_error))
