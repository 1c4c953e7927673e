"""Exceptions of Python's arithmetic, and bounds of whole numbers."""

import math

from .expressions import Graph

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
