"""Where the functions of `math` raise: lists of pairs (condition, function that raises likewise).

A rule gets the function of `math`, the value, and the operands.
"""

import math

from .value import floor

LARGEST = 1.7976931348623157e308


def nowhere(function, o, *args):
    return []


def outside(condition, example):
    """Where the operand fulfils a condition, as the example does."""
    return lambda function, o, a: [(condition(a), lambda: function(example))]


def overflow(function, o, *args):
    return [(overflows(o, *args), lambda: math.exp(1e4))]


def overflow_or_nan(function, o, *args):
    """Where numbers give NaN, or finite operands an infinite value."""
    none = o != o
    for a in args:
        none = none & (a == a)
    return [(none, lambda: math.sqrt(-1.0)), *overflow(function, o, *args)]


def poles_of_gamma(function, o, a):
    """As `overflow_or_nan`, and at the poles, where C's function is infinite."""
    at_pole = (a <= 0.0) & (floor(a) == a)
    return [(at_pole, lambda: function(-1.0)), *overflow_or_nan(function, o, a)]


def overflows(o, *args):
    """The condition that all operands are finite and the value is not."""
    bad = ~(abs(o) <= LARGEST)
    for a in args:
        bad = bad & (abs(a) <= LARGEST)
    return bad
