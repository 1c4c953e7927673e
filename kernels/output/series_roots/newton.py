"""One root of a polynomial on [0, 1], to round-off, by Newton's method."""

from ...jit.options import INTERNAL, njit
from .bernstein import UNIT

N_ITERATIONS = 120  # two iterations halve the interval


@njit(**INTERNAL)
def derivatives(a, x):
    """sum a[k] x^k, its first derivative, and its second: Horner's scheme."""
    value = slope = half = 0.0
    for k in range(len(a) - 1, -1, -1):
        half = half * x + slope
        slope = slope * x + value
        value = value * x + a[k]
    return value, slope, 2.0 * half


@njit(**INTERNAL)
def bracketed(a, order, low, high, sign):
    """The root between low and high of a polynomial that has the given sign at low.

    `order` is 0 for the polynomial, 1 for its derivative.
    """
    x = 0.5 * (low + high)
    step = high - low
    for _ in range(N_ITERATIONS):
        value, slope, curvature = derivatives(a, x)
        if order == 1:
            value = slope
            slope = curvature
        if value == 0.0:
            break
        if (value > 0.0) == (sign > 0.0):
            low = x
        else:
            high = x
        new = x - value / slope
        if not (low < new < high and abs(new - x) <= 0.5 * abs(step)):
            new = 0.5 * (low + high)
        x, step = new, new - x
        if abs(step) <= 2.0 * UNIT or high - low <= 2.0 * UNIT:
            break
    return x


@njit(**INTERNAL)
def refined(a, x, order):
    """The root near x of the polynomial, or of its derivative, to rounding."""
    for _ in range(3):
        value, slope, curvature = derivatives(a, x)
        if order == 1:
            value = slope
            slope = curvature
        new = x - value / slope
        if not 0.0 <= new <= 1.0:
            break
        there = derivatives(a, new)
        if not abs(there[order]) < abs(value):
            break
        x = new
    return x


@njit(**INTERNAL)
def sign_behind_one(a, noise):
    """The first sign beyond noise of a polynomial behind x = 1; 0 if there is none up to x = 2."""
    ahead = UNIT
    while ahead < 1.0:
        ahead *= 2.0
        value = derivatives(a, 1.0 + ahead)[0]
        if abs(value) > noise:
            return 1.0 if value > 0.0 else -1.0
    return 0.0
