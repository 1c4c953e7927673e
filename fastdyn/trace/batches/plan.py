"""Turns batches into loops: which batches are kept in memory, and in which order loops run.

The plan goes from the results to the operands.  If a batch is read at places that are affine in
the loop indices, the batch reads its operands at affine places, too.  Therefore loops fuse, shifts
become offsets of reads, and common subexpressions are shared, without a search.
"""

from typing import Any, NamedTuple

import numpy as np

from ...operations import OPERATIONS
from ..graph.expressions import live
from .pieces import Edges, Irregular, lengths, place_of, row_major
from .table import LEAVES, PRODUCTS, REDUCTIONS

COSTLY = 16  # a batch of this cost or more, with several users, is kept in memory
MOST_USES = 8
DEEP = 10**6


class Root(NamedTuple):
    """The store of a loop: ``target[offset + steps . k] = batch at start + strides . k``.

    `target` is "out" or the number of a batch.  `domain` is the shape of the loop.  `cuts` are the
    indices along each axis of `domain` at which the formula changes.  A root runs after all roots
    of a lower `level`.
    """

    level: int
    domain: tuple
    batch: Any
    start: int
    strides: tuple
    target: Any
    offset: int
    steps: tuple
    reduction: str
    cuts: tuple


class Plan(Edges):
    """The loops of a trace.

    Parameters
    ----------
    table : Table
    result : array of int
        Node numbers that are stored in order.
    nodes : iterable of Node
        Nodes of the graph that are evaluated after all loops.
    """

    def __init__(self, table, result, nodes):
        super().__init__(table, result, table.items_of(*nodes))
        selects = [b for b in table.batches if b.op == "select" and b.number in self.live]
        self.decisions = {b.number: i for i, b in enumerate(selects)}
        self._choose(self._read_one_by_one(nodes))
        self._make_roots()

    def _choose(self, fixed):
        """Choose the batches to keep in memory.

        These are the batches `fixed`, reductions, products and their first operands, copies,
        batches that are read through a table of places, and costly batches of numbers with several
        uses.
        """
        table, cost, uses = self.table, {}, {}
        for b in table.batches:
            if b.number in self.live:
                below = self._below(b)
                cost[b.number] = 0 if b.op in LEAVES else min(
                    DEEP, OPERATIONS[b.op].cost + max((cost[i] for i in below), default=0)
                    + sum(min(cost[i], 20) for i in below) // 2,
                )  # fmt: skip
        fixed |= {source.number for source, _ in self.places.values()}
        fixed |= {b.operands[0] for b in table.batches if b.op in PRODUCTS}
        for piece in self.out_pieces:
            uses.setdefault(piece.batch.number, set()).add("out")
        self.kept: dict = {}
        for b in reversed(table.batches):
            if b.number not in self.live or b.op in LEAVES:
                continue
            mine = uses.get(b.number, set())
            keep = b.op in REDUCTIONS | PRODUCTS or b.op == "copy" or b.number in fixed
            if keep or (len(mine) > 1 and cost[b.number] >= COSTLY and not b.truth):
                self.kept[b.number] = b
                whole = b.op in REDUCTIONS
                mine = {("reduced", self.shape_of(b)) if whole else b.number}
            for j, operand in enumerate(b.operands):
                for piece in self.edges[b.number, j]:
                    shift = piece.start - piece.batch.first, piece.strides
                    places = uses.setdefault(piece.batch.number, set())
                    if len(places) < MOST_USES:
                        places |= mine if isinstance(operand, int) else {(m, shift) for m in mine}

    def _with_ones(self, nodes):
        """`nodes`, and the single nodes that loops use."""
        return [
            *nodes,
            *(b.data for b in self.table.batches if b.op == "one" and b.number in self.live),
        ]

    def single_decisions(self, nodes):
        """The conditions of the selects in `nodes` and in the single nodes that loops use."""
        found = [node.args[0] for node in live(self._with_ones(nodes)) if node.op == "select"]
        return list({condition.key: condition for condition in found}.values())

    def _read_one_by_one(self, nodes):
        """The numbers of the batches of which single nodes read MOST_USES elements or more."""
        items = self.table.items_of(*self._with_ones(nodes))
        numbers, times = np.unique(
            [self.table.batch_of(i).number for i in items], return_counts=True
        )
        return set(numbers[times >= MOST_USES])

    def _below(self, b):
        return {p.batch.number for j in range(len(b.operands)) for p in self.edges[b.number, j]}

    # -- the loops

    def _make_roots(self):
        roots, self.level = [], {}
        for number in sorted(self.kept):
            b = self.kept[number]
            shape, steps = self.shape_of(b), None
            if b.op in PRODUCTS:
                shape = ()
            elif b.op in REDUCTIONS:
                steps = (*row_major(b.shape), 0) if b.shape else (0,) * len(shape)
                if len(steps) != len(shape):
                    raise Irregular(np.arange(0))
            whole = row_major(shape)
            reduction = b.op if b.op in REDUCTIONS | PRODUCTS else ""
            root = self._root(
                shape, b, b.first, whole, number, 0, whole if steps is None else steps, reduction
            )
            if b.op in PRODUCTS:
                root = root._replace(level=self.level.get(b.operands[0], -1) + 1)
            self.level[number] = root.level
            roots.append(root)
        across = row_major(self.out_shape)
        for piece in self.out_pieces:
            roots.append(self._of_output(piece, across))
        groups: dict = {}
        for root in roots:
            groups.setdefault((root.level, root.domain), []).append(root)
        self.groups = [groups[key] for key in sorted(groups)]

    def _of_output(self, piece, across):
        shape, strides, steps, b = piece.shape, piece.strides, across, piece.batch
        own = () if b.op in LEAVES | PRODUCTS | REDUCTIONS else self.shape_of(b)
        if len(shape) == 1 and strides == (1,) and b.size == shape[0] > 1 and len(own) > 1:
            shape, strides, steps = own, row_major(own), row_major(own)
        if len(shape) == 2 and 1 in shape:
            axis = int(shape[0] == 1)
            shape, strides, steps = (shape[axis],), (strides[axis],), (steps[axis],)
        offset = place_of(piece.lo, across)
        return self._root(shape, b, piece.start, strides, "out", offset, steps, "")

    def _root(self, shape, batch, start, strides, target, offset, steps, reduction):
        for _ in range(3):
            lines: list = [{0, n} for n in shape]
            level = [0]
            self._known: set = set()
            try:
                if reduction not in PRODUCTS:
                    self._pull(
                        batch, start, strides, shape, (0,) * len(shape), lines, level, target, shape
                    )
                cuts = tuple(sorted(line) for line in lines)
                return Root(
                    level[0], shape, batch, start, strides, target, offset, steps, reduction, cuts
                )
            except Irregular as error:
                length = next(iter(lengths(error.args[0], shape[0] if shape else 0)), None)
                if len(shape) != 1 or length is None:
                    raise
                shape = (shape[0] // length, length)
                strides = strides[0] * length, strides[0]
                steps = steps[0] * length, steps[0]
        raise Irregular(np.arange(0))

    def _pull(self, b, start, strides, shape, lo, lines, level, target, domain):
        """Collect the cuts and the level of a batch that is read at ``start + strides . k``."""
        key = b.number, start, strides, shape, lo
        if key in self._known:
            return
        self._known.add(key)
        if b.op == "one":
            for i in self.table.items_of(b.data):
                self._pull_item(i, level)
            return
        if b.number in self.kept and b.number != target:
            fused = shape == domain == self.shape_of(b) and start == b.first
            fused = fused and strides == row_major(shape) and b.op not in REDUCTIONS | PRODUCTS
            level[0] = max(level[0], self.level[b.number] + (not fused))
            return
        at = start - b.first
        for j, operand in enumerate(b.operands):
            if (b.number, j) in self.places:
                source = self.places[b.number, j][0]
                level[0] = max(level[0], self.level.get(source.number, -1) + 1)
                continue
            for piece in self.read(b, j, operand, at, strides, shape):
                here = tuple(x + y for x, y in zip(lo, piece.lo, strict=True))
                for line, a, n in zip(lines, here, piece.shape, strict=True):
                    line |= {a, a + n}
                self._pull(
                    piece.batch, piece.start, piece.strides, piece.shape, here,
                    lines, level, target, domain,
                )  # fmt: skip

    def _pull_item(self, i, level):
        """Raise `level` above the levels of the loops that node number i depends on."""
        batch, own = self.table.batch_of(i), [0]
        if batch.number in self.kept:
            level[0] = max(level[0], self.level[batch.number] + 1)
            return
        self._pull(batch, i, (), (), (), [], own, None, ())
        level[0] = max(level[0], own[0])
