"""Sine, cosine and tangent of vectors.

x = k pi/2 + r with |r| <= pi/4 up to rounding, r as the sum of two doubles: x - k PI_2[0] is exact
with `fma`, because the difference is a multiple of 2^-53 and below 1.  Beyond HUGE the parts of
pi/2 no longer suffice, and the function of the C library is called for each lane.  (glibc's cosine
is wrong by 8 units in the last place at 6381956970095103 * 2^797, the double that is nearest to an
odd multiple of pi/2.)

The polynomials are minimax polynomials (Remez) in z = r^2 on |r| <= 1.0001 pi/4: of
(sin r - r) / r^3, with an error of 2^-57 in sin r, and of (cos r - 1 + z/2) / z^2, with an error of
2^-59 in cos r.
"""

import functools
import math

from .emit import (
    SHIFT,
    SIGN,
    bits,
    by_library,
    fast_two_sum,
    fma,
    outlined,
    polynomial,
    quotient,
    real,
    two_product,
    two_sum,
    where,
    where_any,
)

PI_2 = 1.5707963267948966, 6.123233995736766e-17, -1.4973849048591698e-33
HUGE = 2.0**30
SINE = (
    -0.16666666666666632, 0.008333333333322413, -0.00019841269829807808,
    2.7557313691917343e-06, -2.5050758115100944e-08, 1.5896795641326226e-10,
)  # fmt: skip
COSINE = (
    0.041666666666666595, -0.001388888888887304, 2.4801587288841384e-05,
    -2.755731417623586e-07, 2.0875700415544935e-09, -1.1358513924748068e-11,
)  # fmt: skip


def reduced(x):
    """k in the last bits of a word, and r as a double and a correction."""
    nearest = fma(x, 2 / math.pi, SHIFT)
    k = nearest - SHIFT
    high, error = two_product(k, PI_2[1])
    high, low = two_sum(fma(-k, PI_2[0], x), -high)
    return bits(nearest), *fast_two_sum(high, fma(-k, PI_2[2], low - error))


def near_zero(r, low):
    """sin and cos of r + low, each as a double and a correction."""
    z = r * r
    sine = fma(z, fma(r, polynomial(z, SINE), low * -0.5), low)
    half = z * 0.5
    most = 1.0 - half
    cosine = ((1.0 - most) - half) + fma(z * z, polynomial(z, COSINE), -(r * low))
    return (r, sine), (most, cosine)


@functools.partial(outlined, n_results=2)
def sine_cosine(x):
    k, r, low = reduced(x)
    (s, s_low), (c, c_low) = near_zero(r, low)
    sine = s + s_low
    cosine = c + c_low
    odd = (k << 63) < 0
    first = where(odd, cosine, sine)
    second = where(odd, sine, cosine)
    first = real(bits(first) ^ ((k << 62) & SIGN))
    second = real(bits(second) ^ (((k + 1) << 62) & SIGN))
    first = where(x == 0.0, x, first)
    return where_any(
        abs(x) > HUGE, lambda: (by_library("sin", x), by_library("cos", x)), (first, second)
    )


def sine(x):
    return sine_cosine(x)[0]


def cosine(x):
    return sine_cosine(x)[1]


@outlined
def tangent(x):
    k, r, low = reduced(x)
    (s, s_low), (c, c_low) = (fast_two_sum(*pair) for pair in near_zero(r, low))
    odd = (k << 63) < 0
    above = where(odd, -c, s)
    above_low = where(odd, -c_low, s_low)
    ratio, ratio_low = quotient(above, above_low, where(odd, s, c), where(odd, s_low, c_low))
    result = where(x == 0.0, x, ratio + ratio_low)
    return where_any(abs(x) > HUGE, lambda: (by_library("tan", x),), (result,))[0]
