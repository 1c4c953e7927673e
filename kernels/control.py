"""Where the step size is chosen: error norms, the first step, two controllers.

A controller is three functions: `aim` (the step to try), `grow` (after acceptance), `shrink`
(after a rejection).  An error estimate is accepted when its norm is below 1.

SCIPY is the rule of `scipy.integrate.RK45`, after Hairer, Norsett and Wanner, "Solving Ordinary
Differential Equations I", second edition, section II.4.  MATLAB is the rule of MATLAB's ode45,
after Shampine and Reichelt, "The MATLAB ODE suite", SIAM J. Sci. Comput. 18 (1997), in the form
that reproduces ode45's published step sequences.
"""

from typing import NamedTuple

import numpy as np
from numba import njit, types
from numba.extending import intrinsic

from .calls import OPTIONS
from .combine import fold

SAFETY = 0.9
MIN_FACTOR = 0.2
MAX_FACTOR = 10.0


class Controller(NamedTuple):
    """The decisions of an adaptive loop; see the functions of the same names below."""

    smallest: object
    aim: object
    grow: object
    shrink: object


@intrinsic
def _bits(typingctx, x):
    return types.int64(types.float64), lambda c, b, s, a: b.bitcast(
        a[0], c.get_value_type(types.int64)
    )


@intrinsic
def _number(typingctx, i):
    return types.float64(types.int64), lambda c, b, s, a: b.bitcast(
        a[0], c.get_value_type(types.float64)
    )


@njit(**OPTIONS)
def spacing(t, direction):
    """Distance from t to the next number in `direction`, |nextafter(t, direction * inf) - t|."""
    if t == 0.0:
        return 5e-324
    away = (t > 0.0) == (direction > 0.0)
    return abs(_number(_bits(t) + (1 if away else -1)) - t)


@njit(**OPTIONS)
def larger(a, b):
    """The larger of two numbers; NaN if either is, as np.maximum."""
    return b if b > a or b != b else a


@njit(**OPTIONS)
def _plus(a, b):
    return a + b


@njit(**OPTIONS)
def _square_of_scaled(total, error, y, y_new, rtol, atol):
    x = error / (atol + larger(abs(y), abs(y_new)) * rtol)
    return total + x * x


@njit(**OPTIONS)
def sum_of_squares(error, y, y_new, rtol, atol):
    """Sum of (error / (atol + rtol * max(|y|, |y_new|)))^2 over the components."""
    return fold(_square_of_scaled, _plus, 0.0, (error, y, y_new, rtol, atol))


@njit(**OPTIONS)
def rms(error, y, y_new, rtol, atol):
    """Root mean square of the error over its tolerance: SciPy's norm."""
    return np.sqrt(sum_of_squares(error, y, y_new, rtol, atol) / len(error))


@njit(**OPTIONS)
def _largest_scaled(total, error, y, y_new, rtol, atol):
    floor = atol / rtol
    size = larger(larger(abs(y), abs(y_new)), floor)
    return larger(total, abs(error) / size / rtol)


@njit(**OPTIONS)
def largest(error, y, y_new, rtol, atol):
    """Largest |error| / max(|y|, |y_new|, atol / rtol) in units of rtol: MATLAB's norm."""
    return fold(_largest_scaled, larger, 0.0, (error, y, y_new, rtol, atol))


@njit(**OPTIONS)
def _scipy_smallest(t, direction):
    return 10.0 * spacing(t, direction)


@njit(**OPTIONS)
def _scipy_aim(t, h, t_end, direction):
    t_new = t + h * direction
    return t_end if direction * (t_new - t_end) > 0.0 else t_new


@njit(**OPTIONS)
def _scipy_grow(h, error, exponent, rejections):
    factor = MAX_FACTOR if error == 0.0 else SAFETY * error**exponent
    if factor > MAX_FACTOR:
        factor = MAX_FACTOR
    if rejections > 0 and factor > 1.0:
        factor = 1.0
    return h * factor


@njit(**OPTIONS)
def _scipy_shrink(h, error, exponent, rejections, h_min):
    factor = SAFETY * error**exponent
    h *= factor if factor > MIN_FACTOR else MIN_FACTOR
    return h if h >= h_min else 0.0


@njit(**OPTIONS)
def _matlab_smallest(t, direction):
    return 16.0 * spacing(abs(t), 1.0)


@njit(**OPTIONS)
def _matlab_aim(t, h, t_end, direction):
    return t_end if 1.1 * h >= abs(t_end - t) else t + h * direction


@njit(**OPTIONS)
def _matlab_grow(h, error, exponent, rejections):
    if rejections > 0:
        return h
    q = 1.25 * error**-exponent
    return h / q if q > 0.2 else 5.0 * h


@njit(**OPTIONS)
def _matlab_shrink(h, error, exponent, rejections, h_min):
    if h <= h_min:
        return 0.0
    if rejections > 0:
        h *= 0.5
    else:
        factor = 0.8 * error**exponent
        h *= factor if factor > 0.1 else 0.1
    return h if h > h_min else h_min


SCIPY = Controller(_scipy_smallest, _scipy_aim, _scipy_grow, _scipy_shrink)
MATLAB = Controller(_matlab_smallest, _matlab_aim, _matlab_grow, _matlab_shrink)
