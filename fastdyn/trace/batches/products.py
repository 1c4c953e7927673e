"""Matrix products, einsum, sparse products, running sums and calls of libraries."""

from itertools import product as all_of
from typing import Any

import numpy as np

from ..symbols.complex_pair import any_complex
from ..symbols.symbolic import BATCHES, Batched, refuse
from .columns import Columns, ids_and_kind, ids_of, joint
from .formulas import as_columns, operand_of
from .reductions import reduce
from .table import ID

MOST_PRODUCTS = 20_000_000  # elements of a product before the sum


def running_sum(table, x):
    """The cumulative sum of a one-dimensional array."""
    if x.kind == "c":
        return joint(*(running_sum(table, part) for part in x.parts()))
    made = table.make("running", ("running",), x.shape, [whole(table, x)])
    return Columns(table, None, made)


def matmul(table, a: Any, b: Any) -> Any:
    """``a @ b``; a constant matrix times a vector is one batch."""
    both: Any = [v if isinstance(v, Batched | np.ndarray) else np.array(v) for v in (a, b)]
    a, b = both
    if a.ndim == 0 or b.ndim == 0:
        return a * b
    if all(v.dtype == bool for v in both):
        refuse("a product of arrays of truth values")  # such a product is a truth value, not a sum
    if any(map(any_complex, both)):
        if a.ndim == b.ndim == 2:
            both = [side_by_side(v) if isinstance(v, Batched) else v for v in both]
        return _by_parts(table, matmul, both)
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
    if any(map(any_complex, operands)):
        return _by_parts(table, lambda _, *parts: einsum(table, subscripts, *parts), operands)
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
    """Whether a matrix is no long array: it is made of constants, or of parameters."""
    return not isinstance(matrix, Batched)


def _by_matrix(table, matrix, x):
    """Multiply a matrix by a vector; one batch if one array of parameters holds the matrix."""
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
    if matrix.dtype.kind == "c":
        return sparse(table, matrix.real, x) + 1j * sparse(table, matrix.imag, x)
    x = as_columns(table, x)
    if x.kind == "c":
        return joint(*(sparse(table, matrix, part) for part in x.parts()))
    if x.ndim == 2 and x.shape[1] == 1:
        return sparse(table, matrix, x.reshape(-1)).reshape(-1, 1)
    if x.ndim != 1:
        refuse("a sparse matrix times a matrix that depends on the state")
    if x.size != matrix.shape[1]:
        raise ValueError(f"shapes {matrix.shape} and {x.shape} do not match in a product")
    reads = table.g.reads
    parts = [reads.held(part.astype(float)) for part in (matrix.indptr, matrix.indices)]
    values = reads.held(matrix.data.astype(float)) if matrix.nnz else range(0)
    if not matrix.nnz:
        return Columns(table, np.full(matrix.shape[0], table.one(table.g.const(0.0)), np.int32))
    data = "csr", matrix.shape[0], *parts, values
    made = table.make("csr", data, (matrix.shape[0],), [whole(table, x)])
    return Columns(table, None, made)


def whole(table, x):
    """The number of a batch that equals an array; a new batch "copy" if there is none."""
    x = as_columns(table, x)
    operand = operand_of(x, x.shape)
    if isinstance(operand, int):
        return operand
    return table.make("copy", None, x.shape, [operand]).number


def island(table, parts, data):
    """Call an island with `parts`, numbers and arrays; return all outputs as one array.

    `data` is (slot of the island's address, number of inputs, number of outputs).  The number of
    outputs does not count the last output, which is the failure flag.
    """
    found = [ids_and_kind(table, part) for part in parts]
    if any(kind == "b" for _, kind in found):
        refuse("truth values are given to a library")
    ids = np.concatenate([np.ravel(i) for i, _ in found]).astype(ID)
    given = whole(table, Columns(table, ids))
    return Columns(table, None, table.make("island", ("island", *data), (data[2] + 1,), [given]))


def _by_parts(table, function, arrays):
    """Apply a multilinear function to complex arrays, by their real and imaginary parts."""
    real, imag = None, None
    for chosen in all_of((0, 1), repeat=len(arrays)):
        terms = [_parts(table, a)[i] for a, i in zip(arrays, chosen, strict=True)]
        if any(term is None for term in terms):
            continue
        value = function(table, *terms)
        if sum(chosen) >= 2:
            value = -value
        if sum(chosen) % 2:
            imag = value if imag is None else imag + value
        else:
            real = value if real is None else real + value
    if real is None or imag is None:
        found: Any = imag if real is None else real
        zero = np.zeros_like(found) if isinstance(found, Batched) else 0.0
        real, imag = (zero, found) if real is None else (found, zero)
    return joint(real, imag)


def _parts(table, value):
    """(real part, imaginary part) of an array; None in place of a part that is zero."""
    if isinstance(value, np.ndarray) and not isinstance(value, Batched) and value.dtype != object:
        both = [np.ascontiguousarray(part) for part in (value.real, value.imag)]
        return [part if part.any() else None for part in both]
    return *as_columns(table, value).parts(), None


def side_by_side(array) -> Any:
    """Copy an array to contiguous memory."""
    table = array.table
    if array.kind == "c":
        return joint(*map(side_by_side, array.parts()))
    operand = whole(table, array)
    if table.batches[operand].op != "copy":
        operand = table.make("copy", None, array.shape, [operand]).number
    return Columns(table, None, table.batches[operand])


BATCHES.update(island=island, sparse=sparse, joint=joint, matmul=matmul)
BATCHES["side by side"] = side_by_side
