"""Square matrices whose size is known when they are there: factors P A = L U, and solutions.

Matrices are stored by columns: ``a[j * ld + i]`` is the element in row i and column j, so that
everything runs along the memory.  Pivots are LAPACK's: the largest element of a column;
``pivots[k]`` is the row exchanged with row k.  The matrix of a singular system has a zero on the
diagonal of U: solutions are infinite or NaN.

Matrices may be banded: `lower` and `upper` are the numbers of diagonals below and above the main
one, n - 1 of a full matrix.  What lies outside of the band, widened by `lower` above for the
exchanges, is neither read nor written: with ``ld = 2 lower + upper`` columns overlap there only,
and the storage is LAPACK's of band matrices.  Work is n lower (lower + upper).
"""

from ..jit_options import INTERNAL, njit

LONG = 8  # from here on a loop over a column is worth two slices


@njit(**INTERNAL)
def bandwidths(a, n):
    """The diagonals below and above the main one that have an element, of a matrix with ld = n."""
    lower = upper = 0
    for j in range(n):
        for i in range(n):
            if a[j * n + i] != 0.0:
                lower, upper = max(lower, i - j), max(upper, j - i)
    return lower, upper


@njit(**INTERNAL)
def _subtract(y, x, factor):
    for i in range(len(y)):
        y[i] -= factor * x[i]


@njit(**INTERNAL)
def add_matrix_product(a, ld, x, out, n, lower, upper):
    """out += A x, of a matrix that is not factorised."""
    short = lower + upper < LONG
    for j in range(n):
        first, end, x_j = max(0, j - upper), min(n, j + 1 + lower), x[j]
        if short:
            for i in range(first, end):
                out[i] += a[j * ld + i] * x_j
        else:
            _subtract(out[first:end], a[j * ld + first : j * ld + end], -x_j)


@njit(**INTERNAL)
def factorise(a, ld, pivots, n, lower, upper):
    """Put L and U, with the reciprocals of its diagonal, in the place of a matrix."""
    for k in range(n):
        end, last, diagonal = min(n, k + 1 + lower), min(n, k + 1 + lower + upper), k * ld
        p, largest = k, abs(a[diagonal + k])
        for i in range(k + 1, end):
            if abs(a[diagonal + i]) > largest:
                p, largest = i, abs(a[diagonal + i])
        pivots[k] = p
        if p != k:
            for j in range(k, last):
                a[j * ld + k], a[j * ld + p] = a[j * ld + p], a[j * ld + k]
        scale = a[diagonal + k] = 1.0 / a[diagonal + k]
        for i in range(k + 1, end):
            a[diagonal + i] *= scale
        for j in range(k + 1, last):
            column = j * ld
            x = a[column + k]
            if x == 0.0:
                continue
            if end - k > LONG:
                below = a[diagonal + k + 1 : diagonal + end]
                _subtract(a[column + k + 1 : column + end], below, x)
            else:
                for i in range(k + 1, end):
                    a[column + i] -= x * a[diagonal + i]


@njit(**INTERNAL)
def solve(a, ld, pivots, b, n, lower, upper):
    """Put x, with A x = b, in the place of b; `a` is what `factorise` left."""
    for k in range(n):
        p, end, column = int(pivots[k]), min(n, k + 1 + lower), k * ld
        x = b[p]
        b[p], b[k] = b[k], x
        if end - k > LONG:
            _subtract(b[k + 1 : end], a[column + k + 1 : column + end], x)
        else:
            for i in range(k + 1, end):
                b[i] -= x * a[column + i]
    for k in range(n - 1, -1, -1):
        first, column = max(0, k - lower - upper), k * ld
        x = b[k] * a[column + k]
        b[k] = x
        if k - first > LONG:
            _subtract(b[first:k], a[column + first : column + k], x)
        else:
            for i in range(first, k):
                b[i] -= x * a[column + i]
