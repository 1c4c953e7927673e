"""Factors and solutions of complex matrices; `factorise.py` is the real case.

A complex matrix or row is two real arrays, the real and the imaginary parts.  The pivot is the
element of a column with the largest |re| + |im|, as in LAPACK.
"""

from ..jit.options import INTERNAL, njit
from ..state.rows import after
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
def _subtract(b, c, re, im, count, x, y):
    """Subtract (x + i y) (re + i im) from b + i c, for `count` numbers."""
    for i in range(count):
        u, v = re[i], im[i]
        b[i] -= x * u - y * v
        c[i] -= x * v + y * u


@njit(**INTERNAL)
def _subtract_from(b, c, re, im, first, end, x, y):
    """`_subtract` in the rows from `first` to `end`."""
    if end - first > LONG:
        ours, theirs = (after(b, first), after(c, first)), (after(re, first), after(im, first))
        _subtract(*ours, *theirs, end - first, x, y)
        return
    for i in range(first, end):
        u, v = re[i], im[i]
        b[i] -= x * u - y * v
        c[i] -= x * v + y * u


@njit(**INTERNAL)
def factorise_complex(re, im, ld, pivots, n, lower, upper):
    """`factorise` of a complex matrix."""
    for k in range(n):
        end, last = min(n, k + 1 + lower), min(n, k + 1 + lower + upper)
        left, right = after(re, k * ld), after(im, k * ld)
        p, largest = k, abs(left[k]) + abs(right[k])
        for i in range(k + 1, end):
            size = abs(left[i]) + abs(right[i])
            if size > largest:
                p, largest = i, size
        pivots[k] = p
        if p != k:
            for j in range(k, last):
                b, c = after(re, j * ld), after(im, j * ld)
                b[k], b[p] = b[p], b[k]
                c[k], c[p] = c[p], c[k]
        x, y = _reciprocal(left[k], right[k])
        left[k], right[k] = x, y
        for i in range(k + 1, end):
            u, v = left[i], right[i]
            left[i], right[i] = u * x - v * y, u * y + v * x
        for j in range(k + 1, last):
            b, c = after(re, j * ld), after(im, j * ld)
            x, y = b[k], c[k]
            if x != 0.0 or y != 0.0:
                _subtract_from(b, c, left, right, k + 1, end, x, y)


@njit(**INTERNAL)
def solve_complex(re, im, ld, pivots, b, c, n, lower, upper):
    """`solve` for a right-hand side b + i c."""
    for k in range(n):
        p, end = int(pivots[k]), min(n, k + 1 + lower)
        b[k], b[p] = b[p], b[k]
        c[k], c[p] = c[p], c[k]
        left, right = after(re, k * ld), after(im, k * ld)
        _subtract_from(b, c, left, right, k + 1, end, b[k], c[k])
    for k in range(n - 1, -1, -1):
        left, right = after(re, k * ld), after(im, k * ld)
        u, v = left[k], right[k]
        b[k], c[k] = b[k] * u - c[k] * v, b[k] * v + c[k] * u
        _subtract_from(b, c, left, right, max(0, k - lower - upper), k, b[k], c[k])
