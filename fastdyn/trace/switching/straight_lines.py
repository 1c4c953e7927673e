"""Times at which operations on expressions that are affine in the time, on the whole span, switch.

These are most of all: ``5 < t < 6``, ``t > t_on``, ``int(t / 0.05)``, ``np.interp(t, knots, ...)``.
Each expression is a height at t = 0 and a slope, computed from the present parameters in a few
microseconds; the times are formulas of these two, of whole numbers, and of the knots of tables.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ..graph.expressions import live
from ..graph.values import contents
from ..operations import OPERATIONS
from .decided import FAR, ROUNDINGS, Candidates

NO_MEMBERS = np.empty(0, int)
LINE, STEPS, OTHER = range(3)  # kinds of expressions; STEPS are constant between switching times
PHASE = {"sin": 0.5, "cos": 0.0, "tan": 0.5}  # whole numbers of x / pi + PHASE are turns


def compares(node):
    """Whether a node is a comparison."""
    operation = OPERATIONS[node.op]
    return bool(operation.sign) and operation.truth


def may_switch(node):
    """Whether the value of a node jumps or bends where its operands do not."""
    if compares(node):
        return node.args[0] is not node.args[1]  # else a test for NaN
    operation = OPERATIONS[node.op]
    jumps = operation.decision and node.op != "select"  # the condition of a select switches
    return jumps or operation.kinked or operation.tables


class TooMany(Exception):
    """There are more times than asked for; a span of this `length` has fewer, perhaps."""

    def __init__(self, length):
        super().__init__()
        self.length = length


class Grid(NamedTuple):
    """Times on a line: those of a table's knots, or all whole numbers of ``height + slope t``."""

    knots: Any  # rising times; None for whole numbers
    weight: Any = None  # of each knot
    height: float = 0.0
    slope: float = 0.0

    def within(self, first, last, most):
        """The times from first to last, and their weights."""
        if self.knots is not None:
            begin = self.knots.searchsorted(first)
            end = self.knots.searchsorted(last, "right")
            return self.knots[begin:end], None if self.weight is None else self.weight[begin:end]
        if not (self.slope and math.isfinite(self.slope) and math.isfinite(self.height)):
            return (), None
        low, high = sorted((self.height + self.slope * first, self.height + self.slope * last))
        count = high - low
        if count > most:
            raise TooMany(0.5 * most / abs(self.slope))
        whole = np.arange(math.ceil(low - 1e-9), math.floor(high + 1e-9) + 1.0)
        t = np.sort((whole - self.height) / self.slope)
        return t[(t >= first) & (t <= last)], None


class StraightLines:
    """The operations of a graph that switch, all of whose operands are lines or steps.

    Parameters
    ----------
    graph : Graph
    timed : set of int
        The keys of the nodes that depend on the time.
    rules : list of (str, Node)
        "zeros", "whole", "turns", "quotient" or "knots" of each node that switches.
    weigh : callable
        ``weigh(knots, heights)``: the weights of the knots of smooth tables.

    Attributes
    ----------
    sure : bool
        Whether all times are of comparisons and of absolute values, which nobody decides upon.
    """

    def __init__(self, graph, timed, rules, weigh):
        self._graph = graph
        self._timed = timed
        self._rules = rules
        self._weigh = weigh
        self._nodes = live([a for _, node in rules for a in node.args])  # lines and constants
        self.sure = all(rule == "zeros" for rule, _ in rules)

    def grids(self, values, varying=()):
        """The times of zeros, and the Grids; zeros are arrays for members that vary."""
        lines: dict = {}
        with np.errstate(all="ignore"):
            for node in self._nodes:
                of = [lines.get(a.key) for a in node.args]
                lines[node.key] = self._line(node, of, values, varying or {})
            zeros = []
            grids = []
            for rule, node in self._rules:
                if rule == "zeros":
                    zeros.append(_crossing(*[lines[a.key] for a in node.args]))
                else:
                    grids.append(
                        self._grid(rule, node, [lines.get(a.key) for a in node.args], values)
                    )
        return zeros, grids

    def candidates(self, grids, first, last, end, count, most):
        """The Candidates between two times; raises TooMany."""
        zeros, lines = grids
        off = ROUNDINGS * max(abs(t) for t in (first, last, 0.0) if abs(t) < FAR)
        early = first - off
        late = last + off
        if count > 1:
            t = np.array([np.broadcast_to(each, count) for each in zeros]).T
            member, place = np.nonzero((t >= early) & (t <= late))
            t = t[member, place]
            order = np.lexsort((t, member))
            return _sorted(member[order], t[order], None, (first, last), end, off, True, count)
        t = np.array(sorted([t for t in zeros if early <= t <= late]))
        weight = None
        found = [each for grid in lines if len((each := grid.within(early, late, most))[0])]
        if found:
            weight = [np.zeros(len(t)) if w is None else w for t, w in ((t, None), *found)]
            t = np.concatenate([t, *[t for t, _ in found]])
            weight = np.concatenate(weight)
            if len(t) > most:
                raise TooMany(0.5 * (last - first))
            order = t.argsort()
            t = t[order]
            weight = weight[order]
        elif not len(t):
            return Candidates(NO_MEMBERS, t, t, (NO_MEMBERS, t), (first, last), end, self.sure)
        return _sorted(None, t, weight, (first, last), end, off, self.sure)

    def _grid(self, rule, node, of, values):
        height, slope = of[0]
        if rule == "turns":
            return Grid(None, None, float(height / np.pi + PHASE[node.op]), float(slope / np.pi))
        if rule == "quotient":
            return Grid(None, None, float(height / of[1][0]), float(slope / of[1][0]))
        if rule == "whole":
            shift = 0.5 if node.op == "rint" else 0.0
            return Grid(None, None, float(height + shift), float(slope))
        data = contents(node, self._graph.tables, values)
        knots = np.asarray(data[0], float)
        weight = None
        if degree(node) > 1:
            heights = np.asarray(self._graph.compute(node, [knots], values), float)
            weight = self._weigh(knots, heights)
        t = (knots - height) / slope
        if slope < 0.0:
            return Grid(t[::-1].copy(), None if weight is None else weight[::-1].copy())
        return Grid(t if slope else t[:0], weight)

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
        a, slope = of[0]
        b, other = of[-1]
        if op == "neg":
            return -a, -slope
        if op == "add":
            return a + b, slope + other
        if op == "sub":
            return a - b, slope - other
        if op == "mul":
            return a * b, slope * b + a * other
        return a / b, slope / b


def _sorted(member, t, weight, span, end, off, sure, count=1):
    """The Candidates of sorted times, of which those that are equal to rounding become one."""
    member = np.zeros(len(t), int) if member is None else member
    weight = np.zeros(len(t)) if weight is None else weight
    first, last = span
    early = t - first <= off
    near = early | (last - t <= off)
    at_ends = member[near], np.where(early[near], first, last)
    if near.any():
        keep = ~near
        member = member[keep]
        t = t[keep]
        weight = weight[keep]
        if len(at_ends[0]) > 1:
            at_ends = tuple(np.unique(np.array(at_ends), axis=1))
            at_ends = at_ends[0].astype(int), at_ends[1]
    if len(t) > 1:
        begins = np.r_[True, (t[1:] - t[:-1] > off) | (member[1:] != member[:-1])]
        if not begins.all():
            at = np.flatnonzero(begins)
            member = member[at]
            t = t[at]
            weight = np.maximum.reduceat(weight, at)
    return Candidates(member, t, weight, at_ends, span, end, sure, count)


def _crossing(line, other=(0.0, 0.0)):
    """The time at which two lines meet; not finite for parallels."""
    return np.divide(other[0] - line[0], line[1] - other[1])


def straight_lines(graph, timed, seen, weigh):
    """The StraightLines of nodes that meet the state; None if an operand is neither line nor steps.

    An elementary function of a line may turn anywhere, and divides the span for the decision which
    times matter: sines do at whole numbers, others have no formula here.
    """
    kinds = {}
    rules = []
    for node in live(seen):
        if node.key not in timed:
            continue
        rule, kinds[node.key] = _rule(node, timed, kinds)
        if rule == "none":
            return None
        if rule:
            rules.append((rule, node))
    return StraightLines(graph, timed, rules, weigh)


def _rule(node, timed, kinds):
    """The rule of a node that switches, and the kind of its value."""
    of = [kinds[a.key] for a in node.args if a.key in timed]
    first = kinds.get(node.args[0].key, LINE) if node.args else LINE
    if node.args and set(of) == {STEPS}:
        return "", STEPS
    if not may_switch(node):
        if node.op in PHASE and first == LINE:
            return "turns", OTHER
        if OPERATIONS[node.op].elementary and node.op not in ("exp", "sqrt"):
            return "none", OTHER
        return "", STEPS if node.op in ("and", "or", "not") else _kind(node, timed, kinds)
    if OTHER in of or STEPS in of:
        return "none", OTHER
    if compares(node):
        return "zeros", STEPS
    if node.op == "abs":
        return "zeros", OTHER
    if OPERATIONS[node.op].tables:
        if node.op == "table":
            return "whole", STEPS
        return "knots", STEPS if degree(node) == 0 else OTHER
    if OPERATIONS[node.op].whole:
        return "whole", STEPS
    if node.op == "fmod" and node.args[1].key not in timed:
        return "quotient", OTHER
    return "none", OTHER


def _kind(node, timed, kinds=None):
    """LINE or OTHER: whether a node that does not switch is a line if its operands are."""
    if kinds is not None and any(kinds[a.key] != LINE for a in node.args if a.key in timed):
        return OTHER
    if node.op in ("t", "neg", "add", "sub"):
        return LINE
    by_time = [a.key in timed for a in node.args]
    line = (node.op == "mul" and not all(by_time)) or (node.op == "div" and not by_time[1])
    return LINE if line else OTHER


def degree(node):
    """The degree of the pieces of a table on knots."""
    return {"search": 0, "interpolate": 1}.get(node.op, len(node.data) - 2)
