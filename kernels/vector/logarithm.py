"""Logarithms and powers of vectors.

x = 2^k m with m from sqrt(1/2) to sqrt(2), and log m = 2 artanh s with s = (m - 1) / (m + 1).
The polynomials are minimax polynomials (Remez) in z = s^2 on |s| <= 3 - 2 sqrt(2):

- LOGARITHM approximates 2 artanh(s) / s^3 - 2 / s^2, with an error of 2^-59 in artanh s;
- TAIL approximates the rest of this function behind its first two terms, 2/3 + 2/5 z, with an error
  of 2^-72.  The two terms are sums of two doubles, because a power needs log x to some 64 bits.
"""

from .emit import (
    bits,
    fast_two_sum,
    fma,
    named,
    outlined,
    polynomial,
    quotient,
    real,
    signed,
    sqrt,
    two_product,
    two_sum,
    where,
    where_any,
    word,
)
from .exponential import BIAS, INF, LN2, TINY, exponential_of_product, exponential_of_sum

LOGARITHM = (
    0.6666666666666735, 0.3999999999941109, 0.2857142874326269, 0.22222198475983598,
    0.18183569740023955, 0.15313903239557122, 0.1479750779196961,
)  # fmt: skip
TAIL = (
    0.2857142857143319, 0.22222222220001153, 0.1818181860724456, 0.1538457275371536,
    0.13335769388749527, 0.11684903091044839, 0.11912208569073027,
)  # fmt: skip
TWO_THIRDS = 0.6666666666666666, 3.700743415417188e-17
LOG2_E = 1.4426950408889634, 2.0355273740931033e-17
LOG10_E = 0.4342944819032518, 1.098319650216765e-17
LOG10_2 = 0.3010299956639812, -2.8037281277851704e-18
LN2_3 = 0.23104906018664845, -1.077356103093161e-17
THIRD = 0.3333333333333333, 1.850371707708594e-17
NAN = float("nan")
NORMAL = 2.0**-1022  # the least double with all digits
MIDDLE = word(0.5**0.5)


def split(x):
    """k as a double, k as a biased exponent, and m; for 0 < x < inf."""
    tiny = x < NORMAL
    pattern = bits(where(tiny, x * 2.0**54, x))
    exponent = (pattern - MIDDLE + (BIAS << 52)) >> 52
    k = real(exponent | word(2.0**52)) - (2.0**52 + BIAS)
    return where(tiny, k - 54.0, k), exponent, real(pattern - (exponent << 52) + (BIAS << 52))


def defined(x, result):
    """`result` where 0 < x < inf, elsewhere the logarithm of x."""
    limit = where(x == 0.0, -INF, where(x > 0.0, x, NAN))
    return where((x > 0.0) & (x < INF), result, limit)


def total(k, m, low):
    """k log 2 + log m + low."""
    f = m - 1.0
    s = f / (m + 1.0)
    z = s * s
    bend = s * fma(-z, polynomial(z, LOGARITHM), f)
    return fma(k, LN2[0], f - (bend - fma(k, LN2[1], low)))


@outlined
def logarithm(x):
    k, _, m = split(x)
    return defined(x, total(k, m, 0.0))


@outlined
def logarithm_of_one_plus(x):
    u, low = two_sum(x, 1.0)
    k, exponent, m = split(u)
    low = where(u < 2.0**100, low * real((2 * BIAS - exponent) << 52) / m, 0.0)
    return where(abs(x) < TINY, x, defined(u, total(k, m, low)))


def precise(m):
    """log m as the sum of two doubles, with a relative error of about 2^-66."""
    f = m - 1.0
    d = m + 1.0
    s, s_low = quotient(f, 0.0, d, m - (d - 1.0))
    z, z_low = two_product(s, s)
    z_low = fma(s + s, s_low, z_low)
    bend = fma(z, polynomial(z, TAIL), 0.4)
    p, p_low = two_product(z, bend)
    q, q_low = fast_two_sum(TWO_THIRDS[0], p)
    q_low = q_low + (TWO_THIRDS[1] + fma(z_low, bend, p_low))
    cube, cube_low = two_product(s, z)
    cube_low = fma(s, z_low, fma(s_low, z, cube_low))
    t, t_low = two_product(cube, q)
    t_low = fma(cube, q_low, fma(cube_low, q, t_low))
    high, low = fast_two_sum(s + s, t)
    return fast_two_sum(high, low + (s_low + s_low + t_low))


def scaled(k, unit, high, low, factor):
    """k unit + (high + low) factor; unit and factor are sums of two doubles."""
    a, a_low = two_product(k, unit[0])
    b, b_low = two_product(high, factor[0])
    b_low = fma(high, factor[1], fma(low, factor[0], b_low))
    result, rest = fast_two_sum(a, b)
    return fast_two_sum(result, rest + (fma(k, unit[1], a_low) + b_low))


@outlined
def logarithm_2(x):
    k, _, m = split(x)
    return defined(x, scaled(k, (1.0, 0.0), *precise(m), LOG2_E)[0])


@outlined
def logarithm_10(x):
    k, _, m = split(x)
    return defined(x, scaled(k, LOG10_2, *precise(m), LOG10_E)[0])


@outlined
def any_power(x, y):
    """x^y as in C: NaN for x < 0 unless y is whole."""
    a = abs(x)
    k, _, m = split(a)
    high, low = scaled(k, LN2, *precise(m), (1.0, 0.0))
    high = where(a == 0.0, -INF, where(a < INF, high, a))
    size = exponential_of_product(y, high, low)
    size = where((y == 0.0) | (a == 1.0), 1.0, size)
    half = y * 0.5
    whole = named("rint", y) == y
    odd = whole & (named("rint", half) != half)
    size = where((x < 0.0) & (a < INF) & ~whole, NAN, size)
    return where(odd, signed(size, x), size)


def power(x, y):
    """x^y, for y = 1/2, 1, ..., 3 and their opposites by products and a square root.

    For a constant exponent, only the formula of this exponent is compiled.
    """
    n = abs(y) * 2.0
    short = (n >= 1.0) & (n <= 6.0) & (named("rint", n) == n) & (x > 1e-100) & (x < 1e100)

    def products():
        root = where((n == 1.0) | (n == 3.0) | (n == 5.0), sqrt(x), x)
        first = where(n == 4.0, 1.0, root)
        second = where(n == 3.0, x, where(n < 3.0, 1.0, x * x))
        second_low = where(n < 4.0, 0.0, fma(x, x, -second))
        whole, low = two_product(first, second)
        low = fma(first, second_low, low)
        ratio, ratio_low = quotient(1.0, 0.0, whole, low)
        return (where(y < 0.0, ratio + ratio_low, whole + low),)

    result = where_any(short, products, (y,))
    return where_any(~short, lambda: (any_power(x, y),), result)[0]


@outlined
def cube_root(x):
    a = abs(x)
    k, _, m = split(a)
    high, low = scaled(k, LN2_3, *precise(m), THIRD)
    return where((a > 0.0) & (a < INF), signed(exponential_of_sum(high, low), x), x)
