"""Loops over like vectors: each iteration reads the places of its operands from a table."""

from collections import defaultdict
from typing import Any, NamedTuple

import numpy as np

from ..recurrences.listing import Gather, nodes, rebuilt, shape
from ..recurrences.plan import sums_of_terms
from .convolutions import convolutions, n_partial
from .places import n_kept

MANY = 40  # sums of products; straight-line code of more sums compiles slowly
FEWEST, FEWEST_OF_MANY = 32, 4  # fewest vectors in a loop: below MANY sums, above


class Part(NamedTuple):
    """Steps as straight-line code; with a `table`, like steps as one loop.

    `slots` are the keys of operands.  An iteration reads their places from its row of `table`.
    """

    steps: list
    slots: Any = None
    table: Any = None
    name: str = ""


class Slot:
    """An operand of a loop, in place of a node; the table has its place for each iteration."""

    op = "slot"
    data = None

    def __init__(self, key, is_factor):
        self.key = key
        self.is_factor = is_factor


def looped(plan, places, steps, name):
    """Group steps into Parts, in the order of their levels."""
    parts = []
    level = plan.level
    n_sums = sum(len(convolutions(step, places.timed)) for step in plan.steps)
    n_sums += sums_of_terms(plan.steps)
    fewest = FEWEST if n_sums <= MANY else FEWEST_OF_MANY
    for _, group in _by(steps, lambda step: level[step.node.key]):
        straight = []
        for _, like in _by(group, lambda step: _label(places, step)):
            if len(like) >= fewest:
                parts.append(_Loop(plan, places, like, f"{name}{len(parts)}").part())
            else:
                straight += like
        if straight:
            parts.append(Part(straight))
    return parts


def _by(steps, label):
    groups = defaultdict(list)
    for step in steps:
        groups[label(step)].append(step)
    return list(groups.items())


def _label(places, step):
    """A key that is equal for steps of one loop."""
    if isinstance(step, Gather):
        sources = any(bundle.key in places.history for bundle, _ in step.lanes)
        return "gather", step.node.key in places.history, sources
    given = [places.constant(x) if x.is_factor else x.key in places.history for x in nodes(step)]
    timed = step.node.key in places.timed
    return shape(step, lambda x: x.is_factor), step.node.key in places.history, timed, tuple(given)


class _Loop:
    """Collects the table of a loop: a column of places for each slot."""

    def __init__(self, plan, places, like, name):
        self.plan = plan
        self.places = places
        self.like = like
        self.name = name
        self.keys = []
        self.columns = []
        self.nodes = {}

    def part(self):
        first = self.like[0]
        places = self.places
        node = self._node([step.node for step in self.like])
        if isinstance(first, Gather):
            step = Gather(node, [(self._lane(i), 0) for i in range(len(first.lanes))])
        else:
            lists = zip(*map(nodes, self.like), strict=True)
            step = rebuilt(first, node, [self._given(each) for each in lists])
        for label, count in (("kept", n_kept(first)), ("partial", n_partial(first, places.timed))):
            if count:
                self._own(label, count, node)
        table = np.array(self.columns, np.int32).T
        return Part([step], self.keys, table, self.name)

    def _slot(self, column, label=None, is_factor=False):
        new = Slot((self.name, len(self.columns)), is_factor)
        self.keys.append(new.key if label is None else (label, new.key))
        self.columns.append(column)
        return new

    def _node(self, nodes):
        places = self.places
        key = nodes[0].key
        keys = tuple([node.key for node in nodes])
        if keys in self.nodes:
            return self.nodes[keys]
        new = self.nodes[keys] = self._slot([places.at[x.key] for x in nodes])
        for having in (places.history, places.timed):
            if key in having:
                having.add(new.key)
        self.plan.level[new.key] = self.plan.level[key]
        return new

    def _given(self, nodes):
        """The operand of a loop's formula: a slot, or a constant."""
        if not nodes[0].is_factor:
            return self._node(nodes)
        if self.places.constant(nodes[0]) is not None:
            return nodes[0]
        column = [self.places.at["factor", f.key] for f in nodes]
        return self._slot(column, "factor", True)

    def _lane(self, i):
        """The slot from which gathered vectors take lane i."""
        sources = [step.lanes[i] for step in self.like]
        new = self._slot([self.places.at[node.key] + lane for node, lane in sources])
        if sources[0][0].key in self.places.history:
            self.places.history.add(new.key)
        return new

    def _own(self, label, count, node):
        """Add the places of values of an iteration's own node to the table."""
        places = [self.places.room((label, step.node.key), count) for step in self.like]
        self.keys.append((label, node.key))
        self.columns.append(places)
