"""The state that a traced function gets, and its results, as long arrays."""

from typing import Any

import numpy as np

from ..graph.refusal import Refusal
from ..symbols.real import symbol
from . import numpys  # noqa: F401  # registers itself in BATCHES
from .columns import Columns, ids_of
from .table import ID, Table, numbers


class LongArrays:
    """A state of n real numbers as one long array; results are arrays of node numbers."""

    complex_state = False

    def __init__(self, g, n):
        self.g, self.table = g, Table(g, n)
        g.batches = self.table

    def start(self):
        return Columns(self.table, None, self.table.state)

    def written(self, y):
        return y.written() and not np.array_equal(y.ids, numbers(self.table.state))

    def results(self, result, shape) -> Any:
        if shape is None:
            if isinstance(result, list | tuple | np.ndarray) and np.size(result) == 1:
                result = self.table.symbol(np.reshape(ids_of(self.table, result), -1)[0])
            return [symbol(self.table.g, result).node]
        try:
            ids = ids_of(self.table, result, False)
        except ValueError:
            ids = self._joined(result)
        size = int(np.prod(shape))
        if not np.ndim(ids) and size > 1 and not isinstance(result, np.ndarray):
            ids = np.full(size, ids, ID)
        if np.size(ids) != size:
            raise Refusal(f"it returns {np.size(ids)} numbers, not {size}")
        return np.ascontiguousarray(ids, ID).reshape(-1)

    def _joined(self, result):
        """Refuse a list of arrays with several lengths, which SciPy refuses, too."""
        raise Refusal("it returns a list of arrays of several lengths")

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
