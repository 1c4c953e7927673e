"""Groups of recurrences with equal formulas, and their order in vectors.

Two steps are alike if they have equal formulas and levels.  Like steps go into the lanes of
vectors.  The operands at one place of like formulas, for example the first coordinates of all
distances, form a group in the order of the formulas, so that a vector of formulas has vectors as
operands.
"""

from collections import defaultdict

from .listing import items, shape
from .operations import Integral, Sum

ROUNDS = 3  # rounds of refining the groups by operands and by uses
WASTE = 1.5  # factor by which finer groups may increase the number of vectors


class Likeness:
    """Colours of a plan's steps, by colour refinement: like steps have equal colours."""

    def __init__(self, plan):
        self.plan = plan
        invariant = plan.rewrite.is_invariant
        self.coarse = {
            step.node.key: (plan.level[step.node.key], self._timed(step), shape(step, invariant))
            for step in plan.steps
        }
        self.strong = {step.node.key: list(self._strong(step)) for step in plan.steps}
        self.colour = _numbered(self.coarse)
        for _ in range(ROUNDS):
            self._refine()

    def _timed(self, step):
        degree = self.plan.degree
        return isinstance(step, Integral) and tuple([degree.get(a.key) for _, a, _ in step.parts])

    def _strong(self, step):
        """The operands of a step except the terms of sums."""
        if isinstance(step, Sum):
            return [x for _, a, b in step.products for x in (a, b)]
        invariant = self.plan.rewrite.is_invariant
        return [a for is_factor, a in items(step, invariant) if not is_factor]

    def _refine(self):
        users = defaultdict(set)
        colour = self.colour
        for key, operands in self.strong.items():
            for slot, a in enumerate(operands):
                users[a.key].add((colour[key], slot))
        labels = {}
        for key, operands in self.strong.items():
            needs = tuple([colour.get(a.key, -1) for a in operands])
            labels[key] = colour[key], needs, tuple(sorted(users[key]))
        self.colour = _numbered(labels)

    def positions(self, order):
        """The position of each step within its colour, given the order of the states."""
        found = {}
        for place, i in enumerate(order):
            core = self.plan.outputs[i][1]
            if core is not None:
                found.setdefault(core.key, place)
        for step in reversed(self.plan.steps):
            own = found.setdefault(step.node.key, step.node.key)
            for a in self.strong[step.node.key]:
                found[a.key] = min(found.get(a.key, own), own)
        return found

    def states(self, lanes):
        """The indices of the states of each vector: states with like derivatives are together."""
        groups = defaultdict(list)
        for i, (_, core) in enumerate(self.plan.outputs):
            if core is None:
                groups[None].append((i, i))
            elif core.op == "y":  # in the order of the states that are the derivatives
                groups["y"].append((core.data, i))
            else:
                groups[self.colour.get(core.key, core.op)].append((i, i))
        return chunks([[i for _, i in sorted(group)] for group in groups.values()], lanes)


def alike(plan, lanes):
    """(states, steps): the vectors as lists of state numbers, and as lists of like steps."""
    like = Likeness(plan)
    states = like.states(lanes)
    place = like.positions([i for chunk in states for i in chunk])
    coarse = defaultdict(lambda: defaultdict(list))
    for step in plan.steps:
        key = step.node.key
        coarse[like.coarse[key]][like.colour[key]].append(step)
    found = []
    for groups in coarse.values():
        for group in groups.values():
            group.sort(key=lambda step: place[step.node.key])
        found += chunks(list(groups.values()), lanes)
    return states, found


def chunks(groups, lanes):
    """Cut groups into vectors, each group by itself unless that gives too many vectors."""
    whole = [x for group in groups for x in group]
    apart = [group[i : i + lanes] for group in groups for i in range(0, len(group), lanes)]
    if len(apart) <= WASTE * -(-len(whole) // lanes):
        return apart
    return [whole[i : i + lanes] for i in range(0, len(whole), lanes)]


def _numbered(labels):
    numbers = {}
    return {key: numbers.setdefault(label, len(numbers)) for key, label in labels.items()}
