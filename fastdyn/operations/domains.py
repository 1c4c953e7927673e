"""Where the functions of `math` raise: lists of pairs (condition, function that raises likewise).

Each rule is called with the graph, the function of `math`, the value and the operands.
"""

import math

LARGEST = 1.7976931348623157e308


def nowhere(g, function, result, args):
    return []


def outside(sign, limit, of_size=False):
    """Where the operand, or its size, compares with a limit by `sign`."""
    bad = limit if sign == "eq" else -2.0 if sign in ("lt", "le") else 2.0

    def raises(g, function, result, args):
        x = g.call("abs", *args) if of_size else args[0]
        return [(g.compare(x, g.const(limit), sign), lambda: function(bad))]

    return raises


def overflow(g, function, result, args):
    return [(overflows(g, result, args), lambda: math.exp(1e4))]


def overflow_or_nan(g, function, result, args):
    """Where finite operands give an infinite value, or numbers give NaN."""
    none = g.compare(result, result, "ne")
    for a in args:
        none = g.both(none, g.compare(a, a, "eq"))
    return [*overflow(g, function, result, args), (none, lambda: math.sqrt(-1.0))]


def poles_of_gamma(g, function, result, args):
    """As `overflow_or_nan`, and at the poles, where C's function is infinite."""
    (a,) = args
    at_pole = g.both(g.compare(a, g.const(0.0), "le"), g.compare(g.call("floor", a), a, "eq"))
    return [(at_pole, lambda: function(-1.0)), *overflow_or_nan(g, function, result, args)]


def is_finite(g, a):
    return g.compare(g.call("abs", a), g.const(LARGEST), "le")


def overflows(g, result, args):
    """The condition that all `args` are finite and the result is not."""
    bad = g.negation(is_finite(g, result))
    for a in args:
        bad = g.both(bad, is_finite(g, a))
    return bad
