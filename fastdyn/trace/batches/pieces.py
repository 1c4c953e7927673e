"""Splits arrays of node numbers into pieces in which the numbers are affine in the indices."""

import math
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import as_strided

from .table import PRODUCTS, REDUCTIONS

FEW, LIMIT = 8, 64  # cuts along an axis: above FEW, rows are tried; above LIMIT, a table of places
MOST_TURNS = 4096


class Irregular(Exception):
    """Raised for an array with too many pieces; the argument is an array of indices of cuts."""


class Piece(NamedTuple):
    """``ids[lo + k] = start + strides . k`` for k < shape; all numbers belong to one batch."""

    lo: tuple
    shape: tuple
    start: int
    strides: tuple
    batch: Any


def row_major(shape):
    """The strides, in elements, of a row-major array."""
    steps, step = [], 1
    for s in reversed(shape):
        steps.append(step)
        step *= s
    return tuple(reversed(steps))


def place_of(at, strides):
    """The dot product ``strides . at``."""
    return sum(a * s for a, s in zip(at, strides, strict=True))


def view(flat, at, strides, shape):
    """The numbers ``flat[at + strides . k]`` for k < shape."""
    return as_strided(flat[at:], shape, [s * flat.itemsize for s in strides], writeable=False)


def cuts_along(ids, axis, limit):
    """The indices along an axis at which affine pieces begin, anywhere along the other axes."""
    n = ids.shape[axis]
    if n == 1:
        return [0]
    rows = np.moveaxis(ids, axis, 0)
    d = rows[1:] - rows[:-1]
    if n == 2:
        return [0] if d.size == 0 or (d == d.flat[0]).all() else [0, 1]
    change = d[1:] != d[:-1]
    change = change if change.ndim == 1 else change.any(axis=tuple(range(1, change.ndim)))
    at = np.flatnonzero(change)
    if len(at) > 2 * limit:
        raise Irregular(at)
    at, cuts, begin = [int(a) + 1 for a in at], [0], 0
    for a, b in zip([0, *at], [*at, n - 1], strict=True):  # d[a:b] are equal
        a = max(a, begin)
        if b > a:
            begin = b + 1 if b - a > 1 else a + 1  # one deviating difference is a cut
            cuts.append(begin)
    return [c for c in cuts if c < n]


def segment(table, ids, limit=LIMIT):
    """The affine pieces of an array of node numbers.

    Raises
    ------
    Irregular
        If an axis has more than about `limit` cuts.
    """
    if ids.size == 0:
        return []
    found = []
    for piece in _pieces(table, ids, [cuts_along(ids, axis, limit) for axis in range(ids.ndim)]):
        last = piece.start + place_of([n - 1 for n in piece.shape], piece.strides)
        if table.batch_of(last) is piece.batch:
            found.append(piece)
            continue
        part = ids[tuple(slice(a, a + n) for a, n in zip(piece.lo, piece.shape, strict=True))]
        for inner in _pieces(table, part, _turns(table, part)):  # an affine piece may cross batches
            lo = tuple(x + y for x, y in zip(inner.lo, piece.lo, strict=True))
            found.append(inner._replace(lo=lo))
    return found


def _turns(table, part):
    """The indices along each axis at which the batch changes."""
    firsts = np.array([b.first for b in table.batches])
    number, lines = np.searchsorted(firsts, part, "right"), []
    for axis in range(part.ndim):
        others = tuple(i for i in range(part.ndim) if i != axis)
        turn = np.flatnonzero((np.diff(number, axis=axis) != 0).any(axis=others)) + 1
        if len(turn) > MOST_TURNS:
            raise Irregular(turn)
        lines.append([0, *map(int, turn)])
    return lines


def _pieces(table, ids, cuts):
    ends = [[*c[1:], n] for c, n in zip(cuts, ids.shape, strict=True)]
    if math.prod(map(len, cuts)) > MOST_TURNS:
        raise Irregular(np.arange(0))
    for place in product(*[range(len(c)) for c in cuts]):
        lo = tuple(c[i] for c, i in zip(cuts, place, strict=True))
        shape = tuple(e[i] - a for e, i, a in zip(ends, place, lo, strict=True))
        start, strides = int(ids[lo]), []
        for axis, n in enumerate(shape):
            step = tuple(a + (i == axis) for i, a in enumerate(lo))
            strides.append(int(ids[step]) - start if n > 1 else 0)
        for corner in product(*[(0, n - 1) for n in shape]):
            at = tuple(a + c for a, c in zip(lo, corner, strict=True))
            if ids[at] != start + place_of(corner, strides):
                raise Irregular(np.arange(0))
        yield Piece(lo, shape, start, tuple(strides), table.batch_of(start))


def in_rows(table, ids):
    """A shape in which an array of node numbers has few pieces, and the pieces in that shape."""
    try:
        return ids.shape, segment(table, ids, FEW if ids.ndim == 1 else LIMIT)
    except Irregular as error:
        if ids.ndim > 1:
            raise
        for length in lengths(error.args[0], ids.size):
            shape = ids.size // length, length
            try:
                return shape, segment(table, ids.reshape(shape))
            except Irregular:
                continue
        return ids.shape, segment(table, ids)


def lengths(at, size):
    """Row lengths to try, derived from the distances between cuts."""
    tried, middle = [2, 3, 4, 5, 6, 8], len(at) // 2
    if len(at) > 8:
        tried = [int(m) for m in at[middle + 1 : middle + 7] - at[middle]] + tried
    return [m for m in dict.fromkeys(tried) if m > 1 and size % m == 0 and m < size]


class Edges:
    """The affine pieces of the operands of all batches that the results depend on.

    Parameters
    ----------
    table : Table
    result : array of int
        Node numbers that are stored in order.
    items : list of int
        Further node numbers that are needed.

    Attributes
    ----------
    live : set of int
        The numbers of the batches that `result` and `items` depend on.
    edges : dict of (batch, operand) to list of Piece
    places : dict of (batch, operand) to (Batch, array of int)
        For operands with too many pieces: the source batch, and the places in the source batch.
    """

    def __init__(self, table, result, items):
        self.table, self.result, self._items = table, result, items
        self.places: dict[Any, Any] = {}
        self._shapes: dict = {}
        self._seen: dict = {}
        self._find_edges()

    def _find_edges(self):
        """Find the live batches and the pieces of their operands, in the shape of each batch."""
        table = self.table
        self.out_shape, self.out_pieces = in_rows(table, self.result)
        live = {piece.batch.number for piece in self.out_pieces}
        live |= {table.batch_of(i).number for i in self._items}
        self.edges: dict = {}
        for b in reversed(table.batches):
            if b.number not in live:
                continue
            if b.op == "one":
                live |= {table.batch_of(i).number for i in table.items_of(b.data)}
            shape = None
            while shape != self.shape_of(b):  # an operand may change the shape to rows
                shape = self.shape_of(b)
                for j, operand in enumerate(b.operands):
                    self.places.pop((b.number, j), None)
                    self.edges[b.number, j] = self._edge(b, j, operand, shape)
            for j in range(len(b.operands)):
                live |= {piece.batch.number for piece in self.edges[b.number, j]}
        self.live = live

    def _edge(self, b, j, operand, shape):
        if isinstance(operand, int):
            batch = self.table.batches[operand]
            return [Piece((0,) * len(shape), shape, batch.first, row_major(shape), batch)]
        if operand.ndim == 0:
            i, zeros = int(operand), (0,) * len(shape)
            return [Piece(zeros, shape, i, zeros, self.table.batch_of(i))]
        try:
            rows, pieces = in_rows(self.table, operand.reshape(shape))
        except Irregular:
            return self._as_places(b, j, operand)
        if rows != shape:
            self._shapes[b.number] = rows
        return pieces

    def _as_places(self, b, j, operand):
        """Describe an operand with too many pieces by a table of places in one source batch."""
        source = self.table.batch_of(int(operand.min()))
        if self.table.batch_of(int(operand.max())) is not source or b.op in PRODUCTS:
            raise Irregular(np.arange(0))
        self.places[b.number, j] = source, operand - source.first
        return [Piece((), (), source.first, (), source)]

    def shape_of(self, b):
        """The shape of a batch's loop; a reduction or a product loops over its operand."""
        if b.number in self._shapes:
            return self._shapes[b.number]
        if b.op in PRODUCTS:
            return self.table.batches[b.operands[0]].shape
        return (*b.shape, b.data) if b.op in REDUCTIONS else b.shape

    def read(self, b, j, operand, at, strides, shape):
        """The pieces of operand j of a batch, read at ``at + strides . k``."""
        if isinstance(operand, int):
            batch = self.table.batches[operand]
            return [Piece((0,) * len(shape), shape, batch.first + at, strides, batch)]
        if operand.ndim == 0:
            i, zeros = int(operand), (0,) * len(shape)
            return [Piece(zeros, shape, i, zeros, self.table.batch_of(i))]
        if shape == self.shape_of(b) and at == 0 and strides == row_major(shape):
            return self.edges[b.number, j]
        key = b.number, j, at, strides, shape
        if key not in self._seen:
            self._seen[key] = segment(self.table, view(operand, at, strides, shape))
        return self._seen[key]
