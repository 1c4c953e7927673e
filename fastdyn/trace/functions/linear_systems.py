"""np.linalg.solve and np.linalg.det on symbols.

Equations that form a system of their own are solved first: the blocks of a block triangular form.
A block of few products is written out, and its exchanges of rows are selections.  A larger block of
real numbers is factorised by a compiled loop (`kernels/algebra/padded/`), whose factors are one
node of the graph.
"""

from typing import Any

import numpy as np

from ..graph.rows import ID
from ..operations.linear import GENERAL, SCALED, SYMMETRIC
from ..symbols.arithmetic import where
from ..symbols.complexes import product
from ..symbols.lift import joint, symbol
from ..symbols.symbol import Symbol, refuse, wrap
from .algebra import matmul
from .arrays import array_of
from .ufuncs import as_numpy

# Most products of a factorisation that is written out: those of a full matrix of 8 rows.
MOST_PRODUCTS = 168
MOST_ROWS = 64  # of a block in a loop; beyond, LAPACK's blocks of columns are faster


def solution(a, b, transposed=False):
    """np.linalg.solve by Gaussian elimination."""
    a = array_of(a)
    b = array_of(b)
    if not is_plain_square(a) or len(b) != len(a) or b.ids.ndim > 2:
        refuse("np.linalg.solve of several systems, or of shapes that do not match")
    if transposed is not False:
        refuse("a system of equations with a transposed matrix")
    if a.g.known(a.ids if a.kind != "c" else a.ids["real"]) is not None and a.kind != "c":
        return matmul(symbol(a.g, np.linalg.inv(a.g.known(a.ids))), b)
    right = b.reshape(len(a), -1)
    x: Any = [None] * len(a)  # rows of the solution
    nonzero = _nonzero(a)
    for rows, columns in _blocks(nonzero):
        rest = [right[i] for i in rows]
        for k, i in enumerate(rows):
            for j in np.flatnonzero(nonzero[i]).tolist():
                if x[j] is not None:
                    rest[k] = _less(rest[k], product(a[i, j], x[j]))
        for j, found in zip(columns, _of_block(a[np.ix_(rows, columns)], rest), strict=True):
            x[j] = found
    whole = symbol(a.g, x)
    return whole[:, 0] if b.ids.ndim == 1 else whole


def is_plain_square(a):
    return a.ids.ndim == 2 and a.ids.shape[0] == a.ids.shape[1]


def _less(a, b):
    return a if b is None else a - b


def _zero(s):
    return s.kind != "c" and s.node.op == "const" and s.node.data == 0


def _refuse_zero(pivot):
    """Raise LinAlgError where a pivot is zero, as LAPACK does."""
    if pivot.kind != "c":
        g = pivot.g
        g.raises_if(g.map("eq", pivot.ids, g.const(0.0).key), _singular)


def _singular():
    np.linalg.inv(np.zeros((1, 1)))


# -- blocks


def _nonzero(a):
    """Where a matrix may have elements other than the constant zero."""
    if a.kind == "c":
        return np.ones(a.ids.shape, bool)
    known = {i: a.g.known(i) for i in np.unique(a.ids).tolist()}
    return np.array([[known[i] != 0.0 for i in row] for row in a.ids.tolist()], bool)


def _blocks(nonzero):
    """The (rows, columns) of a block triangular form, in the order of their solution.

    A. Pothen and C.-J. Fan, "Computing the block triangular form of a sparse matrix", ACM Trans.
    Math. Softw. 16 (1990) 303-324: the strong components behind a perfect matching.
    """
    n = len(nonzero)
    column = _matching(nonzero)
    if column is None:  # the matrix is singular
        return [(list(range(n)), list(range(n)))]
    reach = nonzero[:, column] | np.eye(n, dtype=bool)
    while (further := reach @ reach).sum() > reach.sum():
        reach = further
    found, first = [], (reach & reach.T).argmax(1)  # the first row of each row's component
    for i in sorted(set(first.tolist()), key=lambda i: (reach[i].sum(), i)):
        rows = np.flatnonzero(first == i)
        found.append((rows.tolist(), sorted(column[rows].tolist())))
    return found


def _matching(nonzero):
    """A column for each row, with an element there, the diagonal first; None without one."""
    n = len(nonzero)
    column: Any = [i if nonzero[i, i] else None for i in range(n)]
    for start in [i for i in range(n) if column[i] is None]:
        owner = {j: i for i, j in enumerate(column) if j is not None}
        came = {}
        todo = [start]
        for i in todo:
            new = [j for j in np.flatnonzero(nonzero[i]).tolist() if j not in came]
            came.update((j, i) for j in new)
            todo += [owner[j] for j in new if j in owner]
        free = next((j for j in came if j not in owner), None)
        if free is None:
            return None
        while free is not None:  # back along the path
            i = came[free]
            column[i], free = free, column[i]
    return np.array(column)


def _n_products(nonzero):
    """The products of a factorisation; see `kernels/algebra/elimination_structure.py`."""
    where = nonzero.copy()
    count = 0
    for k in range(len(where)):
        rows = k + np.flatnonzero(where[k:, k])
        where[rows] = where[rows].any(0)  # each of them may become row k
        count += max(len(rows) - 1, 0) * int(where[rows[:1], k:].sum())
    return count


# -- the solution of a block


def _of_block(a, rest):
    """The rows of the solution, for rows `rest` of the right-hand sides."""
    if _n_products(_nonzero(a)) > MOST_PRODUCTS:
        if a.kind == "c" or len(a) > MOST_ROWS:
            refuse(f"np.linalg.solve of {len(a)} equations")
        return _in_a_loop(a, rest)
    return _written_out(a, rest)


def _in_a_loop(a, rest):
    right = symbol(a.g, rest)
    if right.kind == "c":
        real, imag = (_in_a_loop(a, list(right.part(k))) for k in (0, 1))
        return [joint(x, y) for x, y in zip(real, imag, strict=True)]
    factors, singular = _factors(a, SYMMETRIC if (a.ids == a.ids.T).all() else GENERAL)
    a.g.raises_if(singular, _singular)
    return list(_solved(factors, a.g, right))


def scaled_solution(a, b):
    """The solution of up to MOST_ROWS equations, and whether the matrix is regular.

    A loop, with scaled pivots and the test of `kernels/algebra/linear.py`.
    """
    if len(a) > MOST_ROWS:
        refuse(f"{len(a)} linear equations")
    factors, singular = _factors(a, SCALED)
    found = _solved(factors, a.g, b.reshape(-1, 1))
    return list(found[:, 0]), wrap(a.g, a.g.negation(singular).key, "b")


def _factors(a, kind):
    """The factors of a matrix, and whether it is singular, as nodes."""
    g = a.g
    ids = a.ids.ravel()
    if ids.size > g.few:  # one operand: the first element of a row in memory
        ids = g.ids(g.row("copy", ids.shape, (ids.copy(),)))[:1]
    factors = g.make("factors", [*map(g.node, ids.tolist())], (len(a), kind))
    return factors, g.make("singular", (factors,), kind)


def _solved(factors, g, right):
    """The solutions for the columns of right-hand sides."""
    columns = []
    for ids in right.ids.T.tolist():
        solved = g.make("solution", [factors, *map(g.node, ids)], False)
        columns.append([g.make("entry", (solved,), i).key for i in range(len(ids))])
    return wrap(g, np.array(columns, ID).T)


def _written_out(a, rest):
    """Elimination number by number; row exchanges are selections."""
    n = len(a)
    rows = [[*row, *more] for row, more in zip(a, rest, strict=True)]
    for k in range(n):
        for i in range(k + 1, n):
            _larger_first(rows, k, i)
        _refuse_zero(rows[k][k])
        for i in range(k + 1, n):
            _eliminate(rows, k, i)
    x: list[Any] = [None] * n
    for i in reversed(range(n)):
        x[i] = []
        for c, value in enumerate(rows[i][n:]):
            for j in range(i + 1, n):
                value = _less(value, product(rows[i][j], x[j][c]))
            x[i].append(value / rows[i][i])
    return [symbol(a.g, each) for each in x]


def _larger_first(rows, k, i):
    """Exchange rows k and i where row i has the larger pivot."""
    pivot = rows[k][k]
    other = rows[i][k]
    if _zero(other):
        return
    if _zero(pivot):
        rows[k], rows[i] = rows[i], rows[k]
        return
    exchanged = abs(other) > abs(pivot)
    if type(exchanged) is not Symbol:
        if exchanged:
            rows[k], rows[i] = rows[i], rows[k]
        return
    for j in range(k, len(rows[0])):
        a = rows[k][j]
        b = rows[i][j]
        rows[k][j], rows[i][j] = where(exchanged, b, a), where(exchanged, a, b)


def _eliminate(rows, k, i):
    if _zero(rows[i][k]):
        return
    factor = rows[i][k] / rows[k][k]
    rows[i][k] = symbol(factor.g, 0.0)
    for j in range(k + 1, len(rows[0])):
        rows[i][j] = _less(rows[i][j], product(factor, rows[k][j]))


def determinant(a):
    """np.linalg.det, expanded along the first row; refuses more than six rows."""
    a = array_of(a)
    if not is_plain_square(a):
        refuse("several determinants")
    if len(a) > 6:
        refuse("the determinant of a large matrix")
    if len(a) == 1:
        return a[0, 0]
    result: Any = 0.0
    for j in range(len(a)):
        if a.kind == "c" or not _zero(a[0, j]):
            minor = a.view_of(np.delete(np.delete(a.ids, 0, 0), j, 1))
            result = result + (-1.0) ** j * a[0, j] * determinant(minor)
    return as_numpy(symbol(a.g, result))


FUNCTIONS: dict[Any, Any] = {
    np.linalg.solve: solution, np.linalg.det: determinant,
    np.linalg.inv: lambda a: solution(a, np.eye(len(a))),
}  # fmt: skip
