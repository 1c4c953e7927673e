"""Switching times: where expressions of the time and of parameters alone jump or have a kink.

The operations are taken in order.  Each one that may switch (a comparison, rounding, a table, a
remainder) divides the span at the times of its switches; between these times it is constant or
smooth.  Where its operand is affine between the divisions made so far, which holds for comparisons,
floors and remainders of the time however they are nested, the times are exact to rounding.  Where
the operand is monotone (an exponential or a sine between its extrema), they are found by halving.
Any other operand, a sum of sines say, is sampled: switches back and forth between two samples are
not found.  Of all divisions, those are switching times at which a number that meets the state jumps
or bends, for the values of the parameters, or for other values of those that are differentiated:
where equal pieces of a table meet, the derivatives by the pieces jump.
"""

import itertools
from typing import NamedTuple

import numpy as np

from ..graph.evaluate import evaluate
from ..graph.expressions import live
from ..graph.values import ranges_of
from ..operations import OPERATIONS
from . import divisions
from .divisions import FAR, NOISE, ROUNDINGS, Divisions, Parameters, TooMany
from .straight_lines import compares, straight_lines

OF_STATE = frozenset(("y", "item", "arg"))
NEAR = 1e-9  # distance of the points that show a jump at an end, as a share of the span


class Times(NamedTuple):
    """Switching times in rising order for each member; `end` is the time up to which they are all.

    `sharp` tells which are large jumps and bends: see SHARP of `divisions`.
    """

    member: np.ndarray
    t: np.ndarray
    sharp: np.ndarray
    end: float


class Switches:
    """The operations of a graph that switch with the time, and the numbers that meet the state.

    Attributes
    ----------
    slots : list of range
        The slots of the parameters on which the times depend.
    """

    def __init__(self, graph, timed, seen, switching, differentiated):
        self.graph, self.timed, self.seen = graph, timed, seen
        self._differentiated = np.array(differentiated, int)
        self.nodes = [node for node in live(switching) if node.key in timed]
        found: set = set()
        for node in live(seen):
            if node.op == "par":
                found.add(range(node.data, node.data + 1))
            found.update(ranges_of(node, graph.tables))
        self.slots = sorted(found, key=lambda slots: slots.start)
        self._lines = straight_lines(graph, timed, switching)

    def times(self, values, t0, tf, count=1, varying=None, most=None) -> Times:
        """The switching times between t0 and tf, which may be infinite.

        Parameters
        ----------
        values : ndarray
            The parameters by slot.
        count : int
            The number of members.
        varying : dict of int to ndarray, optional
            By slot, the parameters that vary between members.
        most : int, optional
            The largest number of times for one member; `divisions.MOST` if None.
        """
        found = self._all_times(values, t0, tf, count, varying or {}, most or divisions.MOST)
        ends = [t for t in (t0, tf) if abs(t) < FAR]
        off = ROUNDINGS * max(map(abs, ends))
        at_end = np.min([np.abs(found.t - t) for t in ends], axis=0) <= off
        if not at_end.any():
            return found
        keep, (member, t) = ~at_end, (each[at_end] for each in found[:2])
        keep[at_end] = self._jumps_at_ends(values, varying or {}, member, t, t0, tf)
        return Times(found.member[keep], found.t[keep], found.sharp[keep], found.end)

    def looked_at(self, values):
        """The parameters, and others with random numbers for those that are differentiated."""
        moved = self._differentiated
        if not len(moved):
            return [values]
        other, rng = np.array(values, float), np.random.default_rng(0)
        other[moved] += rng.uniform(1.0, 2.0, len(moved)) * (np.abs(other[moved]).max() or 1.0)
        return [values, other]

    def _jumps_at_ends(self, values, varying, member, t, t0, tf):
        """Whether a number jumps between an end of the span, near the times t, and the span."""
        end = np.where(np.abs(t - t0) <= np.abs(t - tf), t0, tf)
        inwards = np.where(end == min(t0, tf), 1.0, -1.0) * NEAR * min(abs(tf - t0), 1.0)
        jumps = np.zeros(len(t), bool)
        all_given = [Parameters(each, varying, member) for each in self.looked_at(values)]
        for node, given in itertools.product(self.seen, all_given):
            there, near, far = (
                evaluate(self.graph, [node], end + k * inwards, (), given)[0][0] for k in range(3)
            )
            limit = 2.0 * near - far
            size = np.maximum(np.abs(there), np.abs(limit))
            jumps |= ~(np.abs(there - limit) <= NOISE * size)  # also where one is not a number
        return jumps

    def _all_times(self, values, t0, tf, count, varying, most):
        """The Times, with all at the ends of the span."""
        first, last, end = max(min(t0, tf), -FAR), min(max(t0, tf), FAR), tf
        if self._lines is not None:
            return Times(*self._lines.times(values, varying, first, last, count), tf)
        while True:
            try:
                found = Divisions(self, values, varying, first, last, count, most).found()
                return Times(*found, end)
            except TooMany as reason:
                if count > 1:
                    return self._of_halves(values, t0, tf, count, varying, most)
                length = min(reason.length, 0.5 * (last - first))
                if tf < t0:
                    end = first = last - length
                else:
                    end = last = first + length

    def _of_halves(self, values, t0, tf, count, varying, most):
        """The Times of many members, from those of two halves of them."""
        half = count // 2
        parts = [
            {slot: v[part] for slot, v in varying.items()}
            for part in (slice(half), slice(half, None))
        ]
        one = self._all_times(values, t0, tf, half, parts[0], most)
        other = self._all_times(values, t0, tf, count - half, parts[1], most)
        end = one.end if abs(one.end - t0) < abs(other.end - t0) else other.end
        return Times(
            np.r_[one.member, other.member + half], np.r_[one.t, other.t],
            np.r_[one.sharp, other.sharp], end,
        )  # fmt: skip


def switches(graph, outputs, differentiated=()):
    """The Switches of outputs; None if nothing in them switches with the time alone.

    `differentiated` are slots of parameters.
    """
    timed, mixed, seen = set(), set(), {node.key: node for node in outputs}
    nodes = live(outputs)
    for node in nodes:
        if node.op in OF_STATE or any(a.key in mixed for a in node.args):
            mixed.add(node.key)
            seen |= {a.key: a for a in node.args}
        elif node.op == "t" or any(a.key in timed for a in node.args):
            timed.add(node.key)
    seen = [node for node in seen.values() if node.key in timed]
    switching = [node for node in live(seen) if node.key in timed and _may_switch(node)]
    return Switches(graph, timed, seen, switching, differentiated) if switching else None


def _may_switch(node):
    if compares(node):
        return node.args[0] is not node.args[1]  # else a test for NaN
    operation = OPERATIONS[node.op]
    jumps = operation.decision and node.op != "select"  # the condition of a select switches
    return jumps or operation.kinked or operation.tables
