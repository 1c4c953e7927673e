"""Times at which operations on expressions that are affine in the time, on the whole span, switch.

These are most of all: ``5 < t < 6``, ``t > t_on``, ``int(t / 0.05)``, ``np.interp(t, knots, ...)``.
Each expression is a height at t = 0 and a slope, computed from the present parameters in a few
microseconds; the times are formulas of these two, of whole numbers, and of the knots of tables.
"""

import bisect
import math
from typing import NamedTuple

import numpy as np

from ..graph.expressions import live
from ..graph.values import contents
from ..operations import OPERATIONS
from .decided import FAR, ROUNDINGS, Candidates

NO_MEMBERS = np.empty(0, int)
NO_TIMES = np.empty(0)
MOST_LISTED = 2**12
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


class Knots:
    """Rising times, most of them those of the knots of tables, with weights."""

    def __init__(self, t, weight):
        self._t = t
        self._weight = weight
        # a search takes a fifth of that in an array, and a number four times the memory
        self._listed = t.tolist() if len(t) <= MOST_LISTED else t
        self.gap = float((t[1:] - t[:-1]).min(initial=math.inf))

    def within(self, first, last, most):
        """The times from first to last, and their weights."""
        begin = bisect.bisect_left(self._listed, first)
        end = bisect.bisect_right(self._listed, last)
        return self._t[begin:end], self._weight[begin:end]


class Whole(NamedTuple):
    """The times at which ``height + slope t`` is a whole number."""

    height: float
    slope: float

    @property
    def gap(self):
        """The smallest distance of two times."""
        return 1.0 / abs(self.slope)

    def within(self, first, last, most):
        """As of Knots; raises TooMany."""
        if not (self.slope and math.isfinite(self.slope) and math.isfinite(self.height)):
            return NO_TIMES, NO_TIMES
        low, high = sorted((self.height + self.slope * first, self.height + self.slope * last))
        count = high - low
        if count > most:
            raise TooMany(0.5 * most / abs(self.slope))
        whole = np.arange(math.ceil(low - 1e-9), math.floor(high + 1e-9) + 1.0)
        t = np.sort((whole - self.height) / self.slope)
        t = t[(t >= first) & (t <= last)]
        return t, np.zeros(len(t))


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
        """The times of zeros for members that vary, each an array, and Knots and Wholes."""
        lines: dict = {}
        with np.errstate(all="ignore"):
            for node in self._nodes:
                of = [lines.get(a.key) for a in node.args]
                lines[node.key] = self._line(node, of, values, varying or {})
            zeros = []
            knots = []
            wholes = []
            for rule, node in self._rules:
                of = [lines.get(a.key) for a in node.args]
                if rule == "zeros":
                    zeros.append(_crossing(*of))
                elif rule == "knots":
                    knots.append(self._knots(node, of, values))
                else:
                    wholes.append(_whole(rule, node, of))
        if varying:
            return zeros, ()
        known = np.array(sorted([t for t in map(float, zeros) if math.isfinite(t)]))
        return (), (_joined((known, np.zeros(len(known))), *knots), *wholes)

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
            return _of_members(member[order], t[order], (first, last), end, off, count)
        own, *wholes = lines
        t, weight = own.within(early, late, most)
        gap = own.gap
        for grid in wholes:
            more, weights = grid.within(early, late, most)
            if not len(more):
                continue
            gap = 0.0 if len(t) else grid.gap
            t = np.concatenate([t, more])
            order = t.argsort()
            t = t[order]
            weight = np.concatenate([weight, weights])[order]
        if len(t) > most:
            raise TooMany(0.5 * (last - first))
        return _of_one(t, weight, (first, last), end, off, self.sure, gap)

    def _knots(self, node, of, values):
        """The times at the knots of a table, in rising order, and their weights."""
        height, slope = of[0]
        data = contents(node, self._graph.tables, values)
        knots = np.asarray(data[0], float)
        weight = np.zeros(len(knots))
        if degree(node) > 1:
            heights = np.asarray(self._graph.compute(node, [knots], values), float)
            weight = self._weigh(knots, heights)
        if not slope:
            return NO_TIMES, NO_TIMES
        t = (knots - height) / slope
        return (t, weight) if slope > 0.0 else (t[::-1], weight[::-1])

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


def _joined(*parts):
    """The Knots of several pairs of rising times and their weights."""
    t, weight = map(np.concatenate, zip(*parts, strict=True))
    known = np.isfinite(t)
    order = t[known].argsort()
    return Knots(t[known][order], weight[known][order])


def _whole(rule, node, of):
    """The Whole of a node, from the lines of its operands."""
    height, slope = of[0]
    if rule == "turns":
        return Whole(float(height / np.pi + PHASE[node.op]), float(slope / np.pi))
    if rule == "quotient":
        return Whole(float(height / of[1][0]), float(slope / of[1][0]))
    return Whole(float(height + (0.5 if node.op == "rint" else 0.0)), float(slope))


def _of_one(t, weight, span, end, off, sure, gap):
    """The Candidates of sorted times, of which those that are equal to rounding become one.

    No two times are nearer than `gap`.
    """
    first, last = span
    begin = 0
    stop = len(t)
    while begin < stop and t.item(begin) - first <= off:
        begin += 1
    while begin < stop and last - t.item(stop - 1) <= off:
        stop -= 1
    ends = [first] * (begin > 0) + [last] * (stop < len(t))
    at_ends = NO_MEMBERS, NO_TIMES
    if ends:
        at_ends = np.zeros(len(ends), int), np.array(ends)
    t = t[begin:stop]
    weight = weight[begin:stop]
    if stop - begin > 1 and gap <= 2.0 * off:
        apart = t[1:] - t[:-1] > off
        if not apart.all():
            at = np.flatnonzero(np.concatenate([[True], apart]))
            t = t[at]
            weight = np.maximum.reduceat(weight, at)
    return Candidates(np.zeros(len(t), int), t, weight, at_ends, span, end, sure)


def _of_members(member, t, span, end, off, count):
    """As `_of_one`, for the zeros of several members, which are sure."""
    first, last = span
    early = t - first <= off
    near = early | (last - t <= off)
    ends = np.unique(np.array([member[near], np.where(early[near], first, last)]), axis=1)
    keep = ~near
    member = member[keep]
    t = t[keep]
    apart = np.ones(len(t), bool)
    apart[1:] = (t[1:] - t[:-1] > off) | (member[1:] != member[:-1])
    at_ends = ends[0].astype(int), ends[1]
    none = np.zeros(int(apart.sum()))
    return Candidates(member[apart], t[apart], none, at_ends, span, end, True, count)


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
