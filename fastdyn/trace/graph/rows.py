"""Rows of many numbers in a graph: each number has an id, and an array is an array of ids.

The id of a node is its key.  An operation on a long array is a row, whose numbers have consecutive
ids.  `Rows.map` is the only way to compute, so that all above it is written once for all lengths.
"""

import hashlib
import math
from bisect import bisect_right
from typing import Any

import numpy as np

from ..operations import OPERATIONS
from ..operations.delays import PASTS
from .clock import look
from .expressions import Graph, Node
from .refusal import Refusal

ID = np.int32
PAIR = np.dtype([("real", ID), ("imag", ID)])  # the ids of a complex number
LIMIT = 2**31 - 2**24  # of ids
MOST_ROWS = 4000
FEW = 32  # up to so many numbers are computed one by one, also in a graph with rows
SHORT = 8  # terms of a sum that is not a row
SHARED = 64  # a table of more constants is a row
LEAVES = frozenset(("y", "par", "const"))  # rows that lie in memory


class Row:
    """The numbers of one operation, with the ids from `first` on, in the C order of `shape`.

    An operand in `args` is one id for all numbers, or a flat array of ids.  A row "const" holds its
    numbers as `data`, a row "par" its range of slots.
    """

    __slots__ = ("args", "data", "first", "op", "shape", "size", "truth", "varies")

    def __init__(self, op, args, data, shape, first, truth, varies):
        self.op = op
        self.args = args
        self.data = data
        self.shape = shape
        self.first = first
        self.size = math.prod(shape)
        self.truth = truth
        self.varies = varies


class Owners:
    """Finds the rows that hold ids; `rows` has them in the order of their first ids."""

    rows: list

    def row_at(self, i) -> Any:
        """The row that holds an id; None for the id of a node."""
        row = self.rows[bisect_right(self.rows, i, key=lambda row: row.first) - 1]
        return row if row.first <= i < row.first + row.size else None

    def owners(self, ids):
        """The index of the row of each id; ``-1 - id`` for the id of a node."""
        firsts = np.array([row.first for row in self.rows], ID)
        k = np.searchsorted(firsts, ids, "right") - 1
        ends = firsts + np.array([row.size for row in self.rows], ID)
        return np.where((ids >= firsts[0]) & (ids < ends[k]), k, -1 - ids)

    def parts(self, ids):
        """The rows that hold ids, and the ids of nodes."""
        if not ids.size:
            return [], []
        low, high = int(ids.min()), int(ids.max())
        row = self.row_at(low)
        if row is not None and high < row.first + row.size:
            return [row], []
        owners = self.owners(ids).ravel()
        rows = np.flatnonzero(np.bincount(owners[owners >= 0]))
        nodes = -1 - owners[owners < 0]
        if nodes.size and nodes.min() == nodes.max():
            nodes = nodes[:1]
        return [self.rows[k] for k in rows.tolist()], np.unique(nodes).tolist()


class Rows(Owners, Graph):
    """A graph whose numbers have ids: nodes, and the numbers of rows.

    Parameters
    ----------
    n : int
        The number of real components of the state.
    few : float
        Operations on arrays of more numbers become rows.
    """

    def __init__(self, n=0, few=math.inf):
        super().__init__()
        self.few, self.rows, self._firsts, self._arrays = few, [], [], []
        self._of_arrays: dict = {}
        self.state = self.row("y", (n,))

    # -- rows and nodes

    def row(self, op, shape, args=(), data=None, truth=False, varies=True):
        """A new row, or the known row of an equal operation on equal operands."""
        label = data if op not in LEAVES else len(self.rows)
        place = op, label, shape, *[a if type(a) is int else digest(a) for a in args]
        row = self._known.get(place)
        if row is None:
            look()
            varies = varies or (op not in LEAVES and OPERATIONS[op].value is None)
            row = Row(op, args, data, shape, self.next, truth, varies)
            self.next += row.size + 1  # a gap, so that no even run of ids crosses rows
            if self.next > LIMIT or len(self.rows) > MOST_ROWS:
                raise Refusal("it takes too many operations", said=False)
            self._known[place] = row
            self.rows.append(row)
            self._firsts.append(row.first)
        return row

    def row_of(self, i) -> Row:
        """The row that holds an id, which is no node's."""
        return self.rows[bisect_right(self._firsts, i) - 1]

    def ids(self, row):
        """The ids of a row, in its shape."""
        return np.arange(row.first, row.first + row.size, dtype=ID).reshape(row.shape)

    def node(self, i) -> Node:
        """The node of an id; a number of a row becomes a node on first use."""
        return self.nodes.get(i) or self._of_row(self.row_of(i), int(i))

    def _of_row(self, row, i):
        k = i - row.first
        if row.op in PASTS:  # whose nodes are made as they are read
            node = self.nodes[i] = self.make(row.op, (self.nodes[row.data],), k)
            return node
        if row.op == "const":
            return self.const(row.data.reshape(-1)[k])
        if row.op in ("y", "par"):
            return self.make(row.op, (), row.data[k] if row.op == "par" else k)
        if not row.varies:
            args = [self.node(a if type(a) is int else int(a[k])) for a in row.args]
            return self.call(row.op, *args, data=row.data)
        node = self.nodes[i] = Node("item", (), i, i)
        return node

    def key_of(self, op, data):
        """The key of a new node: its id in a row, if a row holds the number."""
        if op == "y" and self.rows and data < self.state.size:
            return self.state.first + data
        if op == "par":
            for row in self._arrays:
                if data in row.data:
                    return row.first + data - row.data.start
        return super().key_of(op, data)

    def array(self, slots, like):
        """The read-only ids of an array of parameters, which lie in memory as `like` does.

        All paths of a trace share the ids, as their cost for a long table would be that of a solve.
        """
        found = self._of_arrays.get(slots)
        if found is None:
            varies = any(s in slots for s in self.varying)
            row = self.row("par", (len(slots),), (), slots, varies=varies)
            self._arrays.append(row)
            ids = self.ids(row)
            found = np.empty_like(like, PAIR if like.dtype == complex else ID, subok=False)
            found[...] = ids.view(found.dtype).reshape(like.shape)
            found.flags.writeable = False
            self._of_arrays[slots] = found
        return found

    def constants(self, array):
        """The ids of an array of constants, which lie in memory as the array does."""
        array = np.asarray(array)
        if array.dtype.kind not in "iufb":
            raise Refusal(f"an array of {array.dtype} beside the state")
        if array.dtype.kind in "iu" and array.size and np.abs(array).max() > 2**53:
            raise Refusal("a whole number beyond 2**53")
        numbers = array if array.dtype == bool else array.astype(float)
        found = np.empty_like(array, ID, subok=False)
        if array.size <= SHARED:
            found[...] = np.array([self.const(v).key for v in numbers.flat], ID).reshape(
                array.shape
            )
        elif (bits := numbers.reshape(-1)) is not None and _all_equal(bits):
            found[...] = self.const(bits[0]).key
        else:
            data = np.ascontiguousarray(numbers)
            place = "constants", numbers.dtype.kind, data.shape, _bytes(data)
            row = self._known.get(place)
            if row is None:
                row = self.row("const", array.shape, (), data, array.dtype == bool, False)
                self._known[place] = row
            found[...] = self.ids(row)
        return found

    # -- operations on ids

    def check(self, count):
        """Refuse at once an operation of so many nodes that they fit into no graph without rows."""
        if self.few == math.inf and count > self.most:
            raise Refusal("it takes too many operations", final=True, said=False)

    def map(self, op, *args, data=None) -> Any:
        """Apply an operation to ids and arrays of ids, element by element.

        The result is an id, or an array that lies in memory as the result of a ufunc would.
        """
        arrays = [a for a in args if isinstance(a, np.ndarray)]
        if not arrays:
            return self.call(op, *map(self.node, args), data=data).key
        shape = np.broadcast_shapes(*[a.shape for a in arrays])
        size = math.prod(shape)
        if size <= self.few:
            lists = [a.ravel().tolist() for a in np.broadcast_arrays(*args)]
            node, call = self.node, self.call
            flat = [call(op, *map(node, each), data=data).key for each in zip(*lists, strict=True)]
            found = np.array(flat, ID).reshape(shape)
        else:
            found = self._long(op, data, args, shape)
        return as_ufunc(found, arrays)

    def _long(self, op, data, args, shape):
        operands = tuple([_operand(a, shape) for a in args])
        same = self._simpler(op, operands)
        if same is not None:
            return np.array(np.broadcast_to(same, math.prod(shape))).reshape(shape)
        if all(type(a) is int for a in operands):
            i = self.call(op, *map(self.node, operands), data=data).key
            return np.full(shape, i, ID)
        known = [self.known(a) for a in operands]
        value = None if data is not None else OPERATIONS[op].value
        if value and not any(v is None for v in known):
            with np.errstate(all="ignore"):
                found = value(*known)
            return self.constants(np.asarray(found).reshape(shape))
        truth = OPERATIONS[op].truth or (op == "select" and self.is_truth(operands[1]))
        varies = any(self.varies(a) for a in operands)
        return self.ids(self.row(op, shape, operands, data, truth, varies))

    def _simpler(self, op, operands):
        """The operand that a decision surely returns; None if there is none (LLVM finds others)."""
        a, b = operands[0], operands[-1]
        if op == "select" and a in (self.true.key, self.false.key) if type(a) is int else False:
            return operands[1] if a == self.true.key else operands[2]
        if op in ("and", "or"):
            end, neutral = self.false.key, self.true.key
            if op == "or":
                end, neutral = neutral, end
            for one, other in ((a, b), (b, a)):
                if type(one) is int and one in (end, neutral):
                    return one if one == end else other
        return None

    def known(self, ids) -> Any:
        """The values of constants; None if some of the ids are no constants."""
        if isinstance(ids, np.ndarray) and ids.size:
            rows, nodes = self.parts(ids)
            if any(of.op != "const" for of in (*rows, *[self.nodes[i] for i in nodes])):
                return None
            if len(rows) == 1 and not nodes:
                return rows[0].data.reshape(-1)[ids - rows[0].first]
            values = [self._constant(i) for i in ids.ravel().tolist()]
            return np.array(values).reshape(ids.shape)
        return np.zeros(0) if isinstance(ids, np.ndarray) else self._constant(ids)

    def _constant(self, i):
        node = self.nodes.get(i)
        if node is not None:
            return node.data if node.op == "const" else None
        row = self.row_of(i)
        return row.data.reshape(-1)[i - row.first] if row.op == "const" else None

    def _row_with(self, ids):
        """The row that holds all ids; None if several do, or if some are of nodes."""
        row = self.row_at(int(ids.min()))
        return row if row is not None and ids.max() < row.first + row.size else None

    def varies(self, ids):
        """Whether some of the numbers depend on t, on y, or on parameters that vary."""
        if type(ids) is int:
            node = self.nodes.get(ids)
            return self.row_of(ids).varies if node is None else node.varies
        rows, nodes = self.parts(ids)
        return any(of.varies for of in (*rows, *[self.nodes[i] for i in nodes]))

    def is_truth(self, ids):
        """Whether the first of the ids is that of a truth value."""
        i = ids if type(ids) is int else int(ids.flat[0])
        node = self.nodes.get(i)
        while node is not None and node.op == "select":
            node = node.args[1]
        if node is None or node.op == "item":
            return self.row_of(i if node is None else node.data).truth
        return OPERATIONS[node.op].truth or (node.op == "const" and type(node.data) is bool)

    # -- reductions

    def reduce(self, op, ids, axis=None, keepdims=False) -> Any:
        """The sum ("sum"), maximum ("top") or minimum ("low") along axes; NaN if one is NaN."""
        axes = range(ids.ndim) if axis is None else [int(a) % ids.ndim for a in np.atleast_1d(axis)]
        axes = sorted(axes)
        kept = [i for i in range(ids.ndim) if i not in axes]
        shape, count = tuple(ids.shape[i] for i in kept), math.prod(ids.shape[i] for i in axes)
        ids = ids.transpose([*kept, *axes])
        if ids.size <= self.few or (count <= SHORT and shape):
            rows = ids.reshape(*shape, count)
            found = self._in_turn(op, rows, count)
        elif not count:
            found = np.full(shape, self.const(0.0).key, ID) if op == "sum" else _empty()
        else:
            operand = _operand(ids, ids.shape)
            if type(operand) is int:
                operand = np.full(ids.size, operand, ID)
            row = self.row(op, shape, (operand,), count, False, self.varies(operand))
            found = self.ids(row) if shape else row.first
        return np.expand_dims(np.asarray(found, ID), tuple(axes)) if keepdims else found

    def _in_turn(self, op, rows, count):
        if count == 0:
            return np.full(rows.shape[:-1], self.const(0.0).key, ID) if op == "sum" else _empty()
        if op == "sum" and rows.size <= self.few:
            flat = rows.reshape(-1, count)
            sums = [self.sum([self.node(i) for i in row]).key for row in flat.tolist()]
            return np.array(sums, ID).reshape(rows.shape[:-1]) if rows.ndim > 1 else sums[0]
        total = rows[..., 0] if rows.ndim > 1 else int(rows[0])
        for j in range(1, count):
            term = rows[..., j] if rows.ndim > 1 else int(rows[j])
            total = self.map("add", total, term) if op == "sum" else self.extreme(op, total, term)
        return total

    def extreme(self, op, a, b):
        """The larger ("top") or the smaller ("low") of two numbers; NaN if either is NaN."""
        first = self.map("le", b, a) if op == "top" else self.map("le", a, b)
        bad = self.map("not", self.map("eq", a, a))
        return self.map("select", self.map("or", first, bad), a, b)

    def anywhere(self, ids) -> Node:
        """The node that tells whether one of some truth values is true."""
        if type(ids) is int:
            return self.node(ids)
        if ids.size <= self.few:
            found = self.false
            for i in ids.ravel().tolist():
                found = self.both(found, self.node(i), "or")
            return found
        one, none = self.const(1.0).key, self.const(0.0).key
        most = self.reduce("top", self.map("select", ids, one, none))
        return self.compare(self.const(0.5), self.node(most), "lt")


def as_ufunc(found, arrays):
    """The ids of a result, moved in memory as NumPy lays out the result of a ufunc of `arrays`."""
    if found.ndim < 2 or all(a.flags.c_contiguous for a in arrays if a.ndim > 1):
        return found
    flags: Any = ["zerosize_ok"]
    dtypes: Any = [None] * len(arrays) + [np.dtype(ID)]
    moved: Any = np.nditer([*arrays, None], flags, op_dtypes=dtypes).operands[-1]
    moved[...] = found
    return moved


def _empty():
    raise ValueError("zero-size array to reduction operation which has no identity")


def _operand(ids, shape):
    """An operand of a row: one id for all numbers, or a copy of the ids in C order."""
    if type(ids) is int:
        return ids
    if ids.size == 1 or (ids.size and ids.strides == (0,) * ids.ndim):
        return int(ids.flat[0])
    if ids.size and ids.flat[0] == ids.flat[-1] and (ids == ids.flat[0]).all():
        return int(ids.flat[0])
    return np.array(np.broadcast_to(ids, shape), ID, order="C").reshape(-1)


def digest(array):
    """A label of an array of ids; equal arrays have equal labels."""
    if array.size > 1 and array[-1] - array[0] == array.size - 1 and (np.diff(array) == 1).all():
        return array.size, int(array[0])
    return array.size, _bytes(array)


def _bytes(array):
    return hashlib.blake2b(np.ascontiguousarray(array).data, digest_size=16).digest()


def _all_equal(numbers):
    if numbers.dtype == bool:
        return bool(numbers.all() == numbers.any())
    first = numbers[0]
    return bool((numbers == first).all()) and np.signbit(numbers).all() == np.signbit(numbers).any()
