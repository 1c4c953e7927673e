"""The loops of a program: which rows are kept in memory, and in which order the loops run."""

import math
from collections import defaultdict
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ..graph.clock import look
from ..graph.expressions import live
from ..graph.refusal import Refusal
from ..operations import OPERATIONS
from .memory import WIDTH
from .program import cost_of
from .pull import Box, Cut, Fold, Kept, Root, Scattered, Store, Value, affine, row_major, view

REDUCTIONS = frozenset(("sum", "top", "low"))
ALONE = frozenset(("pack", "csr", "running"))  # rows with code of their own
LEAVES = frozenset(("y", "par", "block", "const"))
COSTLY = 16  # a row of this cost or more, with several users, is kept in memory
MOST_USES = 8
DEEP = 10**6
SMALL = 16  # an edge has fewer points, or less than this part of the points of the whole loop
# Costs of loops, in additions: of a call, and of a number that is read by its place in a table.
# Eight numbers in two registers take the time of one; by a formula, BY_FORMULA times the time of a
# call of the C library for one.  In registers of two numbers they take twice as long.
CALLED = 36
GATHERED = 8
BY_FORMULA = 4
FEWEST = 3  # edges with equal operations become one loop if there are at least so many
MOST_BOXES = 2000
MOST_CODES = 200


def _cost_of_box(box, width):
    *outer, inner = box.shape or (1,)
    wide = inner >= WIDTH
    found = len(box.stores)
    times = -(-inner // WIDTH) * (WIDTH // width) if wide else inner
    for value in box.values:
        if value.kind == "op":
            record = OPERATIONS[value.data[0]]
            found += record.cost * (BY_FORMULA if wide and record.elementary else 1)
        elif value.kind in ("read", "gather"):
            found += GATHERED if value.kind == "gather" else 1
    return math.prod(outer) * times * found


class Loop(NamedTuple):
    """Boxes of one domain that run together, or a row with code of its own.

    `alike` are lists of boxes with equal signatures: each becomes a loop over a table of places.
    """

    level: int
    domain: tuple
    roots: list
    alone: list
    alike: list
    row: Any = None


class Piece:
    """A box of results whose ids are affine."""

    def __init__(self, plan, roots, shape):
        (root,) = roots
        outputs = plan.program.outputs
        self.found = plan.affine(outputs, root.start, root.strides, shape)
        if self.found is None:
            raise Scattered(None, outputs)
        self.place = root.place
        self.steps = root.steps
        self.shape = shape


class LoopPlan:
    """The loops of a program.

    Attributes
    ----------
    decisions : dict
        The numbers of the rows that select, by their first ids.
    kept : dict
        The rows that are kept in memory, by their first ids.
    loops : list of Loop
    single : list of (place, id)
        The results that are stored one by one, after all loops.
    """

    def __init__(self, program):
        self.program = program
        self._affine: dict = {}
        self._arrays: dict = {}
        forced: set = set()
        while True:
            self._find()
            self._choose(forced)
            try:
                self._make_loops()
            except Kept as error:
                forced.add(error.args[0])
            except Scattered as error:
                program.gather(*error.args)
            else:
                break

    def _find(self):
        """Number the decisions, and note the rows that single nodes read number by number."""
        program = self.program
        selects = [row.first for row in program.order if row.op == "select"]
        self.decisions = {first: i for i, first in enumerate(selects)}
        conditions = {n.args[0].key: n.args[0] for n in program.nodes if n.op == "select"}
        self.single_decisions = list(conditions.values())
        items = [program.row_at(n.data).first for n in program.nodes if n.op == "item"]
        firsts, times = np.unique(items, return_counts=True)
        self._read_singly = set(firsts[times >= MOST_USES].tolist())
        self.elements: dict = {}
        self._levels: dict = {}  # of elements

    def array(self, row):
        """The name of the array in which a row lies; None if the row is not in memory.

        The name is "y", "block", ("par", slots), ("const", first id), or the first id of a row.
        """
        if row.op in ("y", "block"):
            return row.op
        if row.op == "const" and row.first < self.program.g.next:
            if row.first not in self._arrays:
                content = np.ascontiguousarray(row.data, float)
                self._arrays[row.first] = "par", self.program.g.reads.held(content)
            return self._arrays[row.first]
        if row.op in ("par", "const"):
            return row.op, row.data if row.op == "par" else row.first
        return row.first if row.first in self.kept else None

    # -- rows in memory

    def _choose(self, forced):
        """Choose the rows to keep: those with loops of their own, costly ones with many uses."""
        program = self.program
        cost = {}
        uses = defaultdict(set)
        below = program.below
        for row in program.order:
            costs = [cost.get(r.first, 0) for r in below[row.first] if hasattr(r, "first")]
            cost[row.first] = 0 if row.op in LEAVES else min(
                DEEP, OPERATIONS[row.op].cost + max(costs, default=0)
                + sum(min(c, 20) for c in costs) // 2,
            )  # fmt: skip
        self.kept: dict = {}
        for row in program.parts(program.outputs)[0]:
            uses[row.first].add("out")
        for row in reversed(program.order):
            if row.op in LEAVES:
                continue
            mine = uses[row.first]
            keep = (
                row.op in REDUCTIONS | ALONE | {"copy", "dense"}
                or row.first in forced | self._read_singly
            )
            if keep or (len(mine) > 1 and cost[row.first] >= COSTLY and not row.truth):
                self.kept[row.first] = row
                mine = {("reduced", self.domain(row)) if row.op in REDUCTIONS else row.first}
            for a in row.args:
                if not isinstance(a, np.ndarray):
                    continue
                for source in program.parts(a)[0]:
                    whole = a.size == source.size and a[0] == source.first
                    places = uses[source.first]
                    if len(places) < MOST_USES:
                        places |= mine if whole else {(m, int(a[0]), a.size) for m in mine}

    def domain(self, row):
        """The shape of the loop of a row."""
        return (*row.shape, row.data) if row.op in REDUCTIONS else row.shape

    # -- loops

    def _make_loops(self):
        program = self.program
        found = []
        self.level: dict = {}
        for row in program.order:
            if row.first not in self.kept:
                continue
            look()
            if row.op in ALONE:
                nodes = [program.node(i) for i in row.args[0].tolist()] if row.op == "pack" else []
                source = self._before(row) if row.op != "pack" else self._level_of_nodes(nodes)
                loop = Loop(source, (), [], [], [], row)
            elif row.op == "dense":
                loop = self._dense(row)
            else:
                domain = self.domain(row)
                order = row_major(domain)
                steps = (*row_major(row.shape), 0) if row.op in REDUCTIONS else order
                reduction = row.op if row.op in REDUCTIONS else ""
                loop = self._loop(
                    domain, Root(row.first, row.first, order, 0, steps, reduction, 0, order)
                )
            self.level[row.first] = loop.level
            found.append(loop)
        self.single = []
        found += self._results()
        groups = defaultdict(list)
        for loop in found:
            apart = id(loop) if loop.row is not None or not loop.roots else 0
            groups[loop.level, loop.domain, apart].append(loop)
        self.loops = [self._joined(groups[key]) for key in sorted(groups)]
        self.end_level = self._level_of_nodes([program.raising])

    def _before(self, row):
        """The level after the row that a product reads."""
        source = self.array(self.program.row_at(int(row.args[0][0])))
        return self.level.get(source, -1) + 1

    def _dense(self, row):
        """The loop of a matrix times a vector: each result is a sum along a row."""
        _, rows, columns, first, at, *steps = row.data
        program = self.program
        ids = row.args[0]
        matrix = program.row_at(first)
        x = program.row_at(int(ids[0]))
        box = Box(self, [], (rows, columns))
        box.values = [
            Value("read", (self.array(matrix), at, False), (), tuple(steps)),
            Value("read", (self.array(x), int(ids[0]) - x.first, False), (), (0, 1)),
            Value("op", ("mul", None), (0, 1), (1, 1)),
        ]
        box.stores = [Store(row.first, 0, (1, 0), 2, "sum")]
        return Loop(self._before(row), (rows, columns), [], [box], [])

    def _loop(self, domain, root):
        boxes = self._boxes([root], domain)
        return Loop(self._level_of(boxes, domain), domain, [root], boxes, [])

    def _boxes(self, roots, shape, kind: Any = Box):
        """The boxes of roots over a domain, in which all operands are affine."""
        todo = [(roots, shape)]
        found = []
        while todo:
            if len(todo) + len(found) > MOST_BOXES:
                raise Refusal("its arrays have too many edges", said=False)
            roots, shape = todo.pop()
            try:
                found.append(kind(self, roots, shape))
            except Cut as cut:
                axis, cuts = cut.args
                for a, b in [*pairwise([0, *cuts, shape[axis]])][::-1]:
                    part = (*shape[:axis], b - a, *shape[axis + 1 :])
                    todo.append(([root.part(axis, a) for root in roots], part))
            except Fold as fold:
                axis, length = fold.args
                part = (*shape[:axis], shape[axis] // length, length, *shape[axis + 1 :])
                todo.append(([root.folded(axis, length) for root in roots], part))
        return found

    def affine(self, flat, at, strides, shape):
        """As of `affine` of `pull`, for ``flat[at + strides . k]``; each question is asked once."""
        place = id(flat), at, strides, shape
        if place not in self._affine:
            try:
                found = affine(self.program, view(flat, at, strides, shape))
            except (Cut, Fold) as error:
                found = error
            self._affine[place] = flat, found
        found = self._affine[place][1]
        if isinstance(found, Exception):
            raise found.with_traceback(None)
        return found

    # -- the order of loops

    def _level_of(self, boxes, domain):
        """A level above those of the loops that boxes of one root read."""
        level = 0
        for box in boxes:
            root = box.roots[0]
            here = root.at, box._along(root.order)
            for v in box.values:
                if v.kind == "one":
                    level = max(level, self._level_of_nodes([v.data]))
                elif v.kind in ("read", "gather") and v.data[0] in self.level:
                    source = self.kept[v.data[0]]
                    fused = v.kind == "read" and here == (v.data[1], v.strides)
                    fused = fused and source.op not in REDUCTIONS | ALONE | {"dense"}
                    fused = fused and source.shape == domain
                    level = max(level, self.level[source.first] + (not fused))
        return level

    def _level_of_nodes(self, nodes):
        level = 0
        for node in live(nodes):
            if node.op == "item":
                if node.data not in self._levels:  # once, as several numbers read one number
                    own = self._level_of([self.element(node.data)], None)
                    self._levels[node.data] = own
                level = max(level, self._levels[node.data])
        return level

    def element(self, i):
        """The Box of one number of a row."""
        if i not in self.elements:
            self.elements[i] = Box(self, [Root("element", i, (), 0, ())], ())
        return self.elements[i]

    # -- results

    def _results(self):
        """Yield the loops of the results; results that are alone go to `single`."""
        size = self.program.outputs.size
        root = Root("out", 0, (1,), 0, (1,), "", 0, (1,))
        for piece in self._boxes([root], (size,), Piece) if size else ():
            start, strides = piece.found
            shape = piece.shape
            if math.prod(shape) == 1:
                self.single.append((piece.place, start))
                continue
            order = row_major(shape)
            root = Root("out", start, strides, piece.place, piece.steps, "", 0, order)
            yield self._loop(shape, root)

    # -- costs

    def cost(self, width):
        """The processor time of the loops, in additions, as of `cost_of`.

        `width` is the number of lanes in two registers of the processor.
        """
        found = CALLED + cost_of(self.program.nodes)
        for loop in self.loops:
            found += 2 * loop.row.size if loop.row is not None else 0
            found += sum([_cost_of_box(box, width) for box in loop.alone])
            for boxes in loop.alike:
                found += len(boxes) * (GATHERED + 2 * _cost_of_box(boxes[0], width))
        return found

    # -- loops that run together

    def _joined(self, loops):
        first = loops[0]
        if first.row is not None or not first.roots:
            return first
        boxes = first.alone
        if len(loops) > 1:
            boxes = self._boxes([root for loop in loops for root in loop.roots], first.domain)
        roots = [root for loop in loops for root in loop.roots]
        alone = []
        alike = defaultdict(list)
        whole = math.prod(first.domain)
        for box in boxes:
            points = math.prod(box.shape)
            edge = len(boxes) > 4 and (points < SMALL or points * SMALL < whole)
            edge = edge and not any(root.reduction for root in roots)
            key = box.signature() if edge else None
            alone.append(box) if key is None else alike[key].append(box)
        for key in [key for key, found in alike.items() if len(found) < FEWEST]:
            alone += alike.pop(key)
        if len(alone) + len(alike) > MOST_CODES:
            raise Refusal("its arrays have too many edges", said=False)
        return first._replace(roots=roots, alone=alone, alike=list(alike.values()))
