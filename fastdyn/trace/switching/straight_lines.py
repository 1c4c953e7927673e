"""Switching times of comparisons of expressions that are affine in the time on the whole span.

These are most of all: ``5 < t < 6``, ``t > t_on``.  Each expression is a height at t = 0 and a
slope, computed from the present parameters in a few microseconds.
"""

import numpy as np

from ..graph.expressions import live
from ..operations import OPERATIONS


def compares(node):
    """Whether a node is a comparison."""
    operation = OPERATIONS[node.op]
    return bool(operation.sign) and operation.truth


class StraightLines:
    """The operands of comparisons, and of absolute values, as lines.

    Parameters
    ----------
    graph : Graph
    timed : set of int
        The keys of the nodes that depend on the time.
    switching : list of Node
    nodes : list of Node
        The nodes below them in order.
    """

    def __init__(self, graph, timed, switching, nodes):
        self._graph, self._timed, self._nodes = graph, timed, nodes
        self._pairs = [node.args for node in switching]

    def times(self, values, varying, first, last, count):
        """Members, times in rising order, and that all are sharp: see `Switches.times`."""
        lines: dict = {}
        with np.errstate(all="ignore"):
            for node in self._nodes:
                of = [lines[a.key] for a in node.args]
                lines[node.key] = self._line(node, of, values, varying)
            found = [_crossing(*[lines[a.key] for a in pair]) for pair in self._pairs]
        if count == 1:
            t = sorted({t for t in found if first <= t <= last})
            return np.zeros(len(t), int), np.array(t), np.ones(len(t), bool)
        t = np.array([np.broadcast_to(each, count) for each in found]).T
        member, place = np.nonzero((t >= first) & (t <= last))
        t = t[member, place]
        order = np.lexsort((t, member))
        return member[order], t[order], np.ones(len(t), bool)

    def _line(self, node, of, values, varying):
        """(height, slope) of a node from those of its operands."""
        op = node.op
        if op == "t":
            return 0.0, 1.0
        if op == "const":
            return np.float64(node.data), 0.0
        if op == "par":
            found = varying.get(node.data)
            return np.float64(values[node.data]) if found is None else found, 0.0
        if node.key not in self._timed:
            return self._graph.compute(node, [height for height, _ in of], values), 0.0
        (a, slope), (b, other) = of[0], of[-1]
        if op == "neg":
            return -a, -slope
        if op == "add":
            return a + b, slope + other
        if op == "sub":
            return a - b, slope - other
        if op == "mul":
            return a * b, slope * b + a * other
        return a / b, slope / b


def _crossing(line, other=(0.0, 0.0)):
    """The time at which two lines meet; not finite for parallels."""
    return np.divide(other[0] - line[0], line[1] - other[1])


def straight_lines(graph, timed, switching):
    """The StraightLines of nodes that switch; None if an operand is no line."""
    if any(not compares(node) and node.op != "abs" for node in switching):
        return None
    nodes = live([a for node in switching for a in node.args])
    if all(_is_line(node, timed) for node in nodes if node.key in timed):
        return StraightLines(graph, timed, switching, nodes)
    return None


def _is_line(node, timed):
    """Whether a node is a line if its operands are."""
    if node.op in ("t", "neg", "add", "sub"):
        return True
    by_time = [a.key in timed for a in node.args]
    return (node.op == "mul" and not all(by_time)) or (node.op == "div" and not by_time[1])
