"""Factors and solutions of complex matrices, as `factorise.py` has them of real ones.

Matrices and rows are two, of real and imaginary parts.  The pivot is the element of a column with
the largest |re| + |im|, as LAPACK's.
"""

from ..jit_options import INTERNAL, njit
from .factorise import LONG


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
def _subtract(b, c, re, im, x, y):
    """b + i c minus (x + i y) (re + i im)."""
    for i in range(len(b)):
        u, v = re[i], im[i]
        b[i] -= x * u - y * v
        c[i] -= x * v + y * u


@njit(**INTERNAL)
def factorise_complex(re, im, ld, pivots, n, lower, upper):
    """`factorise` of a complex matrix."""
    for k in range(n):
        end, last, diagonal = min(n, k + 1 + lower), min(n, k + 1 + lower + upper), k * ld
        p, largest = k, abs(re[diagonal + k]) + abs(im[diagonal + k])
        for i in range(k + 1, end):
            size = abs(re[diagonal + i]) + abs(im[diagonal + i])
            if size > largest:
                p, largest = i, size
        pivots[k] = p
        if p != k:
            for j in range(k, last):
                a, b = j * ld + k, j * ld + p
                re[a], re[b] = re[b], re[a]
                im[a], im[b] = im[b], im[a]
        x, y = _reciprocal(re[diagonal + k], im[diagonal + k])
        re[diagonal + k], im[diagonal + k] = x, y
        for i in range(diagonal + k + 1, diagonal + end):
            u, v = re[i], im[i]
            re[i], im[i] = u * x - v * y, u * y + v * x
        for j in range(k + 1, last):
            column = j * ld
            x, y = re[column + k], im[column + k]
            if x != 0.0 or y != 0.0:
                b, c = re[column:], im[column:]
                _subtract_column(b, c, re[diagonal:], im[diagonal:], x, y, k + 1, end)


@njit(**INTERNAL)
def _subtract_column(b, c, re, im, x, y, first, end):
    """b + i c minus (x + i y) times a column, in the rows from `first` to `end`."""
    if end - first > LONG:
        _subtract(b[first:end], c[first:end], re[first:end], im[first:end], x, y)
    else:
        for i in range(first, end):
            u, v = re[i], im[i]
            b[i] -= x * u - y * v
            c[i] -= x * v + y * u


@njit(**INTERNAL)
def solve_complex(re, im, ld, pivots, b, c, n, lower, upper):
    """`solve` for a right-hand side b + i c."""
    for k in range(n):
        p = int(pivots[k])
        b[k], b[p] = b[p], b[k]
        c[k], c[p] = c[p], c[k]
        end = min(n, k + 1 + lower)
        _subtract_column(b, c, re[k * ld :], im[k * ld :], b[k], c[k], k + 1, end)
    for k in range(n - 1, -1, -1):
        u, v = re[k * ld + k], im[k * ld + k]
        b[k], c[k] = b[k] * u - c[k] * v, b[k] * v + c[k] * u
        first = max(0, k - lower - upper)
        _subtract_column(b, c, re[k * ld :], im[k * ld :], b[k], c[k], first, k)
