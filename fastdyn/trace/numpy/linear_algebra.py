"""Linear algebra on arrays that hold symbols, with the elimination written out."""

import numpy as np

from ..symbols.arrays import Array, elementwise
from ..symbols.complex_pair import is_complex, parts, product, total
from ..symbols.conditions import select
from ..symbols.real import symbol
from ..symbols.symbolic import graph_of, is_symbolic, refuse
from .plain_arrays import array_of, lowered
from .products import matmul

MAX_PIVOTED = 10  # largest system whose pivots depend on the state
MAX_COLUMNS = 128


def solution(a, b):
    """np.linalg.solve by Gaussian elimination with partial pivoting."""
    a, b = np.array(a, dtype=object), np.array(b, dtype=object)
    if not is_symbolic(a):
        return matmul(np.linalg.inv(a.astype(float)), b)
    if a.ndim != 2 or a.shape[0] != a.shape[1] or len(b) != len(a):
        refuse("np.linalg.solve of several systems, or of shapes that do not match")
    n = len(a)
    rows = np.concatenate([a, b.reshape(n, -1)], axis=1).tolist()
    for k in range(n):
        for i in range(k + 1, n):
            _larger_first(rows, k, i, n)
        _refuse_zero(rows[k][k])
        for i in range(k + 1, n):
            _eliminate(rows, k, i)
    x = np.empty((n, len(rows[0]) - n), dtype=object)
    for c in range(x.shape[1]):
        for i in reversed(range(n)):
            rest = rows[i][n + c]
            for j in range(i + 1, n):
                rest = rest - product(rows[i][j], x[j, c])
            x[i, c] = rest / rows[i][i]
    x = x.view(Array)
    return x[:, 0] if b.ndim == 1 else x


def _refuse_zero(pivot):
    """Raise LinAlgError where a pivot is zero, as LAPACK does."""
    if is_symbolic(pivot):
        if not is_complex(pivot):
            g, node = pivot.g, pivot.number().node
            g.raises_if(g.compare(node, g.const(0.0), "eq"), _singular)
    elif pivot == 0:
        _singular()


def _singular():
    np.linalg.inv(np.zeros((1, 1)))


def _is_zero(value):
    return not is_symbolic(value) and value == 0


def _larger_first(rows, k, i, n):
    """Exchange rows k and i where row i has the larger pivot."""
    pivot, other = rows[k][k], rows[i][k]
    if _is_zero(other):
        return
    if not is_symbolic([pivot, other]):
        exchanged = abs(other) > abs(pivot)
    elif _is_zero(pivot):
        exchanged = True
    elif n > MAX_PIVOTED:
        refuse(f"np.linalg.solve of {n} equations")
    else:
        g = graph_of(pivot, other)
        exchanged = abs(symbol(g, other)) > abs(symbol(g, pivot))
    if exchanged is False:
        return
    for j in range(k, len(rows[0])):
        a, b = rows[k][j], rows[i][j]
        rows[k][j], rows[i][j] = select(exchanged, b, a), select(exchanged, a, b)


def _eliminate(rows, k, i):
    if _is_zero(rows[i][k]):
        return
    factor = rows[i][k] / rows[k][k]
    rows[i][k] = 0.0
    for j in range(k + 1, len(rows[0])):
        rows[i][j] = rows[i][j] - product(factor, rows[k][j])


def inverse(a):
    """np.linalg.inv."""
    return solution(a, np.eye(len(a)))


def determinant(a):
    """np.linalg.det, expanded along the first row; refuses more than six rows."""
    a = np.array(a, dtype=object)
    if len(a) > 6:
        refuse("the determinant of a large matrix")
    if len(a) == 1:
        return a[0, 0]
    result = 0.0
    for j, top in enumerate(a[0]):
        if not _is_zero(top):
            minor = np.delete(np.delete(a, 0, 0), j, 1)
            result = result + (-1) ** j * top * determinant(minor)
    return result


def norm(x, ord=None, axis=None, keepdims=False):
    """np.linalg.norm for the orders None, 1, 2, inf and "fro"."""
    x = array_of(x)
    of_vectors = x.ndim == 1 if axis is None else np.ndim(axis) == 0
    if ord in (None, "fro") or (ord == 2 and of_vectors):
        squares = elementwise(lambda v: total([p * p for p in parts(v)]), x)
        return np.sqrt(np.add.reduce(squares, axis=axis, keepdims=keepdims))
    if ord == 1 and of_vectors:
        return np.add.reduce(np.abs(x), axis=axis, keepdims=keepdims)
    if ord == np.inf and of_vectors:
        return np.maximum.reduce(np.abs(x), axis=axis, keepdims=keepdims)
    return refuse("this norm")


def linear_in_first(function, a, *args, **kwargs):
    """Apply a function in C, linear in `a`, to an array of symbols, by the function's matrix."""
    a = Array.of(a)
    if a.size > MAX_COLUMNS or is_symbolic([*args, *kwargs.values()]):
        refuse(f"{function.__name__} of so much that depends on the state", final=True)
    args, kwargs = lowered(args), {name: lowered(value) for name, value in kwargs.items()}
    units = np.eye(a.size).reshape(-1, *a.shape)
    columns = [np.asarray(function(e, *args, **kwargs)) for e in units]
    matrix = np.array([column.reshape(-1) for column in columns]).T
    return matmul(matrix.astype(object), a.reshape(-1)).reshape(columns[0].shape)
