"""Square matrices whose size is known when they are there: factors P A = L U, and solutions.

Matrices are stored by columns: ``a[j, i]`` is the element in row i and column j, so that everything
runs along the memory.  Pivots are LAPACK's: the largest element of a column, of complex numbers
that with the largest |re| + |im|; ``pivots[k]`` is the row exchanged with row k.  The matrix of a
singular system has a zero on the diagonal of U: solutions are infinite or NaN.

Matrices may be banded: `lower` and `upper` are the numbers of diagonals below and above the main
one, n - 1 of a full matrix.  What lies outside of the band, widened by `lower` above for the
exchanges, is neither read nor written.  Work is n lower (lower + upper).

Complex matrices and rows are two, of real and imaginary parts.
"""

from ..jit_options import INTERNAL, njit

LONG = 8  # from here on a loop over a column is worth two slices


@njit(**INTERNAL)
def bandwidths(a, n):
    """The diagonals of a matrix below and above the main one that have an element."""
    lower = upper = 0
    for j in range(n):
        for i in range(n):
            if a[j, i] != 0.0:
                lower, upper = max(lower, i - j), max(upper, j - i)
    return lower, upper


@njit(**INTERNAL)
def _subtract(y, x, factor):
    for i in range(len(y)):
        y[i] -= factor * x[i]


@njit(**INTERNAL)
def factorise(a, pivots, n, lower, upper):
    """Put L and U, with the reciprocals of its diagonal, in the place of a matrix."""
    for k in range(n):
        end, last = min(n, k + 1 + lower), min(n, k + 1 + lower + upper)
        p, largest = k, abs(a[k, k])
        for i in range(k + 1, end):
            if abs(a[k, i]) > largest:
                p, largest = i, abs(a[k, i])
        pivots[k] = p
        if p != k:
            for j in range(k, last):
                a[j, k], a[j, p] = a[j, p], a[j, k]
        scale = a[k, k] = 1.0 / a[k, k]
        for i in range(k + 1, end):
            a[k, i] *= scale
        for j in range(k + 1, last):
            x = a[j, k]
            if x == 0.0:
                continue
            if end - k > LONG:
                _subtract(a[j, k + 1 : end], a[k, k + 1 : end], x)
            else:
                for i in range(k + 1, end):
                    a[j, i] -= x * a[k, i]


@njit(**INTERNAL)
def solve(a, pivots, b, n, lower, upper):
    """Put x, with A x = b, in the place of b; `a` is what `factorise` left."""
    for k in range(n):
        p, end = int(pivots[k]), min(n, k + 1 + lower)
        x = b[p]
        b[p], b[k] = b[k], x
        if end - k > LONG:
            _subtract(b[k + 1 : end], a[k, k + 1 : end], x)
        else:
            for i in range(k + 1, end):
                b[i] -= x * a[k, i]
    for k in range(n - 1, -1, -1):
        first = max(0, k - lower - upper)
        x = b[k] * a[k, k]
        b[k] = x
        if k - first > LONG:
            _subtract(b[first:k], a[k, first:k], x)
        else:
            for i in range(first, k):
                b[i] -= x * a[k, i]


@njit(**INTERNAL)
def _reciprocal(re, im):
    """1 / (re + i im) without squares that overflow."""
    if abs(re) >= abs(im):
        ratio = im / re
        size = re + im * ratio
        return 1.0 / size, -ratio / size
    ratio = re / im
    size = im + re * ratio
    return ratio / size, -1.0 / size


@njit(**INTERNAL)
def _subtract_complex(b, c, re, im, x, y):
    for i in range(len(b)):
        u, v = re[i], im[i]
        b[i] -= x * u - y * v
        c[i] -= x * v + y * u


@njit(**INTERNAL)
def factorise_complex(re, im, pivots, n, lower, upper):
    """`factorise` of a complex matrix."""
    for k in range(n):
        end, last = min(n, k + 1 + lower), min(n, k + 1 + lower + upper)
        p, largest = k, abs(re[k, k]) + abs(im[k, k])
        for i in range(k + 1, end):
            size = abs(re[k, i]) + abs(im[k, i])
            if size > largest:
                p, largest = i, size
        pivots[k] = p
        if p != k:
            for j in range(k, last):
                re[j, k], re[j, p] = re[j, p], re[j, k]
                im[j, k], im[j, p] = im[j, p], im[j, k]
        x, y = _reciprocal(re[k, k], im[k, k])
        re[k, k], im[k, k] = x, y
        for i in range(k + 1, end):
            u, v = re[k, i], im[k, i]
            re[k, i], im[k, i] = u * x - v * y, u * y + v * x
        for j in range(k + 1, last):
            x, y = re[j, k], im[j, k]
            if x != 0.0 or y != 0.0:
                _subtract_column(re, im, j, k, x, y, k + 1, end)


@njit(**INTERNAL)
def _subtract_column(re, im, j, k, x, y, first, end):
    """Column j minus (x + i y) times column k, in the rows from `first` to `end`."""
    if end - first > LONG:
        left, right = re[j, first:end], im[j, first:end]
        _subtract_complex(left, right, re[k, first:end], im[k, first:end], x, y)
    else:
        for i in range(first, end):
            u, v = re[k, i], im[k, i]
            re[j, i] -= x * u - y * v
            im[j, i] -= x * v + y * u


@njit(**INTERNAL)
def _subtract_from(b, c, re, im, k, first, end):
    """b + i c minus its element k times column k, in the rows from `first` to `end`."""
    x, y = b[k], c[k]
    if end - first > LONG:
        _subtract_complex(b[first:end], c[first:end], re[k, first:end], im[k, first:end], x, y)
    else:
        for i in range(first, end):
            u, v = re[k, i], im[k, i]
            b[i] -= x * u - y * v
            c[i] -= x * v + y * u


@njit(**INTERNAL)
def solve_complex(re, im, pivots, b, c, n, lower, upper):
    """`solve` for a right-hand side b + i c."""
    for k in range(n):
        p = int(pivots[k])
        b[k], b[p] = b[p], b[k]
        c[k], c[p] = c[p], c[k]
        _subtract_from(b, c, re, im, k, k + 1, min(n, k + 1 + lower))
    for k in range(n - 1, -1, -1):
        u, v = re[k, k], im[k, k]
        b[k], c[k] = b[k] * u - c[k] * v, b[k] * v + c[k] * u
        _subtract_from(b, c, re, im, k, max(0, k - lower - upper), k)
