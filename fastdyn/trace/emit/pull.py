"""Pulls values at the places of a box: a rectangular part of a loop, in which ids are affine.

The values of a row at affine places are its operation on operands that are pulled, too.  Therefore
loops fuse, shifts become offsets of reads, and common subexpressions are shared, without a search.
Where an operand is not affine, the box is cut.
"""

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import as_strided

from ..graph.rows import ID

FEW, MOST = 8, 64  # cuts along an axis: above FEW, rows are tried; above MOST, a table of places
SHORT = 3  # mean length of pieces, below which a table of places is made instead of FEW cuts
SMALL = 16  # least length of an innermost loop that is chosen for its strides


class Cut(Exception):
    """An operand is affine only between places along an axis of the box."""


class Fold(Exception):
    """An operand is affine in rows of a length, into which an axis of the box is folded."""


class Scattered(Exception):
    """An operand without order lies in several rows: they must be copied into one."""


class Kept(Exception):
    """A row that a table of places reads must be in memory."""


class Value(NamedTuple):
    """One value of a box.

    `kind` is "read" (`data`: array, place, whether truth values), "gather" (the same, and places),
    "one" (a node) or "op" (operation and its data).  `args` are the indices of the operands.  A
    value with stride 0 along an axis is constant along the axis.
    """

    kind: str
    data: Any
    args: tuple
    strides: tuple


class Root(NamedTuple):
    """The store of a loop: ``target[place + steps . k] = number start + strides . k``.

    `target` is "out" or the first id of a row that is kept in memory; `at` and `order` are place
    and steps of the point k in an array of the loop's whole domain.
    """

    target: Any
    start: int
    strides: tuple
    place: int
    steps: tuple
    reduction: str = ""
    at: int = 0
    order: tuple = ()

    def part(self, axis, begin):
        """The root of a box that begins at an index of an axis."""
        return self._replace(
            start=self.start + begin * self.strides[axis],
            place=self.place + begin * self.steps[axis],
            at=self.at + begin * self.order[axis],
        )

    def folded(self, axis, length):
        """The root of a box of which an axis is folded into rows of a length."""
        fold = lambda s: (*s[:axis], s[axis] * length, *s[axis:])  # noqa: E731
        return self._replace(
            strides=fold(self.strides), steps=fold(self.steps), order=fold(self.order)
        )


class Store(NamedTuple):
    """``target[place + steps . k] = value``, or a reduction of the target and the value."""

    target: Any
    place: int
    steps: tuple
    value: int
    reduction: str


class Box:
    """The values and stores of roots over a box; see `Plan` for `plan`."""

    def __init__(self, plan, roots, shape):
        self.plan = plan
        self.roots = roots
        self.shape = shape
        self.values: list[Value] = []
        self.stores: list[Store] = []
        self._known: dict = {}
        for root in roots:
            strides = self._along(root.strides)
            if root.reduction:
                row = plan.program.row_at(root.target)
                value = self._operand(row, row.args[0], root.start - row.first, strides)
            else:
                value = self.pull(root.start, strides, root.target)
            self.stores.append(
                Store(root.target, root.place, self._along(root.steps), value, root.reduction)
            )

    def add_results(self):
        """Let the stores of results add to what is there."""
        self.stores = [s._replace(reduction="sum") if s.target == "out" else s for s in self.stores]

    def _along(self, strides):
        return tuple([s if n > 1 else 0 for s, n in zip(strides, self.shape, strict=True)])

    def pull(self, start, strides, target=None):
        """The index of the Value of the numbers ``start + strides . k``."""
        found = self._known.get((start, strides))
        if found is None:
            found = self._add(self._made(start, strides, target))
            self._known[start, strides] = found
        return found

    def _add(self, value):
        self.values.append(value)
        return len(self.values) - 1

    def _made(self, start, strides, target):
        row = self.plan.program.row_at(start)
        if row is None:
            return Value("one", self.plan.program.node(start), (), strides)
        at = start - row.first
        array = self.plan.array(row)
        if array is not None and array != target:
            return Value("read", (array, at, row.truth), (), strides)
        args = tuple([self._operand(row, a, at, strides) for a in row.args])
        return Value("op", (row.op, self.plan.decisions.get(row.first, row.data)), args, strides)

    def _operand(self, row, a, at, strides):
        none = (0,) * len(strides)
        if not isinstance(a, np.ndarray):
            i = self.plan.program.node(a)
            if ("one", i.key) not in self._known:
                self._known["one", i.key] = self._add(Value("one", i, (), none))
            return self._known["one", i.key]
        found = self.plan.affine(a, at, strides, self.shape)
        if found is not None:
            return self.pull(*found)
        ids = view(a, at, strides, self.shape)
        owner = row.first
        row = self.plan.program.row_at(int(ids.min()))
        if row is None or self.plan.program.row_at(int(ids.max())) is not row:
            raise Scattered(owner, a)
        array = self.plan.array(row)
        if array is None:
            raise Kept(row.first)
        places = np.ascontiguousarray(ids - row.first)
        return self._add(Value("gather", (array, 0, row.truth, places), (), row_major(self.shape)))

    # -- loops

    def merge_axes(self):
        """The axes of the loops, outermost first, and their lengths.

        Two axes merge if all reads and stores traverse them as one axis.  Of the remaining axes,
        the axis with the most unit strides becomes the innermost loop.
        """
        shape, axes = list(self.shape), [i for i, n in enumerate(self.shape) if n > 1]
        strides = [v.strides for v in self.values if v.kind in ("read", "gather")]
        strides += [s.steps for s in self.stores]
        for outer, inner in reversed(list(pairwise(axes))):
            if all(s[outer] == s[inner] * shape[inner] for s in strides):
                shape[inner] = shape[inner] * shape[outer]
                shape[outer] = 1
                axes.remove(outer)
        if len(axes) > 1:

            def neighbours(axis):
                near = sum(s[axis] == 1 for s in strides) - sum(s[axis] > 1 for s in strides)
                return near if shape[axis] >= SMALL else -len(strides) - 1

            inner = max(axes, key=lambda axis: (neighbours(axis), axis))
            axes.sort(key=lambda axis: (axis == inner, axis))
        return axes, shape

    def signature(self):
        """The box without its places: boxes with equal signatures share their code.

        A box with a table of places has the signature None.
        """
        if any(v.kind == "gather" for v in self.values):
            return None
        values = []
        for kind, data, args, _ in self.values:
            if kind == "op" and data[0] == "select":
                data = "select"  # without the number of the decision
            values.append((kind, data[0] if kind == "read" else data, args))
        return tuple(values), tuple([(s.target, s.value, s.reduction) for s in self.stores])

    def grid(self):
        """The places of all reads and stores, one row for each point of the box."""
        places = [(v.data[1], v.strides) for v in self.values if v.kind == "read"]
        places += [(s.place, s.steps) for s in self.stores]
        return np.column_stack([_grid(at, strides, self.shape) for at, strides in places])


def _grid(at, strides, shape):
    """The places ``at + strides . k`` for all k < shape, in row-major order."""
    places = np.array(at, ID)
    for stride, n in zip(strides, shape, strict=True):
        places = places[..., None] + np.arange(n, dtype=ID) * ID(stride)
    return places.ravel()


def row_major(shape):
    """The strides, in elements, of a row-major array."""
    return tuple([math.prod(shape[k + 1 :]) for k in range(len(shape))])


def view(flat, at, strides, shape):
    """The numbers ``flat[at + strides . k]`` for k < shape."""
    return as_strided(flat[at:], shape, [s * flat.itemsize for s in strides], writeable=False)


def affine(program, ids):
    """(start, strides) if ``ids[k] = start + strides . k`` in one row; None for a table of places.

    Raises
    ------
    Cut, Fold
    """
    corner = (0,) * ids.ndim
    start = int(ids[corner])
    strides = []
    for axis, n in enumerate(ids.shape):
        step = (*corner[:axis], 1, *corner[axis + 1 :])
        strides.append(int(ids[step]) - start if n > 1 else 0)
    ends = [s * (n - 1) for s, n in zip(strides, ids.shape, strict=True)]
    if int(ids[(-1,) * ids.ndim]) == start + sum(ends) and np.array_equal(
        ids, _grid(start, strides, ids.shape).reshape(ids.shape)
    ):
        low, high = (start + sum(f(0, e) for e in ends) for f in (min, max))
        if low == high or ((row := program.row_at(low)) and high < row.first + row.size):
            return start, tuple(strides)
        lines = [_turns(program.owners(ids), axis) for axis in range(ids.ndim)]
    else:
        lines = [_cuts(ids, axis) for axis in range(ids.ndim)]
        if not any(map(len, lines)):  # affine along each axis alone
            lines = [np.arange(1, n) if n == min(m for m in ids.shape if m > 1) else []
                     for n in ids.shape]  # fmt: skip
    for axis in sorted(range(ids.ndim), key=lambda k: -len(lines[k])):
        if len(lines[axis]) > FEW:
            for length in _lengths(lines[axis], ids.shape[axis]):
                rows = ids.reshape(*ids.shape[:axis], -1, length, *ids.shape[axis + 1 :])
                count = [len(_cuts(rows, k)) for k in (axis, axis + 1)]
                if max(count) <= MOST and math.prod(c + 1 for c in count) <= len(lines[axis]):
                    raise Fold(axis, length)
    many = max(zip(map(len, lines), ids.shape, strict=True))
    if many[0] > MOST or (many[0] > FEW and SHORT * many[0] > many[1]):
        return None
    axis = max(range(ids.ndim), key=lambda k: (0 < len(lines[k]) <= FEW, len(lines[k]) > 0, k))
    raise Cut(axis, [int(a) for a in lines[axis]])


def _turns(owners, axis):
    """The indices along an axis at which the row changes."""
    others = tuple(k for k in range(owners.ndim) if k != axis)
    return np.flatnonzero((np.diff(owners, axis=axis) != 0).any(axis=others)) + 1


def _cuts(ids, axis):
    """The indices along an axis at which affine pieces begin, anywhere along the other axes."""
    n = ids.shape[axis]
    if n == 1:
        return []
    rows = np.moveaxis(ids, axis, 0)
    d = rows[1:] - rows[:-1]
    if n == 2:
        return [] if (d == d.flat[0]).all() else [1]
    change = d[1:] != d[:-1]
    change = change if change.ndim == 1 else change.any(axis=tuple(range(1, change.ndim)))
    at = (np.flatnonzero(change) + 1).tolist()
    cuts = []
    begin = 0
    if len(at) > 4 * MOST:
        return np.array(at)
    for a, b in pairwise([0, *at, n - 1]):  # d[a:b] are equal
        a = max(a, begin)
        if b > a:
            begin = b + 1 if b - a > 1 else a + 1  # one deviating difference is a cut
            cuts.append(begin)
    return [c for c in cuts if c < n]


def _lengths(at, size):
    """Row lengths to try, derived from the distances between cuts."""
    middle = len(at) // 2
    tried = [int(m) - int(at[middle]) for m in at[middle + 1 : middle + 7]] + [2, 3, 4, 5, 6, 8]
    return [m for m in dict.fromkeys(tried) if m > 1 and size % m == 0 and m < size]
