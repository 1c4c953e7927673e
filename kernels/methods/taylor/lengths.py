"""The length of a step from the terms of its series, of numbers or of vectors.

The length keeps the last two terms of the series below the tolerance (A. Jorba and M. Zou, "A
software package for the numerical integration of ODEs by means of high-order Taylor methods",
Experimental Mathematics 14 (2005), section 3.2.1), of each component below its own tolerance.  A
second bound limits the terms of lower orders, which may be larger by the same ratios as the terms
of exp.  The second bound detects a series with gaps, for example a series in powers of t^5.

LLVM, because Numba does not read the bits of a double as a number.
"""

import math

from numba.extending import intrinsic

from ...jit.options import INLINED, INTERNAL, njit
from ...state.rows import keep_vector, vector_at
from ...vector.emit import Lanes, bits, fma, polynomial, real, where
from ...vector.scalar_or_vector import select
from .accuracy import ALLOWANCE, SMALLEST
from .description import ABSOLUTE, ARRAYS, N_VECTORS, RELATIVE, STRIDE, TABLES, WEIGHTS, WIDTH
from .lanes_to_number import largest, total

EXPONENT_BITS = 0x7FF << 52
GROWTH = 2.0**16  # longest step, in the unit of the series: terms that limit it may be 0
SHRINK = 2.0**-16  # multiplies the unit of time after an overflow of coefficients
LEAST = 2.0**-60  # a step shorter than this share of |t| does not change t
SHORTEST = 1e-280
BLIND = 1.0 / 8.0  # if all terms vanish, the step is this share of the longest step
# A step shorter than this share of its unit is computed again with a shorter unit, because the
# weight of a small component contains its change in one unit: see `weight`.
COARSE = 1.0 / 4.0
LAST = 2
TERMS = 8
IRREGULAR = 64.0  # ratio of earlier terms to those of exp, above which a series has gaps
# log2(1.5 + u / 2) for |u| < 1 and 2**u for |u| < 1 / 2, to 1e-4: least squares at Chebyshev's
# points.
LOGARITHM = (
    0.5849504981408199, 0.48048162364576458, -0.079937273772185555,
    0.01943073188493305, -0.0050006798066754132,
)  # fmt: skip
EXPONENTIAL = 0.9999244814555224, 0.6931210339915466, 0.24264008283277344, 0.055922035647262516
SHIFT = 1.5 * 2.0**52  # the last bits of z + SHIFT are z rounded to an integer


def _formula(body):
    """A function of one number or vector, from LLVM values of `Lanes`."""

    @intrinsic
    def function(typingctx, x):
        def codegen(context, builder, signature, args):
            return body(Lanes(builder, args[0])).value

        return x(x), codegen

    return function


@_formula
def logarithm(x):
    """log2(x) to 1e-4, which suffices for a length, in a dozen cycles."""
    whole = (bits(x) >> 52) + -1023
    exponent = Lanes(x.builder, x.builder.sitofp(whole.value, x.value.type))
    mantissa = real((bits(x) & (2**52 - 1)) | (1023 << 52))
    return exponent + polynomial(fma(mantissa, 2.0, -3.0), LOGARITHM)


@_formula
def exponential(z):
    """2**z, |z| < 1000, to 1e-4."""
    shifted = z + SHIFT
    power = polynomial(z - (shifted - SHIFT), EXPONENTIAL)
    return real(bits(power) + (bits(shifted) << 52))


@_formula
def unit_of(h):
    """The power of two below a length; 1 if the length is 0 or not finite."""
    exponent = bits(h) & EXPONENT_BITS
    return where((exponent == 0) | (exponent == EXPONENT_BITS), 1.0, real(exponent))


@_formula
def squarable(x):
    """A number without its last 27 bits, so that its square is exact."""
    return real(bits(x) & -(1 << 27))


@njit(**INLINED)
def larger(a, b):
    """The larger of two; a if a is NaN."""
    return select(a < b, b, a)


@njit(**INLINED)
def smaller(a, b):
    """The smaller of two; b if a is NaN."""
    return select(a < b, a, b)


@njit(**INLINED)
def weight(y, slope, rtol, atol):
    """1 / (atol + rtol max(|y|, |y_1|)); 0 for a component without tolerance.

    The slope y_1 is the change in one unit of time, for components that are zero now and grow in
    the step.  The unit is at most 1 / COARSE of the step.
    """
    y = abs(y)
    slope = abs(slope)
    size = rtol * select(slope <= y, y, slope) + atol  # NaN if the slope is
    return select(size == 0.0, 0.0, 1.0 / size)


@njit(**INLINED)
def weigh(form, room, words, u, y, slope):
    """Store the `weight` of a vector of components."""
    at = words[ARRAYS] + u * words[WIDTH]
    n = words[N_VECTORS] * words[WIDTH]
    rtol = vector_at(form, room, at + RELATIVE * n)
    atol = vector_at(form, room, at + ABSOLUTE * n)
    found = weight(y, slope, rtol, atol)
    keep_vector(form, room, at + WEIGHTS * n, found)
    return found


def bounds(order):
    """``bound(k, norm, tolerance)``, the length that the terms of order k allow, as its log2.

    `norm` is the largest term of order k at x = 1, in units of the tolerance; the tolerance is the
    relative one, as its log2.
    """
    least = order - LAST + 1
    orders = range(order, order - TERMS, -1)
    inverses = tuple(1.0 / k for k in orders)
    constants = tuple(
        math.log2(ALLOWANCE[order]) / k + max(math.log2(least / k), 0.0) for k in orders
    )
    finer = tuple(min(1.0 / least - 1.0 / k, 0.0) for k in orders)

    @njit(**INLINED)
    def bound(k, norm, tolerance):
        i = order - k
        return constants[i] - logarithm(norm) * inverses[i] + tolerance * finer[i]

    return bound


def lengths(form, order):
    """``length(room, words, tolerance)``: the length of a step, and the sum of all examined terms.

    The length is in the unit of the series.  The sum is finite if the series is.  Stores the
    weights.
    """
    bound = bounds(order)
    least = order - LAST + 1
    ratio = math.e * SMALLEST[order] ** (-1.0 / least)
    regular = ratio**-least / ALLOWANCE[order] / IRREGULAR

    @njit(**INTERNAL)
    def with_gaps(room, words, tolerance):
        """The length from the last TERMS terms, and the sum of all these terms."""
        found = math.inf
        size = 0.0
        at = words[ARRAYS]
        weights = at + WEIGHTS * words[N_VECTORS] * words[WIDTH]
        for k in range(order, order - TERMS, -1):
            norm = vector_at(form, room, at) * 0.0
            added = norm
            for u in range(words[N_VECTORS]):
                c = abs(vector_at(form, room, words[TABLES + u] + k * words[STRIDE]))
                c = c * vector_at(form, room, weights + u * words[WIDTH])
                norm = larger(c, norm)
                added = added + c
            size += total(added)
            found = smaller(bound(k, largest(norm), tolerance), found)
        return exponential(found), size

    @njit(**INLINED)
    def length(room, words, tolerance):
        last = vector_at(form, room, words[ARRAYS]) * 0.0
        before = last
        added = last
        earlier = last
        stride = words[STRIDE]
        for u in range(words[N_VECTORS]):
            place = words[TABLES + u]
            y = vector_at(form, room, place)
            slope = vector_at(form, room, place + stride)
            w = weigh(form, room, words, u, y, slope)
            a = abs(vector_at(form, room, place + order * stride)) * w
            b = abs(vector_at(form, room, place + (order - 1) * stride)) * w
            last = larger(a, last)
            before = larger(b, before)
            added = added + (a + b)
        size = total(added)
        x = bound(order - 1, largest(before), tolerance)
        x = exponential(smaller(x, bound(order, largest(last), tolerance)))
        # The terms before the last terms, at x, in units of the largest terms of a regular series.
        # A regular series has geometric terms, with the last terms at the bound of the length for
        # the smallest tolerance of the order.
        at = x * ratio
        weights = words[ARRAYS] + WEIGHTS * words[N_VECTORS] * words[WIDTH]
        for u in range(words[N_VECTORS]):
            place = words[TABLES + u]
            terms = abs(vector_at(form, room, place + (order - LAST) * stride))
            for k in range(order - LAST - 1, order - TERMS, -1):
                terms = terms * at + abs(vector_at(form, room, place + k * stride))
            earlier = earlier + terms * vector_at(form, room, weights + u * words[WIDTH])
        if total(earlier) * (at ** (order - TERMS + 1) * regular) <= 1.0 and size > 0.0:
            return x, size
        return with_gaps(room, words, tolerance)

    return length


@njit(**INLINED)
def longest(t, t_start, h_first, h_max):
    """The longest step; at the start, the given first step."""
    first = smaller(t * 0.0 + h_first, h_max)
    return select((t == t_start) & (first > 0.0), first, t * 0.0 + h_max)


@njit(**INLINED)
def retry(t, x, size, scale):
    """(again, shorter, short): `again` is true if the series needs a shorter unit of time.

    The series has an infinity or a NaN, or the terms allow a length x below COARSE.  In these cases
    `shorter` is the next unit of time; `short` is true if `shorter` is too short.
    """
    wild = size - size != 0.0
    shorter = scale * select(wild, x * 0.0 + SHRINK, x)
    return wild | (x < COARSE), shorter, shorter <= LEAST * abs(t) + SHORTEST


@njit(**INLINED)
def allowed(x, size, scale, longest):
    """The length of a step whose terms allow the length x, in units of `scale`.

    `size` is the sum of the absolute values of the terms.
    """
    longest = select(size == 0.0, longest * BLIND, longest)
    return smaller(x * scale, smaller(scale * GROWTH, longest))


@njit(**INLINED)
def landed(t, h, t_end, direction):
    """(the time after a step of length h, the signed length, whether the step ends at t_end)."""
    ends = h >= abs(t_end - t)
    later = select(ends, t_end, h * direction + t)
    return later, later - t, ends  # without rounding: t + (later - t) is `later`
