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
def _subtract(b, c, at, re, im, begin, end, x, y):
    """b + i c, from `at` on, minus (x + i y) times the numbers from `begin` to `end`."""
    if end - begin > LONG:
        _subtract_rows(b[at:], c[at:], re[begin:end], im[begin:end], x, y)
        return
    for i in range(end - begin):
        u, v = re[begin + i], im[begin + i]
        b[at + i] -= x * u - y * v
        c[at + i] -= x * v + y * u


@njit(**INTERNAL)
def _subtract_rows(b, c, re, im, x, y):
    for i in range(len(re)):
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
        begin, end = diagonal + k + 1, diagonal + end
        for i in range(begin, end):
            u, v = re[i], im[i]
            re[i], im[i] = u * x - v * y, u * y + v * x
        for at in range((k + 1) * ld + k, last * ld + k, ld):
            x, y = re[at], im[at]
            if x != 0.0 or y != 0.0:
                _subtract(re, im, at + 1, re, im, begin, end, x, y)


@njit(**INTERNAL)
def solve_complex(re, im, ld, pivots, b, c, n, lower, upper):
    """`solve` for a right-hand side b + i c."""
    for k in range(n):
        p, end = int(pivots[k]), min(n, k + 1 + lower)
        b[k], b[p] = b[p], b[k]
        c[k], c[p] = c[p], c[k]
        _subtract(b, c, k + 1, re, im, k * ld + k + 1, k * ld + end, b[k], c[k])
    for k in range(n - 1, -1, -1):
        column, first = k * ld, max(0, k - lower - upper)
        u, v = re[column + k], im[column + k]
        b[k], c[k] = b[k] * u - c[k] * v, b[k] * v + c[k] * u
        _subtract(b, c, first, re, im, column + first, column + k, b[k], c[k])
