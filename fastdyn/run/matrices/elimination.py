"""Factors of sparse matrices of one pattern: the order and the pattern of L U are found once."""

import numpy as np

from fastdyn.code_store.call import Call
from fastdyn.specialise.scalar import sparse_kernels

# Numbers in a column of L, above which SuperLU's dense blocks are faster.  Squares of 800, 5000,
# 9800 and 20 000 components have 14, 24, 28 and 32; their factors take 0.2, 0.38, 0.68 and 1.2 of
# SuperLU's time, complex ones 0.4, 0.3 and less.
MOST = 29


class Elimination:
    """L U of matrices of one pattern, in an order that depends on the pattern alone.

    So a run that another process resumes has the same bits.  The order is SuperLU's minimum degree
    of A + A'; L has the pattern of Cholesky's factor of A + A', and U that of its transpose.

    Parameters
    ----------
    n : int
    begins, rows : ndarray of int
        The pattern by columns, with the whole diagonal.

    Attributes
    ----------
    pays : bool
        False if L has so many numbers that SuperLU is faster.
    """

    def __init__(self, n, begins, rows):
        columns = np.repeat(np.arange(n), np.diff(begins))
        place = _order(n, columns, rows)
        columns = place[columns]
        rows = place[rows]
        diagonal = np.arange(n)
        below = _pattern_of_l(n, columns, rows)
        self.pays = below is not None
        if below is not None:
            at = np.lexsort((rows, columns))
            factor = np.repeat(diagonal, [*map(len, below)])
            own = np.concatenate(below).astype(np.int64)
            self._pattern = *_by_columns(n, columns, rows), at
            self._factors = (
                *_by_columns(n, factor, own),
                *_by_columns(n, np.r_[own, diagonal], np.r_[factor, diagonal]),
            )
            self._order = np.argsort(place)

    def factorised(self, numbers):
        """``solve(b)``, which solves in place; None if a number on the diagonal is no pivot."""
        kind = numbers.dtype
        lower, upper = (np.empty(len(each), kind) for each in self._factors[1::2])
        x = np.zeros(len(self._order), kind)
        factors, solution = sparse_kernels[kind.kind]
        given = *self._factors, lower, upper, x
        if not Call(factors(), *self._pattern, numbers, *given)():
            return None
        call = Call(solution(), self._order, *given, x)

        def solve(b):
            call["b"] = b
            call()
            return b

        return solve


def _order(n, columns, rows):
    """The place of each row and column in an order with little fill."""
    from scipy.sparse import csc_matrix
    from scipy.sparse.linalg import splu

    numbers = np.where(columns == rows, float(n), -1.0)  # regular: the diagonal dominates
    matrix = csc_matrix((numbers, (rows, columns)), (n, n))
    return splu(matrix, permc_spec="MMD_AT_PLUS_A").perm_c.astype(np.int64)


def _by_columns(n, columns, rows):
    """(begin of each column, rows in ascending order) of the places of a matrix."""
    at = np.lexsort((rows, columns))
    return np.searchsorted(columns[at], np.arange(n + 1)), rows[at]


def _pattern_of_l(n, columns, rows):
    """The rows of each column of L, below its diagonal; None if they are more than MOST n.

    A column has the rows of its children in the elimination tree, whose first row it is.
    """
    one = np.minimum(columns, rows)
    other = np.maximum(columns, rows)
    begins, found = _by_columns(n, one[one < other], other[one < other])
    waiting = [[] for _ in range(n)]
    below = []
    total = 0
    for k in range(n):
        mine = set(found[begins[k] : begins[k + 1]].tolist()).union(*waiting[k])
        mine.discard(k)
        waiting[k] = []
        below.append(np.fromiter(mine, np.int64, len(mine)))
        total += len(mine)
        if total > MOST * n:
            return None
        if mine:
            waiting[min(mine)].append(mine)
    return below
