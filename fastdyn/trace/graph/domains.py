"""The conditions under which Python's arithmetic and the functions of `math` raise."""

import math

from .expressions import Graph

# C function: (comparison, limit, whether |x| is compared); undefined where x satisfies it
OUTSIDE = {
    "sin": ("eq", float("inf"), True), "cos": ("eq", float("inf"), True),
    "tan": ("eq", float("inf"), True), "asin": ("gt", 1.0, True), "acos": ("gt", 1.0, True),
    "atanh": ("ge", 1.0, True), "log": ("le", 0.0, False), "log2": ("le", 0.0, False),
    "log10": ("le", 0.0, False), "log1p": ("le", -1.0, False), "sqrt": ("lt", 0.0, False),
    "acosh": ("lt", 1.0, False),
}  # fmt: skip
GROWING = {"exp", "expm1", "exp2", "sinh", "cosh"}
NEVER = {"atan", "atan2", "tanh", "asinh", "erf", "erfc", "cbrt"}
LARGEST = 1.7976931348623157e308
WHOLE = 2**53  # floats represent all integers up to this absolute value
INDEX = 2**31  # limit of integers that depend on the state


def divided_by_zero():
    """Raise ZeroDivisionError with Python's message."""
    return 1.0 / 0.0


def zero_to_a_negative_power():
    """Raise ZeroDivisionError with Python's message."""
    return 0.0**-1.0


def too_large_a_power():
    """Raise OverflowError with Python's message."""
    return 10.0**400.0


def is_finite(g: Graph, node):
    return g.compare(g.make("abs", (node,)), g.const(LARGEST), "le")


def failures(g: Graph, name, result, args):
    """List pairs (condition, raising): ``math.name(*args)`` raises where a condition holds.

    The function ``raising()`` raises the exception that `math` raises there.
    """
    if name in NEVER:
        return []
    if name in OUTSIDE:
        sign, limit, of_size = OUTSIDE[name]
        x = g.make("abs", args) if of_size else args[0]
        bad = limit if sign == "eq" else -2.0 if sign in ("lt", "le") else 2.0
        return [(g.compare(x, g.const(limit), sign), lambda: getattr(math, name)(bad))]
    found = [(overflows(g, result, args), lambda: math.exp(1e4))]
    if name not in GROWING:
        none = g.compare(result, result, "ne")
        for a in args:
            none = g.both(none, g.compare(a, a, "eq"))
        found.append((none, lambda: math.sqrt(-1.0)))
        if name == "tgamma":  # C returns infinity where `math.gamma` raises
            at_pole = g.both(
                g.compare(args[0], g.const(0.0), "le"),
                g.compare(g.make("round", args, "floor"), args[0], "eq"),
            )
            found.insert(0, (at_pole, lambda: math.gamma(-1.0)))
    return found


def overflows(g: Graph, result, args):
    """The condition that all `args` are finite and the result is not."""
    bad = g.negation(is_finite(g, result))
    for a in args:
        bad = g.both(bad, is_finite(g, a))
    return bad


def bound(g: Graph, node):
    """An upper bound of the absolute value of an integer; inf if no bound is known."""
    known = g.bounds.get(node.key)
    if known is None:
        known = g.bounds[node.key] = _bound(g, node)
    return known


def _bound(g, node):
    if node.op == "const":
        return abs(node.data)
    if node.op == "par":
        return g.largest_whole
    if node.op == "select":
        return max(bound(g, a) for a in node.args[1:])
    if node.op in ("neg", "abs"):
        return bound(g, node.args[0])
    if node.op in ("add", "sub"):
        return sum(bound(g, a) for a in node.args)
    if node.op == "mul":
        return math.prod(bound(g, a) for a in node.args)
    return math.inf
