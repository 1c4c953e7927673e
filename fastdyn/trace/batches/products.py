"""Matrix products, einsum, sparse products, running sums and calls of libraries."""

from typing import Any

import numpy as np

from ..reads.table_reads import held
from ..symbols.symbolic import BATCHES, Batched, refuse
from .columns import Columns, ids_and_truth, ids_of
from .formulas import as_columns, operand_of
from .reductions import reduce
from .table import ID

MOST_PRODUCTS = 20_000_000  # elements of a product before the sum


def running_sum(table, x):
    """The cumulative sum of a one-dimensional array."""
    made = table.make("running", ("running",), x.shape, [whole(table, x)])
    return Columns(table, None, made)


def matmul(table, a: Any, b: Any) -> Any:
    """``a @ b``; a constant matrix times a vector is one batch."""
    both: Any = [v if isinstance(v, Batched | np.ndarray) else np.array(v) for v in (a, b)]
    a, b = both
    if a.ndim == 0 or b.ndim == 0:
        return a * b
    if a.shape[-1] != b.shape[-2 if b.ndim > 1 else 0]:
        raise ValueError(f"shapes {a.shape} and {b.shape} do not match in a product")
    if a.ndim == 1 and b.ndim == 1:
        return reduce(table, "sum", np.multiply(a, b))
    if a.ndim == 2 and b.ndim == 1 and _is_plain(a):
        return _by_matrix(table, a, b)
    if a.ndim == 1 and b.ndim == 2 and _is_plain(b):
        return _by_matrix(table, b.T, a)
    if a.ndim > 2 or b.ndim > 2:
        refuse("a product of long arrays of more than two axes")
    terms = a.size * (b.shape[1] if b.ndim == 2 else 1)
    if terms > MOST_PRODUCTS:
        refuse("a product of two large matrices")
    if a.ndim == 2 and b.ndim == 1:
        return reduce(table, "sum", np.multiply(a, b[None, :]), 1)
    if a.ndim == 1:
        return reduce(table, "sum", np.multiply(a[None, :], np.transpose(b)), 1)
    return reduce(table, "sum", np.multiply(a[:, None, :], np.transpose(b)[None, :, :]), 2)


def einsum(table, subscripts, *operands, **_):
    """One product over all indices, summed over the indices that the result lacks."""
    subscripts = subscripts.replace(" ", "")
    left, arrow, right = subscripts.partition("->")
    groups = left.split(",")
    if not arrow:
        right = "".join(sorted(c for c in set(left) - {","} if left.count(c) == 1))
    repeated = any(len(set(group)) < len(group) for group in groups)
    if "." in subscripts or repeated or len(groups) > 3:
        refuse("np.einsum of long arrays in this way")
    if len(groups) == 2 and len(groups[0]) == 2 and groups[0] == right + groups[1]:
        return matmul(table, *operands)
    inner = [c for c in dict.fromkeys("".join(groups)) if c not in right]
    order, size = right + "".join(inner), {}
    for group, a in zip(groups, operands, strict=True):
        size |= dict(zip(group, np.shape(a), strict=True))
    if np.prod([size[c] for c in order], dtype=float) > MOST_PRODUCTS:
        refuse("np.einsum of so much that depends on the state", said=False)
    whole: Any = None
    for group, a in zip(groups, operands, strict=True):
        axes = [group.index(c) for c in order if c in group]
        spread = np.transpose(as_columns(table, a), axes).reshape(
            tuple(size[c] if c in group else 1 for c in order)
        )
        whole = spread if whole is None else whole * spread
    whole = np.broadcast_to(whole, tuple(size[c] for c in order))
    return reduce(table, "sum", whole, tuple(range(len(right), len(order)))) if inner else whole


def _is_plain(matrix):
    """Whether a matrix consists of constants, or of one array's parameters."""
    return not isinstance(matrix, Batched)


def _by_matrix(table, matrix, x):
    """Multiply a matrix, stored in one array of parameters, by a vector."""
    ids = ids_of(table, matrix)
    rows, columns = ids.shape
    batch = table.batch_of(int(ids.flat[0]))
    strides = [int(ids[-1, 0] - ids[0, 0]) // max(1, rows - 1),
               int(ids[0, -1] - ids[0, 0]) // max(1, columns - 1)]  # fmt: skip
    grid = int(ids[0, 0]) + strides[0] * np.arange(rows)[:, None] + strides[1] * np.arange(columns)
    if batch.op != "par" or not np.array_equal(grid, ids):
        return reduce(table, "sum", np.multiply(matrix, x[None, :]), 1)
    at = int(ids[0, 0]) - batch.first
    data = "dense", rows, columns, batch.data, at, *strides
    made = table.make("dense", data, (rows,), [whole(table, x)])
    return Columns(table, None, made)


def sparse(table, matrix, x):
    """Multiply a constant sparse matrix (CSR) by a vector."""
    x = as_columns(table, x)
    if x.ndim == 2 and x.shape[1] == 1:
        return sparse(table, matrix, x.reshape(-1)).reshape(-1, 1)
    if x.ndim != 1:
        refuse("a sparse matrix times a matrix that depends on the state")
    if x.size != matrix.shape[1]:
        raise ValueError(f"shapes {matrix.shape} and {x.shape} do not match in a product")
    reads = table.g.reads
    parts = [held(reads, part.astype(float)) for part in (matrix.indptr, matrix.indices)]
    values = held(reads, matrix.data.astype(float)) if matrix.nnz else range(0)
    if not matrix.nnz:
        return Columns(table, np.full(matrix.shape[0], table.one(table.g.const(0.0)), np.int32))
    data = "csr", matrix.shape[0], *parts, values
    made = table.make("csr", data, (matrix.shape[0],), [whole(table, x)])
    return Columns(table, None, made)


def whole(table, x):
    """The number of the batch that equals an array, or else of a new copy."""
    x = as_columns(table, x)
    operand = operand_of(x, x.shape)
    if isinstance(operand, int):
        return operand
    return table.make("copy", None, x.shape, [operand]).number


def island(table, parts, data):
    """The results of an island for numbers, arrays and single symbols, as one array.

    `data` are the slot of the island's address and the numbers of its inputs and outputs, without
    the last output, the failure flag.
    """
    found = [ids_and_truth(table, part) for part in parts]
    if any(truth for _, truth in found):
        refuse("truth values are given to a library")
    ids = np.concatenate([np.ravel(i) for i, _ in found]).astype(ID)
    given = whole(table, Columns(table, ids))
    return Columns(table, None, table.make("island", ("island", *data), (data[2] + 1,), [given]))


BATCHES["island"] = island
