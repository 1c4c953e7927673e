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
WIDE = 8  # of four columns at a time, which need as many diagonals
WIDE_FORM = Form(1, WIDE, exact=True)


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
    end = 0  # of the columns that have elements above row k: the exchanges alone widen the band
    for k in range(n):
        below = min(n - k, 1 + lower)
        column = after(a, k * ld + k)  # from the diagonal on, so that no index needs a test for < 0
        largest = 0.0
        for i in range(1, below):
            size = abs(column[i])
            largest = size if size > largest else largest
        p = 0
        if largest > abs(column[0]):
            while abs(column[p]) != largest:
                p += 1
        pivots[k] = k + p
        end = max(end, min(n, k + p + upper + 1))
        right = end - k
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
def _less_four(y, a, ld, count, p, q, r, s):
    """y -= p a, and so on with q, r and s and the next three columns, with the roundings of each.

    Each number of y is loaded and stored once: solutions with 9 to 64 lower diagonals take 0.5 to
    0.65 of the time.
    """
    b = after(a, ld)
    c = after(b, ld)
    d = after(c, ld)
    few = count & (WIDE - 1)
    for i in range(few):
        y[i] = y[i] - p * a[i] - q * b[i] - r * c[i] - s * d[i]
    for i in range(few, count, WIDE):
        x = vector_at(WIDE_FORM, y, i) - p * vector_at(WIDE_FORM, a, i)
        x = x - q * vector_at(WIDE_FORM, b, i) - r * vector_at(WIDE_FORM, c, i)
        keep_vector(WIDE_FORM, y, i, x - s * vector_at(WIDE_FORM, d, i))


@njit(**INTERNAL)
def _down_four(y, a, ld, left, lower):
    """Solve with four columns of L, whose first element on the diagonal is that of `a` and y."""
    b = after(a, ld)
    c = after(b, ld)
    d = after(c, ld)
    p = y[0]
    y[1] = q = y[1] - a[1] * p
    y[2] = r = y[2] - a[2] * p - b[2] * q
    y[3] = s = y[3] - a[3] * p - b[3] * q - c[3] * r
    end = min(left, lower + 1)  # of the first column; the others end one row further each
    _less_four(after(y, 4), after(a, 4), ld, end - 4, p, q, r, s)
    if left > end:
        y[end] = y[end] - b[end] * q - c[end] * r - d[end] * s
    if left > end + 1:
        y[end + 1] = y[end + 1] - c[end + 1] * r - d[end + 1] * s
    if left > end + 2:
        y[end + 2] -= d[end + 2] * s


@njit(**INTERNAL)
def _up_four(y, a, ld, k, first):
    """Solve with column k of U, which is `a` and begins at row `first`, and the three before."""
    b = after(a, -ld)
    c = after(b, -ld)
    d = after(c, -ld)
    y[k] = p = y[k] * a[k]
    y[k - 1] = q = (y[k - 1] - a[k - 1] * p) * b[k - 1]
    y[k - 2] = r = (y[k - 2] - a[k - 2] * p - b[k - 2] * q) * c[k - 2]
    y[k - 3] = s = (y[k - 3] - a[k - 3] * p - b[k - 3] * q - c[k - 3] * r) * d[k - 3]
    _less_four(after(y, first), after(a, first), -ld, k - 3 - first, p, q, r, s)
    if first > 0:
        y[first - 1] = y[first - 1] - b[first - 1] * q - c[first - 1] * r - d[first - 1] * s
    if first > 1:
        y[first - 2] = y[first - 2] - c[first - 2] * r - d[first - 2] * s
    if first > 2:
        y[first - 3] -= d[first - 3] * s


@njit(**INTERNAL)
def _in_place(pivots, k):
    """Whether no row is exchanged with row k or one of the next three."""
    here = pivots[k] == k and pivots[k + 1] == k + 1
    return here and pivots[k + 2] == k + 2 and pivots[k + 3] == k + 3


@njit(**INTERNAL)
def solve(a, ld, pivots, b, n, lower, upper):
    """Replace b by x, with A x = b; `a` has the factors from `factorise`."""
    k = 0
    above = upper  # diagonals of U that are not zero: exchanges alone widen the band
    while k < n:
        if lower >= WIDE and k + 4 <= n and _in_place(pivots, k):
            _down_four(after(b, k), after(a, k * ld + k), ld, n - k, lower)
            k += 4
            continue
        p = int(pivots[k])
        above = above if p == k else lower + upper
        x = b[p]
        b[p] = b[k]
        b[k] = x
        _subtract(after(b, k + 1), after(a, k * ld + k + 1), min(n - k - 1, lower), x)
        k += 1
    k = n - 1
    while k >= 0:
        first = max(0, k - above)
        column = after(a, k * ld)
        if above >= WIDE and k >= 3:
            _up_four(b, column, ld, k, first)
            k -= 4
            continue
        x = b[k] * column[k]
        b[k] = x
        _subtract(after(b, first), after(column, first), k - first, x)
        k -= 1


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
