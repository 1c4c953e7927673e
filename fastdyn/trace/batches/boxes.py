"""The formula of a box: the values and stores of a rectangular part of a loop.

Within a box, every operand is affine in the loop indices.  One formula then holds for all points of
the box.
"""

from itertools import pairwise, product
from typing import Any, NamedTuple

import numpy as np

from .pieces import place_of
from .table import IN_MEMORY

SMALL = 16  # a box is an edge if the whole loop has more than SMALL times as many points
FEWEST = 3  # edges with equal operations become one loop if there are at least so many
MOST_BOXES = 200


class Value(NamedTuple):
    """One value of a formula.

    `kind` is "read" (`data`: array, place, strides), "gather" (array, places, place, strides),
    "one" (a node of the graph) or "op" (operation and its data).  `args` are the indices of the
    operands.  `strides` are the value's strides along the axes of the box; a value with stride 0
    is constant along the axis.
    """

    kind: str
    data: Any
    args: tuple
    strides: tuple


class Store(NamedTuple):
    """``target[place + steps . k] = value``, or a reduction of the target and the value."""

    target: Any
    place: int
    steps: tuple
    value: int
    reduction: str


class Formula:
    """The values and stores of a group of roots over a box.

    Parameters
    ----------
    plan : Plan
    group : list of Root
    lo, shape : tuple of int
        The first point of the box, and the lengths of its axes.
    """

    def __init__(self, plan, group, lo, shape):
        self.plan, self.shape = plan, shape
        self.values: list[Value] = []
        self.stores: list[Store] = []
        self._places: dict = {}
        self._target: Any = None
        for root in group:
            self._target = root.target
            start = root.start + place_of(lo, root.strides)
            place = root.offset + place_of(lo, root.steps)
            b = root.batch
            if root.reduction:
                value = self._operand(b, 0, start - b.first, root.strides)
            else:
                value = self.value(b, start, root.strides)
            steps = self._along(root.steps)
            self.stores.append(Store(root.target, place, steps, value, root.reduction))

    def _along(self, strides):
        return tuple(s if n > 1 else 0 for s, n in zip(strides, self.shape, strict=True))

    def value(self, b, start, strides):
        """The index, in `values`, of the Value of b that is read at ``start + strides . k``."""
        strides = self._along(strides)
        key = b.number, start, strides
        if key not in self._places:
            made = self._made(b, start, strides)
            self.values.append(made)
            self._places[key] = len(self.values) - 1
        return self._places[key]

    def _made(self, b, start, strides):
        at = start - b.first
        if b.op == "one":
            return Value("one", b.data, (), (0,) * len(strides))
        kept = b.number in self.plan.kept and b.number != self._target
        if kept or b.op in IN_MEMORY:
            return Value("read", (name_of(b), at, strides), (), strides)
        args = tuple(self._operand(b, j, at, strides) for j in range(len(b.operands)))
        data = self.plan.decisions.get(b.number, b.data)
        return Value("op", (b.op, data), args, strides)

    def _operand(self, b, j, at, strides):
        plan, operand = self.plan, b.operands[j]
        if isinstance(operand, int):
            other = plan.table.batches[operand]
            return self.value(other, other.first + at, strides)
        if operand.ndim == 0:
            i = int(operand)
            return self.value(plan.table.batch_of(i), i, (0,) * len(strides))
        if (b.number, j) in plan.places:
            source, places = plan.places[b.number, j]
            self.values.append(Value("gather", (source, places, at, strides), (), strides))
            return len(self.values) - 1
        start = int(operand[at])
        moves = tuple(
            int(operand[at + s]) - start if n > 1 else 0
            for s, n in zip(strides, self.shape, strict=True)
        )
        return self.value(plan.table.batch_of(start), start, moves)

    def merge_axes(self):
        """The axes of the loops, outermost first, and their lengths.

        Two axes merge if all reads and stores traverse them as one axis.  Of the remaining axes,
        the axis with the most unit strides becomes the innermost loop.
        """
        shape, axes = list(self.shape), [i for i, n in enumerate(self.shape) if n > 1]
        strides = [v.data[-1] for v in self.values if v.kind in ("read", "gather")]
        strides += [s.steps for s in self.stores]
        for outer, inner in reversed(list(pairwise(axes))):
            if all(s[outer] == s[inner] * shape[inner] for s in strides):
                shape[inner], shape[outer] = shape[inner] * shape[outer], 1
                axes.remove(outer)
        if len(axes) > 1:

            def neighbours(axis):
                near = sum(s[axis] == 1 for s in strides) - sum(s[axis] > 1 for s in strides)
                return near if shape[axis] >= SMALL else -len(strides) - 1

            best = max(axes, key=lambda axis: (neighbours(axis), axis))
            axes.remove(best)
            axes.append(best)
        return axes, shape

    def signature(self):
        """The formula without its places: boxes with equal signatures share their code.

        A formula with a "gather" has the signature None.
        """
        values = []
        for v in self.values:
            if v.kind == "read":
                values.append(("read", v.data[0]))
            elif v.kind == "gather":
                return None
            elif v.kind == "op" and v.data[0] == "select":  # without the decision's number
                values.append((v.kind, "select", v.args))
            else:
                values.append((v.kind, v.data, v.args))
        return tuple(values), tuple((s.target, s.value, s.reduction) for s in self.stores)

    def grid(self):
        """The places of all reads and stores, one row for each point of the box."""
        places = [(v.data[1], v.data[2]) for v in self.values if v.kind == "read"]
        places += [(s.place, s.steps) for s in self.stores]
        return np.column_stack([grid_of(at, strides, self.shape) for at, strides in places])


def name_of(batch):
    """The name of the array that holds a batch: state, parameters, block, or a batch's number."""
    if batch.op in ("y", "block"):
        return batch.op
    return ("par", batch.data) if batch.op == "par" else batch.number


def formula_of_one(plan, batch, i):
    """The Formula of one node of a batch."""
    formula = Formula(plan, [], (), ())
    formula.value(batch, i, ())
    return formula


def grid_of(at, strides, shape):
    """The places ``at + strides . k`` for all k < shape, in row-major order."""
    places = np.array(at)
    for stride, n in zip(strides, shape, strict=True):
        places = places[..., None] + stride * np.arange(n)
    return places.ravel()


def boxes_of(plan, group):
    """The formulas of a group's boxes, and lists of formulas with equal signatures.

    Each list holds the formulas of edges, which are small boxes.  The edges of one list become one
    loop over a table of places.
    """
    lines = [sorted(set().union(*c)) for c in zip(*[r.cuts for r in group], strict=True)]
    spans = [list(pairwise(line)) for line in lines]
    whole = int(np.prod(group[0].domain, dtype=np.int64))
    alone, alike = [], {}
    reduced = any(root.reduction for root in group)
    places = list(product(*spans))
    for span in places:
        lo, shape = tuple(a for a, _ in span), tuple(b - a for a, b in span)
        formula = Formula(plan, group, lo, shape)
        edge = int(np.prod(shape, dtype=np.int64)) * SMALL < whole and not reduced
        key = formula.signature() if edge and len(places) > 4 else None
        if key is None:
            alone.append(formula)
        else:
            alike.setdefault(key, []).append(formula)
    for key in [key for key, found in alike.items() if len(found) < FEWEST]:
        alone += alike.pop(key)
    return alone, list(alike.values())
