"""The length of a step from the terms of its series, for one trajectory or one in each lane."""

from typing import Any, NamedTuple

from ..text.instructions import ONE, ZERO, hexadecimal

EXPONENT_BITS = 0x7FF << 52
GROWTH = 2.0**16  # longest step, in the unit of the series: terms that limit it may be 0
SHRINK = 2.0**-16  # multiplies the unit of time after an overflow of coefficients
LEAST = 2.0**-60  # a step shorter than this share of |t| does not change t
SHORTEST = 1e-280
BLIND = 1.0 / 8.0  # if all terms vanish, the step is this share of the longest step
# A step shorter than this share of its unit is computed again with a shorter unit, because the
# weight of a small component contains its change in one unit: see `step.weight`.
COARSE = 1.0 / 4.0


class Clock(NamedTuple):
    """The time of a step and its bounds, as LLVM values."""

    t: Any
    t_end: Any
    direction: Any
    longest: Any


class Pace(NamedTuple):
    """The chosen step, as LLVM values.

    Attributes
    ----------
    h, signed
        The length without and with sign.
    t
        The time after the step.
    ends
        Whether the step ends at t_end.
    stuck
        Whether the step does not change the time.
    """

    h: Any
    signed: Any
    t: Any
    ends: Any
    stuck: Any


def unit_of(text, h):
    """The power of two below a length; 1 if the length is 0 or not finite."""
    bits = text.of_bits("and", text.bits(h), EXPONENT_BITS)
    none, wild = (
        text.new(f"icmp eq {text.whole} {bits}, {text.wholes(n)}") for n in (0, EXPONENT_BITS)
    )
    return text.select(text.truths("or", none, wild), ONE, text.real(bits))


def longest(text, t, t_start, h_first, h_max):
    """The longest step; at the start, the given first step."""
    given = text.compare("ogt", h_first, ZERO)
    first = text.truths("and", given, text.compare("oeq", t, t_start))
    return text.select(first, text.smaller(h_first, h_max), h_max)


def retry(text, t, x, size, scale):
    """(again, shorter, short): `again` is true if the series needs a shorter unit of time.

    The series has an infinity or a NaN, or the terms allow a length x below COARSE.  In these cases
    `shorter` is the next unit of time; `short` is true if `shorter` is too short.
    """
    wild = text.compare("uno", text.sub(size, size), ZERO)
    coarse = text.compare("olt", x, hexadecimal(COARSE))
    shorter = text.select(wild, hexadecimal(SHRINK), x)
    shorter = text.mul(scale, shorter)
    least = text.mul(hexadecimal(LEAST), text.intrinsic("fabs", t))
    least = text.add(least, hexadecimal(SHORTEST))
    return text.truths("or", wild, coarse), shorter, text.compare("ule", shorter, least)


def chosen(text, clock, x, size, scale, limited=None):
    """The Pace of a step whose terms allow the length x, in units of `scale`.

    `size` is the sum of the absolute values of the terms.  ``limited(x)``, for one trajectory only,
    returns the signed length x or a shorter length.
    """
    longest = text.mul(clock.longest, hexadecimal(BLIND))
    longest = text.select(text.compare("oeq", size, ZERO), longest, clock.longest)
    longest = text.smaller(text.mul(scale, hexadecimal(GROWTH)), longest)
    h = text.smaller(text.mul(x, scale), longest)
    if limited is not None:
        x = limited(text.mul(text.mul(h, text.div(ONE, scale)), clock.direction))
        h = text.mul(text.intrinsic("fabs", x), scale)
    left = text.sub(clock.t_end, clock.t)
    ends = text.compare("oge", h, text.intrinsic("fabs", left))
    later = text.select(ends, clock.t_end, text.fma(h, clock.direction, clock.t))
    signed = text.sub(later, clock.t)  # without rounding: t + signed is `later`
    stuck = text.compare("oeq", later, clock.t)
    return Pace(h, signed, later, ends, stuck)
