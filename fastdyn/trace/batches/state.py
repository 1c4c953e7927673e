"""The state that a traced function gets, and its results, as long arrays."""

from typing import Any

import numpy as np

from ..graph.refusal import Refusal
from ..symbols.real import symbol
from . import dispatch  # noqa: F401  # registers itself in BATCHES
from .columns import Columns, ids_and_kind, ids_of, of_kind
from .table import ID, Table, numbers


class LongArrays:
    """A state of n numbers as one long array; results are arrays of node numbers.

    A complex state and its results alternate real and imaginary parts.
    """

    def __init__(self, g, n, complex_state=False):
        self.g, self.table, self.complex_state = g, Table(g, n * (1 + complex_state)), complex_state
        g.batches = self.table

    def start(self):
        whole = Columns(self.table, None, self.table.state)
        return whole.view(complex) if self.complex_state else whole

    def written(self, y):
        if not y.written():
            return False
        return not np.array_equal(y.ids.reshape(-1).view(ID), numbers(self.table.state))

    def results(self, result, shape) -> Any:
        if shape is None:
            if isinstance(result, list | tuple | np.ndarray) and np.size(result) == 1:
                result = self.table.symbol(np.reshape(ids_of(self.table, result), -1)[0])
            return [symbol(self.table.g, result).node]
        if self.complex_state:
            return self._pairs(result, int(np.prod(shape)))
        size = int(np.prod(shape))
        try:
            ids, kind = ids_and_kind(self.table, result)
        except ValueError:
            raise Refusal("it returns a list of arrays of several lengths") from None
        if kind == "c":
            raise Refusal("it returns complex numbers")
        ids = of_kind(self.table, ids, kind, "f")
        if not np.ndim(ids) and size > 1 and not isinstance(result, np.ndarray):
            ids = np.full(size, ids, ID)
        if np.size(ids) != size:
            raise Refusal(f"it returns {np.size(ids)} numbers, not {size}")
        return np.ascontiguousarray(ids, ID).reshape(-1)

    def _pairs(self, result, size):
        ids = ids_of(self.table, result, "c")
        if ids.size != size:
            raise Refusal(f"it returns {ids.size} numbers, not {size}")
        return np.ascontiguousarray(ids).reshape(-1).view(ID)

    def chosen(self, node, yes, no):
        """Select the results `yes` or `no` by the condition `node`."""
        if isinstance(yes, list):
            return [self.table.g.select(node, a, b) for a, b in zip(yes, no, strict=True)]
        if np.array_equal(yes, no):
            return yes
        condition = np.array(self.table.one(node), ID)
        return numbers(self.table.make("select", None, yes.shape, (condition, yes, no)))

    def lost(self, n):
        return np.full(n, self.table.one(self.table.g.const(np.nan)), ID)
