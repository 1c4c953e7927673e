"""The components of the state that each result depends on, and the numbers that meet the state."""

from typing import Any

import numpy as np

from ...operations import OPERATIONS
from ..graph.expressions import live
from ..graph.refusal import Refusal
from ..graph.rows import Row
from ..switching.switches import OF_STATE

MOST_A_ROW = 200  # up to this mean number of elements a row, a matrix counts as sparse
MOST_TIMED = 1024  # elements; the search for switching times takes some 0.1 ms for each
TIMED, MIXED = "timed", "mixed"


class Dense(Exception):
    """The matrix has too many nonzero elements to be stored as sparse."""


class Sparsity:
    """The sparsity patterns of the rows of a program, as matrices of ones."""

    def __init__(self, program, n):
        from scipy import sparse

        self._sparse: Any = sparse
        self.program, self.n, self._rows, self._nodes = program, n, {}, {}

    def of_results(self):
        """The (rows, columns) of the elements that may be nonzero, sorted by column.

        Raises
        ------
        Dense
        """
        for row in self.program.order:
            self._of(row)
        total = self._of_ids(self.program.outputs).tocsc()
        total.sort_indices()
        columns = np.repeat(np.arange(self.n), np.diff(total.indptr))
        return total.indices.astype(np.int64), columns.astype(np.int64)

    def _ones(self, rows, columns, shape):
        return self._sparse.csr_matrix((np.ones(len(rows), np.int32), (rows, columns)), shape)

    def _checked(self, matrix):
        if matrix.nnz > MOST_A_ROW * max(matrix.shape[0], self.n, 1):
            raise Dense
        matrix.data[:] = 1
        return matrix

    def _of(self, row):
        if row.first not in self._rows:
            self._rows[row.first] = self._of_row(row)
        return self._rows[row.first]

    def _of_row(self, row):
        if row.op == "y":
            return self._sparse.identity(self.n, np.int32, "csr")
        if row.op in ("dense", "island", "running"):
            raise Dense
        if row.op == "csr":
            values = self.program.g.values
            begins, places = (np.asarray(values[s.start : s.stop]).astype(np.int64)
                              for s in row.data[2:4])  # fmt: skip
            inner = self._of_ids(row.args[0])
            ones = np.ones(len(places), np.int32)
            matrix = self._sparse.csr_matrix((ones, places, begins), (row.size, inner.shape[0]))
            return self._checked(matrix @ inner)
        if row.op in ("sum", "top", "low"):
            inner = self._of_ids(row.args[0])
            terms = self._ones(np.repeat(np.arange(row.size), row.data), np.arange(inner.shape[0]),
                               (row.size, inner.shape[0]))  # fmt: skip
            return self._checked(terms @ inner)
        total = self._sparse.csr_matrix((row.size, self.n), dtype=np.int32)
        for a in row.args:
            if isinstance(a, np.ndarray):
                found = self._of_ids(a)
            else:
                found = self._repeated(np.arange(row.size), self._of_node(a), row.size)
            total = self._checked(total + found)
        return total

    def _of_ids(self, ids):
        """The pattern of numbers, one row for each."""
        program, size = self.program, ids.size
        rows, nodes = program.parts(ids)
        if len(rows) == 1 and not nodes:
            pattern, at = self._of(rows[0]), ids - rows[0].first
            if size == rows[0].size and np.array_equal(at, np.arange(size)):
                return pattern
            return self._checked(pattern[at])
        total, owners = self._sparse.csr_matrix((size, self.n), dtype=np.int32), program.owners(ids)
        for row in rows:
            here = np.flatnonzero((ids >= row.first) & (ids < row.first + row.size))
            chosen = self._ones(here, ids[here] - row.first, (size, row.size))
            total = self._checked(total + chosen @ self._of(row))
        for i in nodes:
            total = total + self._repeated(np.flatnonzero(owners == -1 - i), self._of_node(i), size)
        return self._checked(total)

    def _repeated(self, here, columns, size):
        """The pattern in which some rows have the same columns."""
        if len(here) * len(columns) > MOST_A_ROW * max(size, self.n):
            raise Dense
        return self._ones(
            np.repeat(here, len(columns)), np.tile(columns, len(here)), (size, self.n)
        )

    def _of_node(self, i):
        """The components that a single node depends on."""
        if i not in self._nodes:
            found = [np.empty(0, np.int64)]
            for node in live([self.program.node(i)]):
                at = node.data if node.op == "item" else node.key
                row = self.program.row_at(at) if node.op in ("y", "item") else None
                if row is not None:
                    found.append(self._of(row)[at - row.first].indices)
            self._nodes[i] = np.unique(np.concatenate(found))
        return self._nodes[i]


def timed_nodes(program):
    """The nodes of numbers that meet the state, single ones and numbers of rows.

    Beyond MOST_TIMED numbers, there are none for the rows.
    """
    kinds: dict = {}

    def kind_of(below, ops):
        kinds_below = {kinds.get(x.first if isinstance(x, Row) else -1 - x.key) for x in below}
        if MIXED in kinds_below or ops & OF_STATE:
            return MIXED
        return TIMED if TIMED in kinds_below or "t" in ops else None

    rows, nodes = program.order, program.nodes
    for node in nodes:
        if node.op != "item":
            kinds[-1 - node.key] = kind_of(node.args, {node.op})
        else:
            kinds[-1 - node.key] = MIXED
    wanted, singles = set(), []
    for row in rows:
        below = program.below[row.first]
        kind = kind_of(below, {row.op})
        if kind == TIMED and row.op not in OPERATIONS:
            kind = MIXED
        kinds[row.first] = kind
        singles += [x for x in below if not isinstance(x, Row)]
        if kind == MIXED:
            wanted.update(x.first for x in below if isinstance(x, Row))
    outer, single = program.parts(program.outputs)
    wanted.update(row.first for row in outer)
    found = [row for row in rows if row.first in wanted and kinds[row.first] == TIMED]
    results = [program.node(i) for i in single] + singles
    if sum(row.size for row in found) > MOST_TIMED:
        return results
    try:
        known: dict = {}
        return results + [_node(program, row.first + k, known) for row in found
                          for k in range(row.size)]  # fmt: skip
    except Refusal:  # the graph is too large
        return results


def _node(program, i, known):
    """The node of a number of a row of known operations."""
    row = program.row_at(i)
    if row is None:
        return program.node(i)
    if i not in known:
        k, g = i - row.first, program.g
        if row.op == "par":
            known[i] = g.make("par", (), row.data.start + k)
        elif row.op == "const":
            known[i] = g.const(row.data.reshape(-1)[k])
        else:
            below = [int(a[k]) if isinstance(a, np.ndarray) else a for a in row.args]
            known[i] = g.make(row.op, [_node(program, a, known) for a in below], row.data)
    return known[i]
