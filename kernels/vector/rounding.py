"""Functions of vectors that take a few operations."""

import math

from .emit import named, outlined, signed, where
from .exponential import INF


def square(x):
    return x * x


def reciprocal(x):
    return 1.0 / x


def radians(x):
    return x * (math.pi / 180)


def degrees(x):
    return x * (180 / math.pi)


def sign(x):
    return where(x > 0.0, 1.0, where(x < 0.0, -1.0, x))


def not_a_number(x):
    return x != x


def infinite(x):
    return abs(x) == INF


def finite(x):
    return abs(x) < INF


@outlined
def fraction_left(a, b):
    """C's fmod."""
    return a % b


def below(rest, b):
    """Whether fmod's remainder is on the wrong side of zero for Python."""
    return (rest != 0.0) & ((rest < 0.0) ^ (b < 0.0))


@outlined
def remainder(a, b):
    """a - floor(a / b) b, with the sign of b, as in Python."""
    rest = a % b
    return where(below(rest, b), rest + b, where(rest == 0.0, signed(rest, b), rest))


@outlined
def whole_quotient(a, b):
    """floor(a / b) as in Python; where b is zero, a / b."""
    rest = a % b
    ratio = (a - rest) / b
    ratio = where(below(rest, b), ratio - 1.0, ratio)
    whole = named("floor", ratio)
    whole = where(ratio - whole > 0.5, whole + 1.0, whole)
    return where(b == 0.0, a / b, where(whole == 0.0, signed(whole, a / b), whole))
