"""The batches of a trace: the nodes of an operation on arrays have consecutive numbers.

A node number determines a batch and a place in the batch.  An operation on single numbers is a node
of the graph.  If an array needs such a node, the node is a batch of one element.
"""

import hashlib
import math
from bisect import bisect_right
from typing import Any

import numpy as np

from ...operations import OPERATIONS
from ..graph.clock import look
from ..graph.domains import WHOLE
from ..graph.expressions import live
from ..numpy.tables import Table as LongArray
from ..symbols.complex_pair import is_complex, parts
from ..symbols.conditions import Condition, kind_of_number
from ..symbols.layout import laid_out
from ..symbols.real import Symbol, symbol
from ..symbols.symbolic import Lazy, is_symbolic, refuse

ID = np.int32
PARTS = "real", "imag"
PAIR = np.dtype([(name, ID) for name in PARTS])  # the node numbers of a complex number
MOST = 2**31 - 2**24  # limit of node numbers
FEW = 8  # up to so many constants become nodes of the graph
MOST_BATCHES = 4000
REDUCTIONS = frozenset(("sum", "top", "low"))
PRODUCTS = frozenset(("dense", "csr", "running", "island"))  # each has a loop of its own, not fused
IN_MEMORY = frozenset(("y", "par", "block", "const"))  # in memory before any loop runs
LEAVES = IN_MEMORY | {"one"}


class Batch:
    """The nodes of one operation on arrays; they have the numbers ``first + i`` for i < size.

    An operand is the number of a batch (read in order), an array without axes (one node for all
    elements), or a flat array of node numbers.  `truth` tells whether the nodes are truth values.
    `at` is the number of nodes that the graph had when the batch was made.
    """

    __slots__ = ("at", "data", "first", "number", "op", "operands", "shape", "size", "truth")

    def __init__(self, number, op, data, shape, operands, truth, first, at):
        self.at, self.number, self.op, self.data, self.shape = at, number, op, data, shape
        self.operands, self.truth, self.first = list(operands), truth, first
        self.size = int(np.prod(shape, dtype=np.int64))


class Table:
    """All batches of a trace; the state has the node numbers 0 to n - 1."""

    def __init__(self, graph, n):
        self.g, self.batches, self.next = graph, [], 0
        self._known: dict = {}
        self._singles: dict = {}  # node numbers of the graph's nodes
        self.state = self.make("y", None, (n,), ())

    def make(self, op, data, shape, operands, truth=False):
        """The batch of an operation; equal operations on equal operands share a batch."""
        place = op, data, shape, *map(_place, operands)
        known = self._known.get(place)
        if known is not None:
            return known
        look()
        batch = Batch(
            len(self.batches), op, data, shape, operands, truth, self.next, len(self.g.nodes)
        )
        self.next += batch.size + 1  # a gap, so that no affine run crosses batches
        if self.next > MOST or len(self.batches) > MOST_BATCHES:
            refuse("it takes too many operations", said=False)
        self.batches.append(batch)
        self._known[place] = batch
        return batch

    def batch_of(self, i):
        """The batch that contains a node number."""
        return self.batches[bisect_right(self.batches, i, key=lambda b: b.first) - 1]

    # -- single nodes

    def one(self, node):
        """The node number of a node of the graph."""
        if node.op == "y":
            return node.data
        if node.op == "item":
            return node.data
        found = self._singles.get(node.key)
        if found is None:
            batch = self.make("one", node, (), (), OPERATIONS[node.op].truth or node.data is True
                              or node.data is False)  # fmt: skip
            found = self._singles[node.key] = batch.first
        return found

    def symbol(self, i) -> Any:
        """The Symbol, or the truth value, of a node number."""
        i = int(i)
        batch = self.batch_of(i)
        if batch.op == "one":
            node = batch.data
        elif batch.op == "y":
            node = self.g.make("y", (), i)
        elif batch.op == "par":
            node = self.g.make("par", (), batch.data.start + i - batch.first)
        else:
            node = self.g.make("item", (), i)
        if not batch.truth:
            return Symbol(self.g, node)
        return self.g.condition(node) if node.op != "const" else node.data

    def items_of(self, *nodes):
        """The node numbers of the elements of batches that nodes of the graph depend on."""
        return [each.data for each in live(nodes) if each.op in ("item", "y")]

    # -- arrays from outside

    def of_slots(self, slots):
        """The batch of an array of parameters."""
        return self.make("par", slots, (len(slots),), ())

    def of_array(self, array) -> Any:
        """(node numbers, kind of numbers) of an array that is no long array.

        The user's function may have made the array, or read the array from outside.
        """
        if isinstance(array, Lazy):
            found = _untouched(array)
            if found is not None:
                slots, places = found
                return (numbers(self.of_slots(slots)).reshape(-1)[places]).astype(ID), "f"
            array = array.filled()
        if array.dtype == object:
            return self._of_objects(array)
        if array.dtype.kind == "c":
            return paired(self.constants(array.real), self.constants(array.imag)), "c"
        ids = self.constants(array)
        if array.dtype != bool:
            return ids, "f" if array.dtype.kind == "f" else "i"
        zero = self.one(self.g.const(0.0))
        same = self.make("eq", None, ids.shape, (ids.reshape(-1), np.array(zero, ID)), True)
        truths = numbers(self.make("not", None, ids.shape, (same.number,), True))
        return laid_out(truths, array), "b"

    def _of_objects(self, array):
        values = list(array.view(np.ndarray).flat)
        if any(map(is_complex, values)):
            both = zip(*map(parts, values), strict=True)
            real, imag = (self._of_numbers(list(part)).reshape(array.shape) for part in both)
            return laid_out(paired(real, imag), array), "c"
        kind = common_kind(set(map(kind_of_number, values)) or {"f"})
        if kind == "b":
            ids = [self.one(truth_of(self.g, v)) for v in values]
        else:
            ids = [self.one(symbol(self.g, v).node) for v in values]
        return laid_out(np.array(ids, ID).reshape(array.shape), array), kind

    def _of_numbers(self, values):
        """The node numbers of a complex array's real or imaginary parts."""
        if not is_symbolic(values):
            return self.constants(np.array(values, float))
        nodes = [symbol(self.g, v).node for v in values]
        if all(node.op == "neg" for node in nodes):
            found = self._of_parameters([node.args[0] for node in nodes])
            if found is not None:
                return numbers(self.make("neg", None, found.shape, [found]))
        found = self._of_parameters(nodes)
        if found is None:
            return np.array([self.one(node) for node in nodes], ID)
        return found

    def _of_parameters(self, nodes):
        """The node numbers of parameters of one array from outside; None for any other nodes."""
        if any(node.op != "par" for node in nodes):
            return None
        slots, reads = [node.data for node in nodes], self.g.reads
        group = reads.groups[reads.group(slots[0])]
        whole = range(group.first, group.first + math.prod(group.shape or ()))
        if group.shape is None or min(slots) not in whole or max(slots) not in whole:
            return None
        return np.array(slots, ID) + ID(self.of_slots(whole).first - group.first)

    def constants(self, array):
        """The node numbers of an array of constants, laid out as the array.

        Truth values become 1.0 and 0.0.
        """
        array = np.asarray(array)
        if array.dtype.kind in "iu" and array.size and np.abs(array).max() > WHOLE:
            refuse("a whole number beyond 2**53")
        if array.dtype.kind not in "iufb":
            refuse(f"an array of {array.dtype} beside the state")
        array = array.astype(float)
        first = array.reshape(-1)[0] if array.size else 0.0
        if (
            array.size > FEW
            and (array == first).all()
            and np.signbit(array).all() == np.signbit(array).any()
        ):
            return np.full_like(array.view(np.ndarray), self.one(self.g.const(first)), ID)
        if array.size <= FEW:
            ones = [self.one(self.g.const(v)) for v in array.flat]
            return laid_out(np.array(ones, ID).reshape(array.shape), array)
        batch = self.of_slots(self.g.reads.held(np.ascontiguousarray(array)))
        return laid_out(numbers(batch).reshape(array.shape), array)


def numbers(batch):
    """The node numbers of a batch, in its shape."""
    return np.arange(batch.first, batch.first + batch.size, dtype=ID).reshape(batch.shape)


def paired(real, imag):
    """Combine the node numbers of real and imaginary parts to pairs."""
    ids = np.empty_like(real, PAIR)
    ids["real"], ids["imag"] = real, imag
    return ids


def common_kind(kinds):
    """The kind of an array that is made of numbers of several kinds."""
    if "b" in kinds and len(kinds) > 1:
        refuse("truth values and numbers in one array")
    return next(kind for kind in "cfib" if kind in kinds)


def _untouched(array):
    """(slots, places) of a long array from outside; None after a write to the array."""
    if not isinstance(array, LongArray) or array._at is None or not array._asked.untouched():
        return None
    return array._elements.slots, array._at


def _place(operand):
    if isinstance(operand, int):
        return operand
    if operand.ndim == 0:
        return "one", int(operand)
    return operand.size, hashlib.blake2b(operand.data, digest_size=16).digest()


def truth_of(g, value):
    """The node of a truth value, which is a Condition or a plain bool."""
    return value.node if isinstance(value, Condition) else g.const(bool(value))
