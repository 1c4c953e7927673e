"""The components of the state that each result depends on, and the numbers that meet the state."""

from typing import Any

import numpy as np

from ..graph.expressions import live
from ..graph.refusal import Refusal
from ..graph.rows import Row
from ..operations import OPERATIONS
from ..switching.switches import OF_STATE

MOST_A_ROW = 200  # up to this mean number of elements a row, a matrix counts as sparse
MOST_TIMED = 1024  # elements; the search for switching times takes some 0.1 ms for each


class Dense(Exception):
    """The matrix has too many nonzero elements to be stored as sparse."""


class Sparsity:
    """The sparsity patterns of the rows of a program, as matrices of ones."""

    def __init__(self, program, n):
        from scipy import sparse

        self._sparse: Any = sparse
        self.program = program
        self.n = n
        self._rows = {}
        self._nodes = {}

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
        make = self._sparse.csr_matrix
        size = row.size
        if row.op == "y":
            return self._sparse.identity(self.n, np.int32, "csr")
        if row.op in ("dense", "running"):
            raise Dense
        if row.op in ("csr", "sum", "top", "low"):
            inner = self._of_ids(row.args[0])
            if row.op == "csr":
                values = np.asarray(self.program.g.values)
                begins, places = (values[s.start : s.stop].astype(int) for s in row.data[2:4])
            else:
                begins = np.arange(size + 1) * row.data
                places = np.arange(inner.shape[0])
            ones = np.ones(len(places), np.int32)
            return self._checked(make((ones, places, begins), (size, inner.shape[0])) @ inner)
        total = make((size, self.n), dtype=np.int32)
        for a in row.args:
            ids = a if isinstance(a, np.ndarray) else np.full(size, a)
            total = self._checked(total + self._of_ids(ids))
        return total

    def _of_ids(self, ids):
        """The pattern of numbers, one row for each."""
        program = self.program
        rows, nodes = self.program.parts(ids)
        owners = program.owners(ids)
        at = np.empty(ids.size, int)
        patterns = []
        begin = 0
        for first in (*[row.first for row in rows], *nodes):
            here = owners == program.owners(np.array([first]))
            at[here] = begin + ids[here] - first
            row = program.row_at(first)
            patterns.append(self._of_node(first) if row is None else self._of(row))
            begin += patterns[-1].shape[0]
        found = self._sparse.vstack(patterns, "csr")
        if np.diff(found.indptr)[at].sum() > MOST_A_ROW * max(ids.size, self.n):
            raise Dense
        return found[at]

    def _of_node(self, i):
        """The pattern of a single node."""
        if i not in self._nodes:
            total = self._sparse.csr_matrix((1, self.n), dtype=np.int32)
            for node in live([self.program.node(i)]):
                at = node.data if node.op == "item" else node.key
                row = self.program.row_at(at) if node.op in ("y", "item") else None
                if row is not None:
                    total = self._checked(total + self._of(row)[at - row.first])
            self._nodes[i] = total
        return self._nodes[i]


def timed_nodes(program):
    """The nodes of numbers that meet the state, single ones and numbers of rows.

    Beyond MOST_TIMED numbers, there are none for the rows.
    """
    mixed = set()
    timed = set()
    outer, single = program.parts(program.outputs)
    wanted = {id(x): x for x in (*outer, *map(program.node, single))}
    for each in (*program.nodes, *program.order):
        below = program.below[each.first] if isinstance(each, Row) else each.args
        if each.op == "item":
            below = [program.row_at(each.data)]
        by_time = each.op == "t" or any(id(x) in timed for x in below)
        unknown = by_time and each.op != "t" and each.op not in OPERATIONS
        if unknown or each.op in OF_STATE or any(id(x) in mixed for x in below):
            mixed.add(id(each))
            wanted.update((id(x), x) for x in below)
        elif by_time:
            timed.add(id(each))
    found = [x for x in wanted.values() if isinstance(x, Row) and id(x) in timed]
    results = [x for x in wanted.values() if not isinstance(x, Row)]
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
        k = i - row.first
        g = program.g
        if row.op == "par":
            known[i] = g.make("par", (), row.data.start + k)
        elif row.op == "const":
            known[i] = g.const(row.data.reshape(-1)[k])
        else:
            below = [int(a[k]) if isinstance(a, np.ndarray) else a for a in row.args]
            known[i] = g.make(row.op, [_node(program, a, known) for a in below], row.data)
    return known[i]
