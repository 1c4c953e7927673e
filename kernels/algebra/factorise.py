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
from ..state.layout import Form
from ..state.rows import after, keep_vector, vector_at

WIDTH = 4
FORM = Form(1, WIDTH, exact=True)  # not fused: vectors have the bits of numbers


@njit(**INTERNAL)
def bandwidths(a, n):
    """The numbers of nonzero diagonals below and above the main diagonal, for ld = n."""
    lower = upper = 0
    for j in range(n):
        for i in range(n):
            if a[j * n + i] != 0.0:
                lower = max(lower, i - j)
                upper = max(upper, j - i)
    return lower, upper


@njit(**INTERNAL)
def _subtract(y, x, count, factor):
    """y -= factor x, with vectors that end at the last number.

    All steps of an elimination end at the same row, so that vectors are read as they were written.
    """
    few = count & (WIDTH - 1)
    for i in range(few):
        y[i] -= factor * x[i]
    for i in range(few, count, WIDTH):
        keep_vector(FORM, y, i, vector_at(FORM, y, i) - factor * vector_at(FORM, x, i))


@njit(**INTERNAL)
def add_matrix_product(a, ld, x, out, n, lower, upper):
    """out += A x, for a matrix that is not factorised."""
    for j in range(n):
        first = max(0, j - upper)
        end = min(n, j + 1 + lower)
        _subtract(after(out, first), after(a, j * ld + first), end - first, -x[j])


@njit(**INTERNAL)
def exchange(column, p, ld, count):
    """Exchange row 0 and row p of a column and of the columns to the right, `count` in all."""
    for j in range(count):
        x = after(column, j * ld)
        y = after(x, p)
        x[0], y[0] = y[0], x[0]


@njit(**INTERNAL)
def factorise(a, ld, pivots, n, lower, upper):
    """Replace a matrix by L and U, with the reciprocals of the diagonal of U."""
    for k in range(n):
        below = min(n - k, 1 + lower)
        right = min(n - k, 1 + lower + upper)
        column = after(a, k * ld + k)  # from the diagonal on, so that no index needs a test for < 0
        p = 0
        largest = abs(column[0])
        for i in range(1, below):
            if abs(column[i]) > largest:
                p = i
                largest = abs(column[i])
        pivots[k] = k + p
        if p != 0:
            exchange(column, p, ld, right)
        scale = column[0] = 1.0 / column[0]
        for i in range(1, below):
            column[i] *= scale
        # Two columns at a time take 0.8 of the time for a full matrix of 32 rows, 1.05 for a band.
        for j in range(1, right):
            other = after(column, j * ld)
            x = other[0]
            if x != 0.0:
                _subtract(after(other, 1), after(column, 1), below - 1, x)


@njit(**INTERNAL)
def solve(a, ld, pivots, b, n, lower, upper):
    """Replace b by x, with A x = b; `a` has the factors from `factorise`."""
    for k in range(n):
        p = int(pivots[k])
        x = b[p]
        b[p] = b[k]
        b[k] = x
        _subtract(after(b, k + 1), after(a, k * ld + k + 1), min(n - k - 1, lower), x)
    for k in range(n - 1, -1, -1):
        first = max(0, k - lower - upper)
        column = after(a, k * ld)
        x = b[k] * column[k]
        b[k] = x
        _subtract(after(b, first), after(column, first), k - first, x)


@njit(**INTERNAL)
def solve_transposed(a, ld, pivots, b, n, lower, upper):
    """Replace b by x, with x A = b; `a` has the factors from `factorise`."""
    for k in range(n):
        first = max(0, k - lower - upper)
        column = after(a, k * ld)
        x = b[k]
        for i in range(first, k):
            x -= column[i] * b[i]
        b[k] = x * column[k]
    for k in range(n - 1, -1, -1):
        p = int(pivots[k])
        end = min(n, k + 1 + lower)
        column = after(a, k * ld)
        x = b[k]
        for i in range(k + 1, end):
            x -= column[i] * b[i]
        b[k] = b[p]
        b[p] = x
