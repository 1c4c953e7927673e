"""Square matrices whose size is known at run time only: factors P A = L U, and solutions.

Matrices are stored by columns: ``a[j * ld + i]`` is the element in row i and column j, so that
all loops run along the memory.  Pivots are LAPACK's: the largest element of a column;
``pivots[k]`` is the row exchanged with row k.  For a singular matrix, U has a zero on its diagonal,
and solutions are infinite or NaN.

Matrices may be banded: `lower` and `upper` are the numbers of diagonals below and above the main
diagonal, n - 1 for a full matrix.  The exchanges widen the band by `lower` diagonals above.
Elements outside of the widened band are neither read nor written: with ``ld = 2 lower + upper``,
columns overlap only outside of the band, and the storage is LAPACK's for band matrices.  A
factorisation takes n lower (lower + upper) operations.
"""

from ..jit.options import INTERNAL, njit
from ..state.rows import after

LONG = 8  # from this length on, two slices speed up a loop over a column


@njit(**INTERNAL)
def bandwidths(a, n):
    """The numbers of nonzero diagonals below and above the main diagonal, for ld = n."""
    lower = upper = 0
    for j in range(n):
        for i in range(n):
            if a[j * n + i] != 0.0:
                lower, upper = max(lower, i - j), max(upper, j - i)
    return lower, upper


@njit(**INTERNAL)
def _subtract(y, x, count, factor):
    for i in range(count):
        y[i] -= factor * x[i]


@njit(**INTERNAL)
def add_matrix_product(a, ld, x, out, n, lower, upper):
    """out += A x, for a matrix that is not factorised."""
    for j in range(n):
        first, end = max(0, j - upper), min(n, j + 1 + lower)
        _subtract(after(out, first), after(a, j * ld + first), end - first, -x[j])


@njit(**INTERNAL)
def factorise(a, ld, pivots, n, lower, upper):
    """Replace a matrix by L and U, with the reciprocals of the diagonal of U."""
    for k in range(n):
        end, last, column = min(n, k + 1 + lower), min(n, k + 1 + lower + upper), after(a, k * ld)
        p, largest = k, abs(column[k])
        for i in range(k + 1, end):
            if abs(column[i]) > largest:
                p, largest = i, abs(column[i])
        pivots[k] = p
        if p != k:
            for j in range(k, last):
                other = after(a, j * ld)
                other[k], other[p] = other[p], other[k]
        scale = column[k] = 1.0 / column[k]
        for i in range(k + 1, end):
            column[i] *= scale
        for j in range(k + 1, last):
            other = after(a, j * ld)
            x = other[k]
            if x == 0.0:
                continue
            if end - k > LONG:
                _subtract(after(other, k + 1), after(column, k + 1), end - k - 1, x)
            else:
                for i in range(k + 1, end):
                    other[i] -= x * column[i]


@njit(**INTERNAL)
def solve(a, ld, pivots, b, n, lower, upper):
    """Replace b by x, with A x = b; `a` has the factors from `factorise`."""
    for k in range(n):
        p, end, column = int(pivots[k]), min(n, k + 1 + lower), after(a, k * ld)
        x = b[p]
        b[p], b[k] = b[k], x
        if end - k > LONG:
            _subtract(after(b, k + 1), after(column, k + 1), end - k - 1, x)
        else:
            for i in range(k + 1, end):
                b[i] -= x * column[i]
    for k in range(n - 1, -1, -1):
        first, column = max(0, k - lower - upper), after(a, k * ld)
        x = b[k] * column[k]
        b[k] = x
        if k - first > LONG:
            _subtract(after(b, first), after(column, first), k - first, x)
        else:
            for i in range(first, k):
                b[i] -= x * column[i]


@njit(**INTERNAL)
def solve_transposed(a, ld, pivots, b, n, lower, upper):
    """Replace b by x, with x A = b; `a` has the factors from `factorise`."""
    for k in range(n):
        first, column, x = max(0, k - lower - upper), after(a, k * ld), b[k]
        for i in range(first, k):
            x -= column[i] * b[i]
        b[k] = x * column[k]
    for k in range(n - 1, -1, -1):
        p, end, column, x = int(pivots[k]), min(n, k + 1 + lower), after(a, k * ld), b[k]
        for i in range(k + 1, end):
            x -= column[i] * b[i]
        b[k] = b[p]
        b[p] = x
