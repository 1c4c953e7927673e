"""Where the step size is chosen: error norms and two controllers.

A controller is four functions: `smallest` (no step is shorter), `aim` (where the step to try ends),
`grow` (after acceptance), `shrink` (after a rejection; 0 where no step is left).  An error estimate
is accepted when its norm is below 1.  The controllers use `select` instead of branches, and so take
numbers and vectors.

SCIPY is the rule of `scipy.integrate.RK45`, after Hairer, Norsett and Wanner, "Solving Ordinary
Differential Equations I", second edition, section II.4.  `matlab` makes the rule of MATLAB's ode45
and ode23, after Shampine and Reichelt, "The MATLAB ODE suite", SIAM J. Sci. Comput. 18 (1997), in
the form that reproduces ode45's published step sequences.
"""

from typing import NamedTuple

import numpy as np

from ..jit.options import INTERNAL, njit
from ..state.reduce import add, reduce_components
from ..vector.scalar_or_vector import fused, power, rare, select, spacing

SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 10.0  # as in SciPy
ROUNDED = 1.125  # a step that ends at a rounded time may be h_min and an eighth


class Norm(NamedTuple):
    """The norm of errors: ``mean(error, y, y_new, rtol, atol)``, 1 at the tolerance.

    `squares` is the sum of squares of which `mean` takes the mean; a component has `parts` numbers.
    """

    mean: object
    squares: object
    parts: int


class Controller(NamedTuple):
    """The decisions of an adaptive loop; for the four functions see the top of this file."""

    smallest: object
    aim: object
    grow: object
    shrink: object


@njit(**INTERNAL)
def larger(a, b):
    """The larger of two numbers; NaN if either number is NaN, as by np.maximum."""
    return select((b > a) | (b != b), b, a)


@njit(**INTERNAL)
def _square_of_scaled(total, error, y, y_new, rtol, atol):
    x = error / (atol + larger(abs(y), abs(y_new)) * rtol)
    return total + x * x


@njit(**INTERNAL)
def sum_of_squares(error, y, y_new, rtol, atol):
    """Sum of (error / (atol + rtol * max(|y|, |y_new|)))^2 over the components."""
    return reduce_components(_square_of_scaled, add, 0.0, (error, y, y_new, rtol, atol))


@njit(**INTERNAL)
def rms(error, y, y_new, rtol, atol):
    """Root mean square of the error over its tolerance: SciPy's norm."""
    return np.sqrt(sum_of_squares(error, y, y_new, rtol, atol) / len(error))


@njit(**INTERNAL)
def _largest_scaled(total, error, y, y_new, rtol, atol):
    floor = atol / rtol
    size = larger(larger(abs(y), abs(y_new)), floor)
    return larger(total, abs(error) / size / rtol)


@njit(**INTERNAL)
def largest(error, y, y_new, rtol, atol):
    """Largest |error| / max(|y|, |y_new|, atol / rtol) in units of rtol: MATLAB's norm."""
    return reduce_components(_largest_scaled, larger, 0.0, (error, y, y_new, rtol, atol))


@njit(**INTERNAL)
def _scipy_smallest(t, direction):
    return 10.0 * spacing(t, direction)


@njit(**INTERNAL)
def _scipy_aim(t, h, t_end, direction):
    t_new = fused(h, direction, t)  # exact but for the sum, as the direction is 1 or -1
    return select(rare(direction * (t_new - t_end) > 0.0), t_end, t_new)


@njit(**INTERNAL)
def _scipy_grow(h, error, exponent, rejections):
    factor = SAFETY * power(error, exponent)  # infinite where the error is zero
    factor = select(factor > MAX_FACTOR, MAX_FACTOR, factor)
    return h * select(rare((rejections > 0) & (factor > 1.0)), 1.0, factor)


@njit(**INTERNAL)
def _scipy_shrink(h, error, exponent, rejections, h_min):
    factor = SAFETY * power(error, exponent)
    h = h * select(factor > MIN_FACTOR, factor, MIN_FACTOR)
    return select(h >= h_min, h, 0.0)


@njit(**INTERNAL)
def _matlab_smallest(t, direction):
    return 16.0 * spacing(abs(t), 1.0)


@njit(**INTERNAL)
def _matlab_aim(t, h, t_end, direction):
    return select(rare(1.1 * h >= abs(t_end - t)), t_end, fused(h, direction, t))


@njit(**INTERNAL)
def _matlab_grow(h, error, exponent, rejections):
    q = 1.25 * power(error, -exponent)
    return select(rare(rejections > 0), h, select(q > 0.2, h / q, 5.0 * h))


def matlab(least):
    """MATLAB's controller; the first rejection multiplies a step by at least the factor `least`."""

    @njit(**INTERNAL)
    def shrink(h, error, exponent, rejections, h_min):
        factor = 0.8 * power(error, exponent)
        shorter = h * select(rejections > 0, 0.5, select(factor > least, factor, least))
        shortest = h <= ROUNDED * h_min  # a step of h_min with a rounded end
        return select(shortest, 0.0, select(shorter > h_min, shorter, h_min))

    return Controller(_matlab_smallest, _matlab_aim, _matlab_grow, shrink)


SCIPY = Controller(_scipy_smallest, _scipy_aim, _scipy_grow, _scipy_shrink)
SCIPYS = Norm(rms, sum_of_squares, 1)
MATLABS = Norm(largest, None, 1)
