"""The places of the coefficients of vectors in the workspace."""

from ..recurrences.deceptive import held
from ..recurrences.listing import Gather
from ..recurrences.operations import Integral, Power, Quotient, Root, Sum
from ..text.instructions import hexadecimal
from .convolutions import convolutions

KEPT = {Quotient: 3, Power: 2, Root: 2}  # numbers of values that order 0 keeps for the other orders


def n_kept(step):
    """The number of vectors that a step keeps from order 0."""
    if isinstance(step, Sum):
        return sum(1 if a is b else 2 for _, a, b in step.products)
    return len(step.parts) if isinstance(step, Integral) else KEPT.get(type(step), 0)


class Places:
    """The workspace of rows.

    Parameters
    ----------
    plan : Bundles or Single
    order, lanes : int
    together : int
        The most sums in one loop, limited by the number of registers.

    Attributes
    ----------
    at : dict of int
        Places of order 0: of nodes, by key; of invariants, by ("factor", key); of values that steps
        keep, by ("kept", key).
    history : set
        The keys of nodes with a place for each order; other nodes store the current order only.
    size : int
    """

    def __init__(self, plan, order, lanes, together):
        self.together, self.timed = together, set(plan.timed)
        self._lanes = lanes
        self.at = {}
        self.size = 0
        for f in plan.factors:
            self.room(("factor", f.key), 1)
        self.history = self._history(plan)
        for step in plan.steps:
            if n_kept(step):
                self.room(("kept", step.node.key), n_kept(step))
        leaves = plan.states if plan.time is None else [plan.time, *plan.states]
        for node in [*leaves, *[step.node for step in plan.steps]]:
            self.room(node.key, order + 1 if node.key in self.history else 1)

    def room(self, key, vectors):
        """Reserve memory for a key, unless it has a place; return the place."""
        if key not in self.at:
            self.at[key] = self.size
            self.size += vectors * self._lanes
        return self.at[key]

    def _history(self, plan):
        found = {node.key for node in plan.states}
        if plan.time is not None:
            found.add(plan.time.key)
        for step in plan.steps:
            for c in convolutions(step, self.timed):
                found |= {c.a.key, c.b.key}
            found |= {hold.node.key for hold in [held(step)] if hold is not None}
            if step.node.key in self.timed:
                found |= {step.parts[0][1].key, step.parts[0][2].key}
        return _together(found, plan)

    def constant(self, f):
        """The value of a constant node; None for other nodes."""
        return hexadecimal(f.data) if f.op == "const" else None


def _together(found, plan):
    """Extend a set of keys by the keys of vectors that are gathered together with them."""
    gathers = [{node.key for node, _ in s.lanes} for s in plan.steps if isinstance(s, Gather)]
    before = 0
    while len(found) > before:
        before = len(found)
        for sources in gathers:
            if not found.isdisjoint(sources):
                found = found | sources
    return found
