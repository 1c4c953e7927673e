"""Finds the components that each result depends on, from the loops of a plan."""

from typing import Any

import numpy as np

from .boxes import boxes_of, formula_of_one, grid_of, name_of
from .table import PRODUCTS

MOST_A_ROW = 200  # up to this mean number of elements a row, a matrix counts as sparse


class Dense(Exception):
    """The matrix has too many nonzero elements to be stored as sparse."""


class Sparsity:
    """The sparsity patterns of a plan's results and kept batches, as matrices of ones.

    The loops are visited in the order in which they run.
    """

    def __init__(self, plan, n, nodes):
        from scipy import sparse

        self._sparse: Any = sparse
        self.plan, self.n, self.nodes, self._kept = plan, n, nodes, {}
        self._n_results = len(plan.result) + len(nodes)
        self._items: dict = {}

    def of_results(self):
        """The (rows, columns) of the elements that may be nonzero, sorted by column.

        Raises
        ------
        Dense
        """
        found: list = []
        size = self._n_results
        for group in self.plan.groups:
            if group[0].reduction in PRODUCTS:
                for root in group:
                    self._kept[root.target] = self._of_product(root.batch)
                continue
            alone, alike = boxes_of(self.plan, group)
            parts: dict = {}
            for formula in [*alone, *(f for formulas in alike for f in formulas)]:
                self._of_box(formula, parts)
            for target, pieces in parts.items():
                whole = size if target == "out" else self.plan.table.batches[target].size
                matrix = self._sum(pieces, whole)
                if target == "out":
                    found.append(matrix)
                else:
                    self._kept[target] = matrix
        rows = [np.full(1, i) for i in range(len(self.nodes))]
        pairs = [self._of_node(node, row, size) for node, row in zip(self.nodes, rows, strict=True)]
        found.append(self._sum([pair for pair in pairs if pair is not None], size))
        total = self._sum_of(found, size).tocsc()
        total.sort_indices()
        columns = np.repeat(np.arange(self.n), np.diff(total.indptr))
        return total.indices.astype(np.int64), columns.astype(np.int64)

    def _check(self, count, rows):
        if count > MOST_A_ROW * max(rows, 1):
            raise Dense

    def _ones(self, rows, columns, shape):
        ones = np.ones(len(rows), np.int8)
        return self._sparse.csr_matrix((ones, (rows, columns)), shape)

    def _sum(self, pieces, size):
        """The union of patterns; each pattern is (rows, columns) or a matrix."""
        pairs = [p for p in pieces if isinstance(p, tuple)]
        matrices = [p for p in pieces if not isinstance(p, tuple)]
        if pairs:
            rows, columns = (np.concatenate(each) for each in zip(*pairs, strict=True))
            self._check(len(rows), max(size, self.n))
            matrices.append(self._ones(rows, columns, (size, self.n)))
        return self._sum_of(matrices, size)

    def _sum_of(self, matrices, size):
        total = self._sparse.csr_matrix((size, self.n), dtype=np.int8)
        for matrix in matrices:
            total = total + matrix
            self._check(total.nnz, max(size, self.n))
            total.data[:] = 1
        return total

    def _of_box(self, formula, parts):
        """Add the patterns of a box's stores to `parts`."""
        needs: list = []
        for i, v in enumerate(formula.values):
            own = {i} if v.kind in ("read", "gather", "one") else set()
            needs.append(own.union(*[needs[a] for a in v.args]))
        for store in formula.stores:
            rows = grid_of(store.place, store.steps, formula.shape)
            for i in needs[store.value]:
                piece = self._of_read(formula, formula.values[i], rows, store)
                if piece is not None:
                    parts.setdefault(store.target, []).append(piece)
            parts.setdefault(store.target, [])

    def _of_read(self, formula, v, rows, store):
        if v.kind == "one":
            return self._of_node(v.data, rows, self._size(store))
        if v.kind == "read":
            name, at, strides = v.data
            places = grid_of(at, strides, formula.shape)
        else:
            source, table, at, strides = v.data
            name, places = name_of(source), table[grid_of(at, strides, formula.shape)]
        if name == "y":
            return rows, places
        if name not in self._kept:  # parameters and constants do not depend on the state
            return None
        return self._through(rows, places, store, self._kept[name])

    def _size(self, store):
        if store.target == "out":
            return self._n_results
        return self.plan.table.batches[store.target].size

    def _through(self, rows, places, store, pattern):
        chosen = self._ones(rows, places, (self._size(store), pattern.shape[0]))
        found = chosen.astype(np.int32) @ pattern.astype(np.int32)
        self._check(found.nnz, max(self._size(store), self.n))
        return found.astype(bool).astype(np.int8)

    def _of_node(self, node, rows, size):
        """The pattern of `rows`, which all depend on one node of the graph."""
        columns = np.unique(np.concatenate(
            [self._of_item(i) for i in self.plan.table.items_of(node)] or [np.empty(0, np.int64)]
        ))  # fmt: skip
        if not len(columns):
            return None
        self._check(len(rows) * len(columns), max(size, self.n))
        return np.repeat(rows, len(columns)), np.tile(columns, len(rows))

    def _of_item(self, i):
        batch = self.plan.table.batch_of(i)
        if batch.op == "y":
            return np.array([i])
        if i in self._items:
            return self._items[i]
        if batch.number in self._kept:
            row = self._kept[batch.number][i - batch.first]
            found = row.indices
        else:
            formula = formula_of_one(self.plan, batch, i)
            found = [np.empty(0, np.int64)]
            for v in formula.values:
                if v.kind == "one":
                    found += [self._of_item(j) for j in self.plan.table.items_of(v.data)]
                elif v.kind == "read" and v.data[0] == "y":
                    found.append(np.array([v.data[1]]))
                elif v.kind == "read" and v.data[0] in self._kept:
                    found.append(self._kept[v.data[0]][v.data[1]].indices)
                elif v.kind == "gather":
                    raise Dense
            found = np.unique(np.concatenate(found))
        self._items[i] = found
        return found

    def _of_product(self, batch):
        source = self.plan.table.batches[batch.operands[0]]
        op, *data = batch.data
        if source.op == "y":
            pattern = self._sparse.identity(self.n, dtype=np.int8, format="csr")
        else:
            pattern = self._kept[source.number]
        if op != "csr":
            raise Dense
        rows, *slots = data
        begins, places = (
            np.asarray(self.plan.table.g.values)[s.start : s.stop].astype(np.int64)
            for s in slots[:2]
        )
        ones = np.ones(len(places), np.int32)
        matrix = self._sparse.csr_matrix((ones, places, begins), (rows, pattern.shape[0]))
        found = matrix @ pattern.astype(np.int32)
        self._check(found.nnz, max(rows, self.n))
        return found.astype(bool).astype(np.int8)
