"""Exponential and hyperbolic functions of vectors.

x = k log 2 + r with |r| <= (log 2) / 2 up to rounding.  x - k LN2[0] is exact with `fma`.  The
polynomial is the minimax polynomial (Remez) of (e^r - 1 - r) / r^2 on |r| <= 1.0001 (log 2) / 2,
with an error of 2^-60 in e^r.
"""

from .emit import (
    SHIFT,
    bits,
    fast_two_sum,
    fma,
    outlined,
    polynomial,
    quotient,
    real,
    signed,
    two_product,
    two_sum,
    where,
    word,
)

LN2 = 0.6931471805599453, 2.3190468138462996e-17
EXPONENTIAL = (
    0.5, 0.16666666666666682, 0.041666666666666095, 0.008333333333317034, 0.001388888888911563,
    0.00019841269896383814, 2.480158692662912e-05, 2.7557234861910275e-06,
    2.755758185178791e-07, 2.5112036845692073e-08, 2.082662595905977e-09,
)  # fmt: skip
INF = float("inf")
BIAS = 1023  # bias of the exponent in a double
SMALLEST, LARGEST = -746.0, 710.6  # where e^x is 0 and sinh x is infinite
TINY = 2.0**-60


def within(x, low, high):
    """x limited to [low, high]; NaN stays NaN."""
    return where(x < low, low, where(x > high, high, x))


def reduced(x, low=0.0):
    """k, a whole number, and r, with x + low = k log 2 + r."""
    nearest = fma(x, 1 / LN2[0], SHIFT)
    k = nearest - SHIFT
    return bits(nearest) - word(SHIFT), fma(-k, LN2[0], x) + fma(-k, LN2[1], low)


def bend(r):
    """e^r - 1 - r."""
    return r * r * polynomial(r, EXPONENTIAL)


def times_power(x, k):
    """x 2^k, rounded once, for |k| < 2000: in two steps, because 2^k alone may overflow."""
    half = (k + 2048) >> 1
    return x * real((half + (BIAS - 1024)) << 52) * real((k - half + (BIAS + 1024)) << 52)


def exponential_of_sum(x, low):
    """e^(x + low)."""
    k, r = reduced(within(x, SMALLEST, LARGEST), low)
    return times_power(1.0 + (r + bend(r)), k)


@outlined
def exponential(x):
    return exponential_of_sum(x, 0.0)


def exponential_of_product(y, high, low):
    """e^(y (high + low)); y and high may be infinite."""
    p, p_low = two_product(y, high)
    return exponential_of_sum(p, where(abs(p) < 750.0, fma(y, low, p_low), 0.0))


@outlined
def power_of_two(x):
    return exponential_of_product(x, *LN2)


def quarter_rise(x):
    """(e^x - 1) / 4 and its error; the quotient is finite wherever sinh x is finite."""
    k, r = reduced(within(x, -60.0, LARGEST))
    r, low = fast_two_sum(r, bend(r))
    power = real((k + (BIAS - 2)) << 52)
    high, error = two_sum(power - 0.25, power * r)
    return fast_two_sum(high, fma(power, low, error))


@outlined
def exponential_less_one(x):
    high, _ = quarter_rise(x)
    return where(abs(x) < TINY, x, 4.0 * high)


@outlined
def hyperbolic_sine(x):
    high, low = quarter_rise(abs(x))
    size = 2.0 * (high + (low + high / (4.0 * high + 1.0)))
    return where(abs(x) < TINY, x, signed(size, x))


@outlined
def hyperbolic_cosine(x):
    k, r = reduced(within(abs(x), 0.0, 720.0))
    half = times_power(1.0 + (r + bend(r)), k - 1)
    return half + 0.25 / half


@outlined
def hyperbolic_tangent(x):
    high, low = quarter_rise(2.0 * within(abs(x), 0.0, 22.0))
    below, below_low = two_sum(high, 0.5)
    ratio, ratio_low = quotient(high, low, below, below_low + low)
    return where(abs(x) < TINY, x, signed(ratio + ratio_low, x))
