"""The Jacobian of a right-hand side: exact, as the user gives it, constant, or by differences.

It is stored by columns, as `algebra/factorise.py` takes it: row j of it is the derivative by
component j.  Which of the four it is says the word JACOBIAN of the block; see `calls/block.py`.
Where an exact one is not finite, differences may be.
"""

import numpy as np

from ..algebra.factorise import bandwidths
from ..calls.block import ADDRESS, FIRST, JACOBIAN, N_ENTRIES, RAISED_WORD
from ..calls.user_function import (
    address_of,
    call_function,
    call_with,
    numbers_at,
    raised,
    words_at,
)
from ..jit_options import INTERNAL, njit
from ..state.record import ATOL, BAD_JACOBIAN, RAISED, RUNNING, STAGE
from ..state.rows import copy_row, numbers_of, slot

EPS = float(np.finfo(float).eps)
REJECT, SMALL, BIG = EPS**0.875, EPS**0.75, EPS**0.25  # of differences, beside what is subtracted
FIRST_FACTOR, LEAST_FACTOR = EPS**0.5, 1e3 * EPS


@njit(**INTERNAL)
def evaluate_row(rhs, t, work, given, found, block):
    """Evaluate the derivative at the state in one row into another; False if it raised."""
    rhs(t, slot(None, work, given), block, slot(None, work, found))
    return block[RAISED_WORD] == 0


@njit(**INTERNAL)
def clear_matrix(work, first):
    """Fill the matrix from row `first` on with zeros, where exact entries will be put."""
    for j in range(work.shape[1]):
        for i in range(work.shape[1]):
            work[first + j, i] = 0.0


@njit(**INTERNAL)
def takes_slope(block):
    """Whether the Jacobian needs the derivative at its state; where an exact one is not finite."""
    return block[JACOBIAN] == 0 or words_at(block[JACOBIAN])[N_ENTRIES] > 0


@njit(**INTERNAL)
def is_constant(block):
    """Whether the Jacobian is a matrix that the user gave."""
    return block[JACOBIAN] != 0 and words_at(block[JACOBIAN])[ADDRESS] == 0


@njit(**INTERNAL)
def evaluate_jacobian(rhs, s, t, work, y, f, block, factor, first):
    """The Jacobian at the state in row `y`, in the rows from `first` on, and its bandwidths.

    Parameters
    ----------
    rhs : function
        As in `adaptive.kernel`.
    s : record
        The state record.
    t : float
    work, block : array
    y, f : int
        Rows of the state and of its derivative.
    factor, first : int
        The row of the factors of `_difference`, behind which lies a row to write to; the first row
        of the matrix, behind which lies one to write to.

    Returns
    -------
    int
        RUNNING, RAISED or BAD_JACOBIAN.
    """
    n, given = work.shape[1], block[JACOBIAN]
    matrix, numbers = work[first : first + n], numbers_of(work)[first * n : (first + 2 * n) * n]
    if given != 0 and words_at(given)[N_ENTRIES] > 0:
        entries = numbers[n * n :]
        call_with(words_at(given)[ADDRESS], address_of(block), t, slot(None, work, y), entries)
        if _put_entries(s, given, entries, numbers, n):
            return RUNNING
        given = 0
    if given == 0:
        for j in range(n):
            if not _difference(rhs, t, work, y, f, block, factor, matrix[j], j):
                return RAISED
    elif words_at(given)[ADDRESS] == 0:
        _copy_constant(given, matrix)
    else:
        call_function(given, t, slot(None, work, y), numbers)
        if raised(given):
            return RAISED
        _transpose(matrix)
    for j in range(n):
        for i in range(n):
            if not np.isfinite(matrix[j, i]):
                return BAD_JACOBIAN
    s.lower, s.upper = bandwidths(matrix, n)
    return RUNNING


@njit(**INTERNAL)
def _put_entries(s, given, entries, numbers, n):
    """Entries of an exact Jacobian to their places, and its bandwidths; False if one is not finite.

    All other elements are zero from the start: see `clear_matrix`.
    """
    words, lower, upper = words_at(given), 0, 0
    for e in range(words[N_ENTRIES]):
        place = words[FIRST + e]
        i, j = place % n, place // n
        lower, upper = max(lower, i - j), max(upper, j - i)
        numbers[place] = entries[e]
        if not np.isfinite(entries[e]):
            return False
    s.lower, s.upper = lower, upper
    return True


@njit(**INTERNAL)
def _copy_constant(given, matrix):
    numbers, n = numbers_at(given + 8 * FIRST), len(matrix)
    for i in range(n):
        for j in range(n):
            matrix[j, i] = numbers[i * n + j]


@njit(**INTERNAL)
def _transpose(matrix):
    for i in range(len(matrix)):
        for j in range(i):
            matrix[i, j], matrix[j, i] = matrix[j, i], matrix[i, j]


@njit(**INTERNAL)
def _difference(rhs, t, work, y, f, block, factor, column, j):
    """Column j of the Jacobian by a forward difference, as SciPy's `num_jac`; False if it raised.

    The step is a factor of |y_j|, learned from one Jacobian to the next, such that the difference
    stands out from the rounding of what is subtracted: D. E. Salane, "Adaptive routines for
    forming Jacobians numerically", Sandia report SAND86-1319 (1986).
    """
    copy_row(work[y], work[STAGE])
    here = work[y, j]
    scale = max(work[ATOL, j], abs(here))
    if scale == 0.0:
        scale = 1.0
    if not work[f, j] >= 0.0:
        scale = -scale
    if work[factor, j] == 0.0:
        work[factor, j] = FIRST_FACTOR
    h = (here + work[factor, j] * scale) - here
    while h == 0.0:
        work[factor, j] *= 10.0
        h = (here + work[factor, j] * scale) - here
    found = factor + 1
    work[STAGE, j] = here + h
    if not evaluate_row(rhs, t, work, STAGE, found, block):
        return False
    change, size = _largest_change(work[found], work[f])
    for i in range(len(column)):
        column[i] = work[found, i] - work[f, i]
    if change < REJECT * size:
        longer = (here + 10.0 * work[factor, j] * scale) - here
        work[STAGE, j] = here + longer
        if not evaluate_row(rhs, t, work, STAGE, found, block):
            return False
        new_change, new_size = _largest_change(work[found], work[f])
        if change * new_size < new_change * size:
            work[factor, j] *= 10.0
            h, change, size = longer, new_change, new_size
            for i in range(len(column)):
                column[i] = work[found, i] - work[f, i]
    for i in range(len(column)):
        column[i] /= h
    if change < SMALL * size:
        work[factor, j] *= 10.0
    if change > BIG * size:
        work[factor, j] *= 0.1
    work[factor, j] = max(work[factor, j], LEAST_FACTOR)
    return True


@njit(**INTERNAL)
def _largest_change(new, old):
    """The largest |new - old| of a component, and the larger of both sizes there."""
    where = 0
    change = abs(new[0] - old[0])
    for i in range(1, len(new)):
        if abs(new[i] - old[i]) > change:
            change, where = abs(new[i] - old[i]), i
    return change, max(abs(new[where]), abs(old[where]))
