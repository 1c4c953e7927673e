"""Solutions of systems of equations from the factors of `factors.py`, four columns at a time.

The triangle of four columns on the diagonal is solved number by number, in registers; vectors hold
the rows above or below.  Numbers that are just stored could not be read as a vector without a wait.
"""

from ...jit.options import INLINED, INTERNAL, njit
from ...state.rows import after, keep_vector, scratch, vector_at
from .columns import FORM, WIDTH
from .factors import BY_DIAGONAL, BY_ROWS

SUMS = scratch(WIDTH * WIDTH)


@njit(**INTERNAL)
def solution(a, pivots, b, transposed):
    """Replace b by x, with A x = b, or with A' x = b if `transposed` is 1; returns 0.

    Parameters
    ----------
    a, pivots : rows of numbers
        From `factors`.
    b : row of numbers
        The right-hand side, with zeros in the padding.
    """
    scaled = pivots[0] <= BY_ROWS
    if pivots[0] == BY_DIAGONAL:
        _forward(a, b)
        _by_diagonal(a, b)
    elif transposed:
        _forward_by_rows(a, b)
        _backward_by_rows(a, b)
        _exchange_back(b, pivots)
        if scaled:
            _divide(b, pivots)
    else:
        if scaled:
            _divide(b, pivots)
        _exchange(b, pivots)
        _forward(a, b)
        _backward(a, b)
    return 0


@njit(**INLINED)
def _divide(b, pivots):
    """Divide the right-hand side by the scales of rows."""
    n = len(pivots) // 2
    for k in range(n):
        b[k] = b[k] / pivots[n + k]


@njit(**INLINED)
def _exchange(b, pivots):
    for k in range(len(pivots) // 2):
        _swap(b, k, pivots[k])


@njit(**INLINED)
def _exchange_back(b, pivots):
    for k in range(len(pivots) // 2 - 1, -1, -1):
        _swap(b, k, pivots[k])


@njit(**INLINED)
def _swap(b, k, pivot):
    x = after(b, k)
    y = after(b, int(pivot if pivot >= 0.0 else BY_ROWS - pivot))
    x[0], y[0] = y[0], x[0]


@njit(**INLINED)
def _columns(a, ld, k):
    """Columns k to k + 3, from row k on."""
    p = after(a, k * ld + k)
    q = after(p, ld)
    r = after(q, ld)
    return p, q, r, after(r, ld)


@njit(**INLINED)
def _forward(a, b):
    """Replace b by x, with L x = b."""
    ld = len(b)
    for k in range(0, ld, WIDTH):
        p, q, r, s = _columns(a, ld, k)
        y = after(b, k)
        x0 = y[0]
        x1 = y[1] - p[1] * x0
        x2 = y[2] - p[2] * x0 - q[2] * x1
        x3 = y[3] - p[3] * x0 - q[3] * x1 - r[3] * x2
        y[1] = x1
        y[2] = x2
        y[3] = x3
        for i in range(WIDTH, ld - k, WIDTH):
            v = vector_at(FORM, y, i) - vector_at(FORM, p, i) * x0 - vector_at(FORM, q, i) * x1
            v = v - vector_at(FORM, r, i) * x2 - vector_at(FORM, s, i) * x3
            keep_vector(FORM, y, i, v)


@njit(**INLINED)
def _backward(a, b):
    """Replace b by x, with U x = b."""
    ld = len(b)
    for k in range(ld - WIDTH, -1, -WIDTH):
        p, q, r, s = _columns(a, ld, k)
        y = after(b, k)
        x3 = y[3] / s[3]
        x2 = (y[2] - s[2] * x3) / r[2]
        x1 = (y[1] - s[1] * x3 - r[1] * x2) / q[1]
        x0 = (y[0] - s[0] * x3 - r[0] * x2 - q[0] * x1) / p[0]
        y[0] = x0
        y[1] = x1
        y[2] = x2
        y[3] = x3
        for i in range(-WIDTH, -k - 1, -WIDTH):
            v = vector_at(FORM, y, i) - vector_at(FORM, s, i) * x3 - vector_at(FORM, r, i) * x2
            v = v - vector_at(FORM, q, i) * x1 - vector_at(FORM, p, i) * x0
            keep_vector(FORM, y, i, v)


@njit(**INLINED)
def _products(columns, y, first, end):
    """The sums of y[i] and each of four columns, for i of first, ..., end - 1."""
    p, q, r, s = columns
    zero = vector_at(FORM, y, 0) * 0.0
    d0 = zero
    d1 = zero
    d2 = zero
    d3 = zero
    for i in range(first, end, WIDTH):
        x = vector_at(FORM, y, i)
        d0 = d0 + vector_at(FORM, p, i) * x
        d1 = d1 + vector_at(FORM, q, i) * x
        d2 = d2 + vector_at(FORM, r, i) * x
        d3 = d3 + vector_at(FORM, s, i) * x
    sums = SUMS()
    keep_vector(FORM, sums, 0, d0)
    keep_vector(FORM, sums, WIDTH, d1)
    keep_vector(FORM, sums, 2 * WIDTH, d2)
    keep_vector(FORM, sums, 3 * WIDTH, d3)
    return _sum(sums, 0), _sum(sums, WIDTH), _sum(sums, 2 * WIDTH), _sum(sums, 3 * WIDTH)


@njit(**INLINED)
def _sum(sums, i):
    v = after(sums, i)
    return (v[0] + v[1]) + (v[2] + v[3])


@njit(**INLINED)
def _forward_by_rows(a, b):
    """Replace b by x, with U' x = b."""
    ld = len(b)
    for k in range(0, ld, WIDTH):
        columns = p, q, r, s = _columns(a, ld, k)
        y = after(b, k)
        d0, d1, d2, d3 = _products(columns, y, -k, 0)
        x0 = (y[0] - d0) / p[0]
        x1 = (y[1] - d1 - q[0] * x0) / q[1]
        x2 = (y[2] - d2 - r[0] * x0 - r[1] * x1) / r[2]
        y[3] = (y[3] - d3 - s[0] * x0 - s[1] * x1 - s[2] * x2) / s[3]
        y[0] = x0
        y[1] = x1
        y[2] = x2


@njit(**INLINED)
def _backward_by_rows(a, b):
    """Replace b by x, with L' x = b."""
    ld = len(b)
    for k in range(ld - WIDTH, -1, -WIDTH):
        y = after(b, k)
        _above(_columns(a, ld, k), y, y[0], y[1], y[2], y[3], ld - k)


@njit(**INLINED)
def _by_diagonal(a, b):
    """Replace b by x, with D L' x = b."""
    ld = len(b)
    for k in range(ld - WIDTH, -1, -WIDTH):
        columns = p, q, r, s = _columns(a, ld, k)
        y = after(b, k)
        _above(columns, y, y[0] / p[0], y[1] / q[1], y[2] / r[2], y[3] / s[3], ld - k)


@njit(**INLINED)
def _above(columns, y, y0, y1, y2, y3, end):
    """Put four numbers of x, with L' x = (y0, ..., y3) in their rows, before the known numbers."""
    p, q, r, _ = columns
    d0, d1, d2, d3 = _products(columns, y, WIDTH, end)
    x3 = y3 - d3
    x2 = y2 - d2 - r[3] * x3
    x1 = y1 - d1 - q[3] * x3 - q[2] * x2
    y[0] = y0 - d0 - p[3] * x3 - p[2] * x2 - p[1] * x1
    y[1] = x1
    y[2] = x2
    y[3] = x3
