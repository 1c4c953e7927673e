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

import numpy as np

from ..graph.expressions import is_zero, live
from ..graph.signs import forced
from ..graph.values import ranges_of
from ..operations.delays import PASTS
from . import divisions
from .decided import FAR, Candidates, Times, decided
from .divisions import Divisions, weigh
from .straight_lines import TooMany, degree, may_switch, straight_lines

OF_STATE = PASTS.union(("y", "item", "arg"))  # the past is a state, which no formula knows


class Switches:
    """The operations of a graph that switch with the time, and the numbers that meet the state.

    Attributes
    ----------
    slots, slots_of_times : list of range
        The slots of the parameters on which the switching times depend, and of those on which
        depends where the function may switch.  The others decide whether it does.
    differentiated : ndarray of int
        Slots of parameters by which derivatives are taken.
    held : dict of int to int
        The slots of components of the state that do not change.
    """

    def __init__(self, graph, timed, seen, switching, differentiated, held):
        self.graph = graph
        self.timed = timed
        self.seen = seen
        self.held = held
        self.differentiated = np.array(differentiated, int)
        self.nodes = [node for node in live(switching) if node.key in timed]
        self.slots = _slots(graph, live(seen))
        of_times = _slots(graph, live([a for node in switching for a in node.args]))
        for node in switching:
            ranges = ranges_of(node, graph.tables)
            if ranges and node.op != "table":  # whose entries decide
                of_times += ranges[: None if degree(node) > 1 else 1]
        self.slots_of_times = of_times
        self._lines = straight_lines(graph, timed, seen, weigh)

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
        found = self.candidates(values, t0, tf, count, varying, most)
        return decided(self, found, values, varying or {})

    def candidates(self, values, t0, tf, count=1, varying=None, most=None, grids=None):
        """The Candidates between t0 and tf; `grids` are known for these values."""
        lines = self._lines
        most = most or divisions.MOST
        if lines is None or (count > 1 and not lines.sure):
            return self._divided(values, t0, tf, count, varying or {}, most)
        first = max(min(t0, tf), -FAR)
        last = min(max(t0, tf), FAR)
        end = tf
        grids = grids or lines.grids(values, varying)
        while True:
            try:
                return lines.candidates(grids, first, last, end, count, most)
            except TooMany as reason:
                first, last, end = _part(reason, first, last, t0, tf)

    def grids(self, values):
        """What the Candidates of all spans have in common for values; None if they have nothing."""
        return None if self._lines is None else self._lines.grids(values)

    def values(self, numbers, y):
        """The values by slot of numbers, those of the parameters, and of the state's components."""
        if not self.held:
            return numbers
        values = np.zeros(1 + max(self.held.values()))
        values[: len(numbers)] = numbers
        for i, slot in self.held.items():
            values[slot] = y[i]
        return values

    def looked_at(self, values):
        """The parameters, and others with random numbers for those that are differentiated."""
        moved = self.differentiated
        if not len(moved):
            return [values]
        other = np.array(values, float)
        rng = np.random.default_rng(0)
        other[moved] += rng.uniform(1.0, 2.0, len(moved)) * (np.abs(other[moved]).max() or 1.0)
        return [values, other]

    def _divided(self, values, t0, tf, count, varying, most):
        first = max(min(t0, tf), -FAR)
        last = min(max(t0, tf), FAR)
        end = tf
        while True:
            try:
                span = first, last, count, most
                found = Divisions(self, values, varying, *span).found(end)
                if not found.partly:
                    return found
                return Divisions(self, values, varying, *span, sampled=False).found(end)
            except TooMany as reason:
                if count > 1:
                    return self._of_halves(values, t0, tf, count, varying, most)
                first, last, end = _part(reason, first, last, t0, tf)

    def _of_halves(self, values, t0, tf, count, varying, most):
        """The Candidates of many members, from those of two halves of them."""
        half = count // 2
        parts = [
            {slot: v[part] for slot, v in varying.items()}
            for part in (slice(half), slice(half, None))
        ]
        one = self._divided(values, t0, tf, half, parts[0], most)
        other = self._divided(values, t0, tf, count - half, parts[1], most)
        shorter = one if abs(one.end - t0) < abs(other.end - t0) else other
        ends = zip(one.at_ends, (other.at_ends[0] + half, other.at_ends[1]), strict=True)
        return Candidates(
            np.r_[one.member, other.member + half], np.r_[one.t, other.t],
            np.r_[one.weight, other.weight], tuple(map(np.concatenate, ends)),
            shorter.span, shorter.end, False, count, one.partly or other.partly,
        )  # fmt: skip


def _part(reason, first, last, t0, tf):
    """The first and the last time, and the end, of a part of a span with fewer times."""
    length = min(reason.length, 0.5 * (last - first))
    return (
        (last - length, last, last - length) if tf < t0 else (first, first + length, first + length)
    )


def _slots(graph, nodes):
    """The slots of the parameters among nodes."""
    found: set = set()
    for node in nodes:
        if node.op == "par":
            found.add(range(node.data, node.data + 1))
        found.update(ranges_of(node, graph.tables))
    return sorted(found, key=lambda slots: slots.start)


def switches(graph, outputs, differentiated=(), held=()):
    """The Switches of outputs; None if nothing in them switches with the time alone.

    Parameters
    ----------
    differentiated : sequence of int
        Slots of parameters.
    held : sequence of int
        Components of the state that do not change: they count as parameters, as far as the outputs
        depend on them.
    """
    read = {node.data: node for node in live(outputs) if node.op == "y"} if held else {}
    slots = {}
    replaced = {}
    for i in [i for i in held if i in read]:
        slots[i] = len(graph.values)
        graph.values.extend(0.0)
        replaced[read[i].key] = graph.make("par", (), slots[i])
    outputs = forced(graph, outputs, {}, replaced) if replaced else outputs
    timed = set()
    mixed = set()
    seen = {node.key: node for node in outputs}
    nodes = live(outputs)
    for node in nodes:
        if node.op in OF_STATE or any(a.key in mixed for a in node.args):
            mixed.add(node.key)
            seen |= {a.key: a for a in node.args}
        elif node.op == "t" or any(a.key in timed for a in node.args):
            timed.add(node.key)
    seen = [node for node in seen.values() if node.key in timed]
    switching = [node for node in live(seen) if node.key in timed and may_switch(node)]
    if not switching:
        return None
    return Switches(graph, timed, seen, switching, differentiated, slots)


def held_components(graph, outputs):
    """The components of the state whose derivatives, the outputs, are zero where they are finite.

    ``0 * y`` and ``y - y`` are NaN where y is not finite, and then the solve ends.
    """
    new = {}
    nodes = live(outputs)
    for node in nodes if any(_vanishes(node, node.args) for node in nodes) else ():
        args = [new[a.key] for a in node.args]
        if _vanishes(node, args):
            new[node.key] = graph.const(0.0)
        elif all(a is b for a, b in zip(args, node.args, strict=True)):
            new[node.key] = node
        else:
            new[node.key] = graph.call(node.op, *args, data=node.data)
    return tuple([i for i, node in enumerate(outputs) if is_zero(new.get(node.key, node))])


def _vanishes(node, args):
    """Whether an operation on these operands is zero where they are finite."""
    if node.op == "sub":
        return args[0] is args[1]
    if node.op == "mul":
        return is_zero(args[0]) or is_zero(args[1])
    return node.op == "div" and is_zero(args[0])
