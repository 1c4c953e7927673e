"""Jacobians by forward differences, as SciPy's `num_jac`, a column or a group of columns at a time.

The step of a difference is |y_j| times a factor.  The factor is adapted from one Jacobian to the
next, such that the difference exceeds the rounding errors of its two terms: D. E. Salane, "Adaptive
routines for forming Jacobians numerically", Sandia report SAND86-1319 (1986).  Columns that have no
row in common share an evaluation: A. Curtis, M. Powell and J. Reid, J. Inst. Maths. Applics. 13
(1974).
"""

import numpy as np

from ..calls.block import FIRST, GROUPS, N_ENTRIES, RAISED_WORD
from ..calls.user_function import words_at
from ..jit.options import INLINED, INTERNAL, njit
from ..state.record import ATOL, STAGE, Y
from ..state.rows import copy_row, slot

EPS = float(np.finfo(float).eps)
REJECT, SMALL, BIG = EPS**0.875, EPS**0.75, EPS**0.25  # of a difference over its terms
FIRST_FACTOR, LEAST_FACTOR = EPS**0.5, 1e3 * EPS  # as in SciPy


@njit(**INTERNAL)
def evaluate_row(rhs, t, work, given, found, block):
    """Put the derivative at the state of one row into another row; False if f raised."""
    rhs(t, slot(None, work, given), block, slot(None, work, found))
    return block[RAISED_WORD] == 0


@njit(**INTERNAL)
def _increment(work, y, f, factor, j, times):
    """The displacement of component j, a multiple of its factor.

    The factor grows until the displacement is not 0.  A component without a bound of its error,
    such as a discrete state, has an infinite `atol`.
    """
    here = work[y, j]
    scale = max(work[ATOL, j], abs(here))
    if scale == 0.0 or scale == np.inf:
        scale = max(1.0, abs(here))
    if not work[f, j] >= 0.0:
        scale = -scale
    if work[factor, j] == 0.0:
        work[factor, j] = FIRST_FACTOR
    h = (here + times * work[factor, j] * scale) - here
    while h == 0.0:
        work[factor, j] *= 10.0
        h = (here + times * work[factor, j] * scale) - here
    return h


@njit(**INTERNAL)
def _learn(work, factor, j, change, size):
    """The factor of component j for the next Jacobian."""
    if change < SMALL * size:
        work[factor, j] *= 10.0
    if change > BIG * size:
        work[factor, j] *= 0.1
    work[factor, j] = max(work[factor, j], LEAST_FACTOR)


@njit(**INTERNAL)
def column_difference(rhs, t, work, y, f, block, factor, column, j):
    """Column j of the Jacobian; False if the function raised.

    `y`, `f` and `factor` are the rows of the state, of its derivative, and of the factors; the row
    behind the factors is free.
    """
    found = factor + 1
    h = _increment(work, y, f, factor, j, 1.0)
    copy_row(work[y], work[STAGE])
    work[STAGE, j] = work[y, j] + h
    if not evaluate_row(rhs, t, work, STAGE, found, block):
        return False
    change, size = _largest_change(work[found], work[f])
    if not np.isfinite(change):  # beyond a border: the other side is taken
        h = -h
        work[STAGE, j] = work[y, j] + h
        if not evaluate_row(rhs, t, work, STAGE, found, block):
            return False
        change, size = _largest_change(work[found], work[f])
    for i in range(len(column)):
        column[i] = work[found, i] - work[f, i]
    if change < REJECT * size:
        longer = _increment(work, y, f, factor, j, 10.0)
        work[STAGE, j] = work[y, j] + longer
        if not evaluate_row(rhs, t, work, STAGE, found, block):
            return False
        new_change, new_size = _largest_change(work[found], work[f])
        if change * new_size < new_change * size:
            work[factor, j] *= 10.0
            h = longer
            change = new_change
            size = new_size
            for i in range(len(column)):
                column[i] = work[found, i] - work[f, i]
    for i in range(len(column)):
        column[i] /= h
    _learn(work, factor, j, change, size)
    return True


@njit(**INTERNAL)
def _largest_change(new, old):
    """The largest |new - old| over the components, and the larger of |new|, |old| there."""
    where = 0
    change = abs(new[0] - old[0])
    for i in range(1, len(new)):
        if abs(new[i] - old[i]) > change:
            change = abs(new[i] - old[i])
            where = i
    return change, max(abs(new[where]), abs(old[where]))


@njit(**INTERNAL)
def differences_in_groups(rhs, t, work, y, f, block, given, factor, entries):
    """The entries of the Jacobian in the places of the block at `given`; False if f raised.

    Behind the places lie three lists of words: the row of each entry, the index of the first entry
    of each column, the group of each column.  Two rows behind the factors are free.
    """
    n = work.shape[1]
    words = words_at(given)
    groups = FIRST + 2 * words[N_ENTRIES] + n + 1
    for g in range(words[GROUPS]):
        copy_row(work[y], work[STAGE])
        for j in range(n):
            if words[groups + j] == g:
                work[STAGE, j] += _increment(work, y, f, factor, j, 1.0)
        if not evaluate_row(rhs, t, work, STAGE, factor + 1, block):
            return False
        again = False
        copy_row(work[y], work[STAGE])
        for j in range(n):
            if words[groups + j] == g:
                change, size = _largest_entry(work, f, factor + 1, words, j)
                if change < REJECT * size:
                    again = True
                    work[STAGE, j] += _increment(work, y, f, factor, j, 10.0)
        if again and not evaluate_row(rhs, t, work, STAGE, factor + 2, block):
            return False
        for j in range(n):
            if words[groups + j] == g:
                _put_column(work, y, f, factor, words, j, entries)
    return True


@njit(**INTERNAL)
def _put_column(work, y, f, factor, words, j, entries):
    """The entries of a column by the better of two differences."""
    rows, begins = _column(words)
    found = factor + 1
    h = _increment(work, y, f, factor, j, 1.0)
    change, size = _largest_entry(work, f, found, words, j)
    if change < REJECT * size:
        new_change, new_size = _largest_entry(work, f, found + 1, words, j)
        if change * new_size < new_change * size:
            h = _increment(work, y, f, factor, j, 10.0)
            found = found + 1
            change = new_change
            size = new_size
            work[factor, j] *= 10.0
    for e in range(words[begins + j], words[begins + j + 1]):
        i = words[rows + e]
        entries[e] = (work[found, i] - work[f, i]) / h
    _learn(work, factor, j, change, size)


@njit(**INLINED)
def _column(words):
    """The indices, in the words, of the rows of the entries and of the starts of the columns."""
    rows = FIRST + words[N_ENTRIES]
    return rows, rows + words[N_ENTRIES]


@njit(**INTERNAL)
def _largest_entry(work, f, found, words, j):
    """`_largest_change` of the entries of column j."""
    rows, begins = _column(words)
    change = size = 0.0
    for e in range(words[begins + j], words[begins + j + 1]):
        i = words[rows + e]
        moved = abs(work[found, i] - work[f, i])
        if moved > change or size == 0.0:
            change = moved
            size = max(abs(work[found, i]), abs(work[f, i]))
    return change, size


@njit(**INLINED)
def first_factors(work, factor):
    """Scale the first differences of states that begin at 0 by the largest state."""
    largest = 0.0
    for j in range(work.shape[1]):
        largest = max(largest, abs(work[Y, j]))
    for j in range(work.shape[1]):
        scale = max(work[ATOL, j], abs(work[Y, j]))
        work[factor, j] = FIRST_FACTOR
        if scale > 0.0:
            work[factor, j] *= max(1.0, 1e-3 * largest / scale)


@njit(**INLINED)
def keep_factors(work, factor):
    """Let no step of differences be shorter than the first.

    SciPy shortens a step whose difference is large beside the derivative.  The derivative of an
    algebraic equation is zero, and any derivative is small near an equilibrium: with ever shorter
    steps, the difference would consist of rounding errors.
    """
    for j in range(work.shape[1]):
        work[factor, j] = max(work[factor, j], FIRST_FACTOR)
