"""Factors of a matrix with padded columns: P A = L U, or A = L D L' of a symmetric matrix.

Pivots are LAPACK's: the largest element of a column.  Zeros at the end of a column of L, and in a
row of U, are left out, so that a band or an envelope costs what its elements cost.
"""

from ...jit.options import INLINED, INTERNAL, njit
from ...state.rows import after, keep_vector, scratch, vector_at
from ...vector.scalar_or_vector import select
from .columns import FORM, WIDTH, block_of, lanes_from, leading, subtract
from .storage import SCALED, SYMMETRIC

EPS = 2.0**-52
SMALLEST = 2.0**-1022  # the reciprocal of a smaller pivot overflows
# Least pivot of L D L', in terms of the element of A in its place.  Below, rounding may have made
# the pivot, and the matrix be singular: elimination with exchanges, which is LAPACK's, decides.
SURE = 1e-12
BY_DIAGONAL = -1.0  # stands as the first pivot of L D L'
LARGEST = scratch(WIDTH)
BY_ROWS = -2.0  # minus the first pivot, stands in its place where rows are scaled


@njit(**INTERNAL)
def factors(a, pivots, kind):
    """Replace a matrix by its factors; returns 1 for a singular matrix, else 0.

    A scaled matrix is singular to working precision, from pivots of n eps down: see `solve_linear`.

    Parameters
    ----------
    a : row of numbers
        The matrix, as `storage.py` describes it.
    pivots : row of n + n numbers
        Receives the pivots; the second half is room, or receives the scales of rows.
    kind : int
        GENERAL, SYMMETRIC or SCALED.
    """
    n = len(pivots) // 2
    if kind == SYMMETRIC and _by_diagonal(a, pivots, n):
        return 0
    if kind == SCALED:
        _scale(a, pivots, n)
        status = _with_exchanges(a, pivots, n, n * EPS)
        pivots[0] = BY_ROWS - pivots[0]
        return status
    return _with_exchanges(a, pivots, n, -1.0)


@njit(**INLINED)
def _scale(a, pivots, n):
    """Divide rows by their largest elements, which become the second half of `pivots`."""
    ld = leading(n)
    for i in range(n):
        largest = 0.0
        for j in range(n):
            largest = max(largest, abs(after(a, j * ld + i)[0]))
        pivots[n + i] = largest
        for j in range(n):
            place = after(a, j * ld + i)
            place[0] = place[0] / largest


@njit(**INLINED)
def _with_exchanges(a, pivots, n, floor):
    ld = leading(n)
    for k in range(n):  # the solution is computed for a singular matrix, too
        pivots[k] = k
    for k in range(n):
        column = after(a, k * ld)
        p, largest = _pivot(column, k, n)
        pivots[k] = p
        if largest == 0.0 or (floor > 0.0 and not largest > floor):
            return 1
        end = _end(column, k, n)
        if p != k:
            _exchange(a, k, p, n, ld)
        if end > k + 1:
            _divide(column, k + 1, end, column[k])
            _update(a, column, k, end, n, ld)
    return 0


@njit(**INLINED)
def _pivot(column, k, n):
    """The first row from k on with the largest absolute value of a column, and this value."""
    at = block_of(k)
    size = abs(vector_at(FORM, column, at))
    most = select(lanes_from(k) & (size > 0.0), size, 0.0)  # NaN is not larger
    for i in range(at + WIDTH, n, WIDTH):
        size = abs(vector_at(FORM, column, i))
        most = select(size > most, size, most)
    lanes = LARGEST()
    keep_vector(FORM, lanes, 0, most)
    largest = max(max(lanes[0], lanes[1]), max(lanes[2], lanes[3]))
    own = abs(after(column, k)[0])
    if not largest > own:
        return k, own
    p = k + 1
    while abs(after(column, p)[0]) != largest:
        p += 1
    return p, largest


@njit(**INLINED)
def _exchange(a, k, p, n, ld):
    """Exchange rows k and p."""
    upper = after(a, k)
    lower = after(a, p)
    for j in range(n):
        x = after(upper, j * ld)
        y = after(lower, j * ld)
        x[0], y[0] = y[0], x[0]


@njit(**INLINED)
def _end(column, k, n):
    """The first row below row k from which on a column is 0."""
    for i in range(n, k + 1, -1):
        if after(column, i - 1)[0] != 0.0:
            return i
    return k + 1


@njit(**INLINED)
def _divide(column, first, end, pivot):
    """Divide rows of a column by the pivot."""
    at = block_of(first)
    here = lanes_from(first)
    if abs(pivot) >= SMALLEST:
        scale = 1.0 / pivot
        keep_vector(FORM, column, at, vector_at(FORM, column, at) * select(here, scale, 1.0))
        for i in range(at + WIDTH, end, WIDTH):
            keep_vector(FORM, column, i, vector_at(FORM, column, i) * scale)
    else:
        keep_vector(FORM, column, at, vector_at(FORM, column, at) / select(here, pivot, 1.0))
        for i in range(at + WIDTH, end, WIDTH):
            keep_vector(FORM, column, i, vector_at(FORM, column, i) / pivot)


@njit(**INLINED)
def _update(a, column, k, end, n, ld):
    """Subtract products of column and row of a pivot, two columns at a time."""
    here = lanes_from(k + 1)
    first = block_of(k + 1)
    odd = (n - k - 1) & 1
    if odd:
        p = after(column, ld)
        subtract(p, column, k + 1, end, after(p, k)[0])
    for j in range(k + 1 + odd, n, 2):
        p = after(a, j * ld)
        q = after(p, ld)
        x = after(p, k)[0]
        y = after(q, k)[0]
        if x != 0.0 or y != 0.0:
            factor = vector_at(FORM, column, first)
            one = vector_at(FORM, p, first)
            two = vector_at(FORM, q, first)
            keep_vector(FORM, p, first, one - select(here, factor * x, 0.0))
            keep_vector(FORM, q, first, two - select(here, factor * y, 0.0))
            _subtract_both(p, q, column, first + WIDTH, end, x, y)


@njit(**INLINED)
def _subtract_both(p, q, column, first, end, x, y):
    """Subtract multiples of a column from two others."""
    for i in range(first, end, WIDTH):
        factor = vector_at(FORM, column, i)
        one = vector_at(FORM, p, i)
        two = vector_at(FORM, q, i)
        keep_vector(FORM, p, i, one - factor * x)
        keep_vector(FORM, q, i, two - factor * y)


@njit(**INLINED)
def _by_diagonal(a, pivots, n):
    """Replace the lower half by L and D; return False, with A as it was, for a small pivot."""
    ld = leading(n)
    for k in range(n):
        pivots[n + k] = after(a, k * ld + k)[0]
    for k in range(n):
        column = after(a, k * ld)
        d = after(column, k)[0]
        if not d > SURE * pivots[n + k] or not d >= SMALLEST:
            _restore(a, pivots, n)
            return False
        end = _end(column, k, n)
        if end > k + 1:
            _update_below(a, column, k, end, 1.0 / d, ld)
            _divide(column, k + 1, end, d)
    pivots[0] = BY_DIAGONAL
    return True


@njit(**INLINED)
def _update_below(a, column, k, end, scale, ld):
    """Subtract products of a column and itself below the diagonal, two columns at a time."""
    even = (k + 2) & -2  # columns of a pair begin in the same vector
    if even > k + 1:
        subtract(after(a, even * ld - ld), column, k + 1, end, after(column, k + 1)[0] * scale)
    if end & 1 and end > even:
        j = end - 1
        subtract(after(a, j * ld), column, j, end, after(column, j)[0] * scale)
    for j in range(even, end - 1, 2):
        p = after(a, j * ld)
        q = after(p, ld)
        first = block_of(j)
        x = after(column, j)[0] * scale
        y = after(column, j + 1)[0] * scale
        if x != 0.0 or y != 0.0:
            factor = vector_at(FORM, column, first)
            one = vector_at(FORM, p, first)
            two = vector_at(FORM, q, first)
            keep_vector(FORM, p, first, one - select(lanes_from(j), factor * x, 0.0))
            keep_vector(FORM, q, first, two - select(lanes_from(j + 1), factor * y, 0.0))
            _subtract_both(p, q, column, first + WIDTH, end, x, y)


@njit(**INLINED)
def _restore(a, pivots, n):
    """Copy the upper half of a symmetric matrix to the lower half, and put its diagonal back."""
    ld = leading(n)
    for k in range(n):
        column = after(a, k * ld)
        after(column, k)[0] = pivots[n + k]
        for i in range(k + 1, n):
            after(column, i)[0] = after(a, i * ld + k)[0]
        for i in range(n, ld):
            after(column, i)[0] = 0.0
