"""Inverse trigonometric functions of vectors.

The polynomials are minimax (Remez) in z = q^2: of (atan q - q) / q^3 on |q| <= 1.00005 tan(pi/8)
with the error 2^-58 of atan q, of (asin q - q) / q^3 on |q| <= 1/2 with the error 2^-58 of asin q.
"""

from .emit import bits, fma, outlined, polynomial, quotient, signed, sqrt, two_sum, where
from .exponential import INF

ARC_TANGENT = (
    -0.333333333333332, 0.1999999999995404, -0.1428571428024419, 0.11111110785910933,
    -0.09090897829642659, 0.076920615115185, -0.06663118909275823, 0.05847997872498148,
    -0.050397944399596536, 0.038076992376054615, -0.017920792530853467,
)  # fmt: skip
ARC_SINE = (
    0.16666666666666763, 0.07499999999970261, 0.044642857175121196, 0.030381942683604026,
    0.02237221566055705, 0.017351600088732173, 0.013980961477450714, 0.011397775825391457,
    0.01078652984990948, 0.003683038956850097, 0.021763507186894605, -0.021077305026957184,
    0.03267689876784443,
)  # fmt: skip
PI_4 = 0.7853981633974483, 3.061616997868383e-17
PI_2 = 1.5707963267948966, 6.123233995736766e-17
HALFWAY = 0.41421356237309503  # tan(pi/8)
LARGE = 2.0**1000
SMALL = 2.0**-900


def angle(below, above):
    """atan(below / above) as a number of quarters of pi and a rest, 0 <= below <= above < inf."""
    wide = below > HALFWAY * above
    difference, difference_low = two_sum(below, -above)
    total, total_low = two_sum(below, above)
    q, q_low = quotient(
        where(wide, difference, below), where(wide, difference_low, 0.0),
        where(wide, total, above), where(wide, total_low, 0.0),
    )  # fmt: skip
    z = q * q
    return where(wide, 1.0, 0.0), q, fma(q * z, polynomial(z, ARC_TANGENT), q_low)


def turned(quarters, q, low):
    """quarters pi/4 + q + low."""
    base = quarters * PI_4[0]
    return base + (q + (low + fma(quarters, PI_4[1], fma(quarters, PI_4[0], -base))))


@outlined
def arc_tangent(x):
    a = abs(x)
    swapped = a > 1.0
    above = where(swapped, a, 1.0)
    quarters, q, low = angle(where(swapped, 1.0, a), where(above < INF, above, 2.0**200))
    turn = where(swapped, 2.0 - quarters, quarters)
    return signed(turned(turn, where(swapped, -q, q), where(swapped, -low, low)), x)


@outlined
def arc_tangent_of_two(y, x):
    a = abs(y)
    b = abs(x)
    swapped = a > b
    above = where(swapped, a, b)
    below = where(swapped, b, a)
    scale = where(above > LARGE, 2.0**-50, where(above < SMALL, 2.0**150, 1.0))
    infinite = above == INF
    below = where(infinite, where(below == INF, 1.0, 0.0), below * scale)
    above = where(infinite | (above == 0.0), 1.0, above * scale)
    quarters, q, low = angle(below, above)
    quarters = where(swapped, 2.0 - quarters, quarters)
    left = bits(x) < 0
    quarters = where(left, 4.0 - quarters, quarters)
    back = swapped ^ left
    size = turned(quarters, where(back, -q, q), where(back, -low, low))
    return signed(where(y != y, y, where(x != x, x, size)), y)


def small_arc(a):
    """q and asin q - q, where q = a for a <= 1/2, and else sin of (pi/2 - asin a) / 2."""
    far = a > 0.5
    z = where(far, (1.0 - a) * 0.5, a * a)
    q = where(far, sqrt(z), a)
    return far, q, q * z * polynomial(z, ARC_SINE)


@outlined
def arc_sine(x):
    far, q, rest = small_arc(abs(x))
    return signed(where(far, PI_2[0] - (2.0 * q - (PI_2[1] - 2.0 * rest)), q + rest), x)


@outlined
def arc_cosine(x):
    far, q, rest = small_arc(abs(x))
    left = x < 0.0
    near = PI_2[0] - (signed(q, x) - (PI_2[1] - signed(rest, x)))
    beyond = 2.0 * where(left, PI_2[0] - (q - (PI_2[1] - rest)), q + rest)
    return where(far, beyond, near)
