"""Factors and solutions of complex matrices; `factorise.py` is the real case.

A complex matrix or row is two real arrays, the real and the imaginary parts.  The pivot is the
element of a column with the largest |re| + |im|, as in LAPACK.
"""

from ..jit.options import INTERNAL, njit
from ..state.rows import after, keep_vector, vector_at
from .factorise import FORM, WIDTH, exchange


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
def _after(re, im, offset):
    return after(re, offset), after(im, offset)


@njit(**INTERNAL)
def _subtract(ours, theirs, count, x, y):
    """ours -= (x + i y) theirs, as the real `_subtract`."""
    b, c = ours
    re, im = theirs
    few = count & (WIDTH - 1)
    for i in range(few):
        u = re[i]
        v = im[i]
        b[i] -= x * u - y * v
        c[i] -= x * v + y * u
    for i in range(few, count, WIDTH):
        u = vector_at(FORM, re, i)
        v = vector_at(FORM, im, i)
        keep_vector(FORM, b, i, vector_at(FORM, b, i) - (x * u - y * v))
        keep_vector(FORM, c, i, vector_at(FORM, c, i) - (x * v + y * u))


@njit(**INTERNAL)
def factorise_complex(re, im, ld, pivots, n, lower, upper):
    """`factorise` of a complex matrix."""
    for k in range(n):
        below = min(n - k, 1 + lower)
        right = min(n - k, 1 + lower + upper)
        real, imaginary = column = _after(re, im, k * ld + k)
        p = 0
        largest = abs(real[0]) + abs(imaginary[0])
        for i in range(1, below):
            size = abs(real[i]) + abs(imaginary[i])
            if size > largest:
                p = i
                largest = size
        pivots[k] = k + p
        if p != 0:
            exchange(real, p, ld, right)
            exchange(imaginary, p, ld, right)
        x, y = _reciprocal(real[0], imaginary[0])
        real[0] = x
        imaginary[0] = y
        for i in range(1, below):
            u = real[i]
            v = imaginary[i]
            real[i] = u * x - v * y
            imaginary[i] = u * y + v * x
        for j in range(1, right):
            b, c = _after(*column, j * ld)
            x = b[0]
            y = c[0]
            if x != 0.0 or y != 0.0:
                _subtract(_after(b, c, 1), _after(*column, 1), below - 1, x, y)


@njit(**INTERNAL)
def solve_complex(re, im, ld, pivots, b, c, n, lower, upper):
    """`solve` for a right-hand side b + i c."""
    for k in range(n):
        p = int(pivots[k])
        count = min(n - k - 1, lower)
        below = _after(re, im, k * ld + k + 1)
        b[k], b[p] = b[p], b[k]
        c[k], c[p] = c[p], c[k]
        _subtract(_after(b, c, k + 1), below, count, b[k], c[k])
    for k in range(n - 1, -1, -1):
        first = max(0, k - lower - upper)
        real, imaginary = _after(re, im, k * ld)
        u = real[k]
        v = imaginary[k]
        b[k], c[k] = b[k] * u - c[k] * v, b[k] * v + c[k] * u
        above = _after(real, imaginary, first)
        _subtract(_after(b, c, first), above, k - first, b[k], c[k])
