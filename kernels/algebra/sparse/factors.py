"""L U of a sparse matrix, real or complex, by columns, in a fixed order, with diagonal pivots.

The pattern of L and U is known, so that no search and no memory is needed: each column is
scattered into a row of zeros, reduced by the columns of L that its U names, and gathered.  J. R.
Gilbert and T. Peierls, "Sparse partial pivoting in time proportional to arithmetic operations",
SIAM J. Sci. Stat. Comput. 9(5), 1988; with the pattern kept, as the refactorisation of KLU does: T.
A. Davis and E. Palamadai Natarajan, "Algorithm 907: KLU", ACM Trans. Math. Softw. 37(3), 2010.
"""

from typing import Any, NamedTuple

from ...jit.options import INTERNAL, njit

# The largest element of L.  KLU takes the diagonal if this is at most 1000 times as small as the
# largest element of its column; with partial pivoting, no element is above 1.
LARGEST = 100.0


class SparsePattern(NamedTuple):
    """A matrix by columns: column k has the rows ``rows[begins[k]:begins[k + 1]]``.

    The elements lie at `places` among the numbers of the matrix.
    """

    begins: Any
    rows: Any
    places: Any


class SparseFactors(NamedTuple):
    """L without its diagonal of ones, and U, by columns, whose rows ascend.

    So the diagonal of U comes last in each column.
    """

    l_begins: Any
    l_rows: Any
    u_begins: Any
    u_rows: Any
    lower: Any
    upper: Any


@njit(**INTERNAL)
def _size(x):
    """The absolute value, or, of a complex number, the sum of those of its parts."""
    return abs(x.real) + abs(x.imag)


@njit(**INTERNAL)
def _four_alike(f, j):
    """Whether the columns of L from j to j + 3 have the same rows below j + 3."""
    first = f.l_begins[j]
    count = f.l_begins[j + 1] - first
    if count < 4 or f.l_rows[first + 2] != j + 3:  # the rows ascend: they begin j + 1, j + 2, j + 3
        return False
    return f.l_begins[j + 4] - f.l_begins[j + 3] == count - 3  # a column's rows are in the next


@njit(**INTERNAL)
def _less_four(f, x, p):
    """Reduce x by the four columns of L from row p of U on, with the roundings of one by one.

    Each number of x is loaded and stored once: squares and networks of 800 to 5000 components take
    0.6 to 0.85 of the time.
    """
    j = f.u_rows[p]
    a = f.l_begins[j]
    b = f.l_begins[j + 1]
    c = f.l_begins[j + 2]
    d = f.l_begins[j + 3]
    f.upper[p] = w0 = x[j]
    f.upper[p + 1] = w1 = x[j + 1] - f.lower[a] * w0
    f.upper[p + 2] = w2 = x[j + 2] - f.lower[a + 1] * w0 - f.lower[b] * w1
    w3 = x[j + 3] - f.lower[a + 2] * w0 - f.lower[b + 1] * w1 - f.lower[c] * w2
    f.upper[p + 3] = w3
    for k in range(j, j + 4):
        x[k] = 0.0
    for q in range(f.l_begins[j + 4] - d):
        total = x[f.l_rows[d + q]] - f.lower[a + 3 + q] * w0 - f.lower[b + 2 + q] * w1
        x[f.l_rows[d + q]] = total - f.lower[c + 1 + q] * w2 - f.lower[d + q] * w3


@njit(**INTERNAL)
def factors(pattern, numbers, f, x):
    """Fill the numbers of the factors; 0 if a pivot is too small for its column, else 1.

    `x` has n zeros, before and behind.
    """
    for k in range(len(x)):
        for p in range(pattern.begins[k], pattern.begins[k + 1]):
            x[pattern.rows[p]] = numbers[pattern.places[p]]
        last = f.u_begins[k + 1] - 1
        most = 0.0
        p = f.u_begins[k]
        while p < last:
            j = f.u_rows[p]
            if p + 3 < last and _four_alike(f, j):
                _less_four(f, x, p)
                p += 4
                continue
            f.upper[p] = weight = x[j]
            x[j] = 0.0
            for q in range(f.l_begins[j], f.l_begins[j + 1]):
                x[f.l_rows[q]] -= f.lower[q] * weight
            p += 1
        f.upper[last] = pivot = x[k]
        x[k] = 0.0
        for q in range(f.l_begins[k], f.l_begins[k + 1]):
            f.lower[q] = x[f.l_rows[q]] / pivot
            x[f.l_rows[q]] = 0.0
            size = _size(f.lower[q])
            if not size <= most:  # also for NaN
                most = size
        if not (_size(pivot) > 0.0 and most <= LARGEST):
            return 0
    return 1


@njit(**INTERNAL)
def solution(order, f, x, b):
    """Replace b by the solution; `order` has the component of each row.  `x` has n zeros."""
    n = len(x)
    for k in range(n):
        x[k] = b[order[k]]
    for k in range(n):
        weight = x[k]
        for q in range(f.l_begins[k], f.l_begins[k + 1]):
            x[f.l_rows[q]] -= f.lower[q] * weight
    for k in range(n - 1, -1, -1):
        last = f.u_begins[k + 1] - 1
        weight = x[k] / f.upper[last]
        for p in range(f.u_begins[k], last):
            x[f.u_rows[p]] -= f.upper[p] * weight
        b[order[k]] = weight
        x[k] = 0.0
    return 1
