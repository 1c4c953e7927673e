"""Products of arrays that hold symbols."""

from typing import Any

import numpy as np

from ..islands import or_apart
from ..symbols.arrays import Array
from ..symbols.complex_pair import is_complex, product, total
from ..symbols.conditions import Condition
from ..symbols.symbolic import BATCHES, NOW, check_operations, in_batches, is_symbolic, refuse

FEW = 4096  # largest matrix that is written out without a check


def matmul(a, b, dot=False) -> Any:
    """``a @ b``, or ``np.dot(a, b)``; a product that is too large to write out is an island."""
    if in_batches((a, b)):
        return BATCHES["matmul"](NOW.table, a, b)
    return or_apart(np.dot if dot else np.matmul, lambda a, b: _written_out(a, b, dot))(a, b)


def _written_out(a, b, dot=False):
    a, b = (x if isinstance(x, np.ndarray) else np.array(x, dtype=object) for x in (a, b))
    if dot and (a.ndim == 0 or b.ndim == 0):
        return a * b
    _check(a, b)
    a, b = (np.asarray(x, dtype=object).view(np.ndarray) for x in (a, b))
    if all(isinstance(v, Condition | bool) for x in (a, b) for v in x.flat):
        refuse("a product of arrays of truth values")  # such a product is a truth value, not a sum
    if a.ndim > 2 or b.ndim > 2:
        return _stacked(a, b, dot)
    rows = a.reshape(1, -1) if a.ndim == 1 else a
    columns = b.reshape(-1, 1) if b.ndim == 1 else b
    if rows.shape[1] != columns.shape[0]:
        raise ValueError(f"shapes {a.shape} and {b.shape} do not match in a product")
    result = np.empty((len(rows), columns.shape[1]), dtype=object)
    for i, row in enumerate(rows.tolist()):
        for j, column in enumerate(columns.T.tolist()):
            result[i, j] = total(map(product, row, column))
    result = result.view(Array)
    if a.ndim == 1:
        result = result[0]
    return result[..., 0] if b.ndim == 1 else result


def _check(a, b):
    """Refuse a product of a matrix that is too large to write out."""
    if a.size > FEW and a.ndim == 2 and b.ndim and is_symbolic([a, b]):
        plain = np.array([type(v) in (int, float) for v in a.flat]) if a.dtype == object else None
        terms = np.count_nonzero(a if plain is None else a.reshape(-1)[plain])
        others = 0 if plain is None else a.size - np.count_nonzero(plain)
        each = 8 if any(is_complex(v) for x in (a, b) for v in (x.flat[0], x.flat[-1])) else 2
        check_operations(each * (terms + others) * (b.size // max(1, b.shape[0])))


def _stacked(a, b, dot):
    if dot and a.ndim > 1 and b.ndim > 1:
        refuse("np.dot in more than two dimensions")
    if b.ndim == 1:
        return _written_out(a, b[:, None])[..., 0]
    if a.ndim == 1:
        return _written_out(a[None, :], b)[..., 0, :]
    lead = np.broadcast_shapes(a.shape[:-2], b.shape[:-2])
    a, b = (np.broadcast_to(x, lead + x.shape[-2:]) for x in (a, b))
    result = np.empty((*lead, a.shape[-2], b.shape[-1]), dtype=object)
    for i in np.ndindex(lead):
        result[i] = _written_out(a[i], b[i])
    return result.view(Array)
