"""The Jacobian of a right-hand side: exact, as the user gives it, constant, or by differences.

The Jacobian is stored as `algebra/matrices.py` says.  The word JACOBIAN of the block tells which of
the four kinds is used; see `calls/block.py`.
"""

import numpy as np

from ..algebra.factorise import bandwidths
from ..algebra.matrices import leading, matrix_at, matrix_rows, rare
from ..calls.block import (
    ABOVE,
    ADDRESS,
    BELOW,
    FIRST,
    FULL,
    GROUPS,
    JACOBIAN,
    KIND,
    MATRICES,
    N_ENTRIES,
    OTHER_JACOBIAN,
    OUTSIDE,
    OWN_BLOCK,
)
from ..calls.calling_convention import invoke
from ..calls.user_function import (
    address_of,
    by_pointer,
    call_function,
    call_with,
    numbers_at,
    raised,
    words_at,
)
from ..jit.options import INTERNAL, njit
from ..state.record import BAD_JACOBIAN, RAISED, RUNNING
from ..state.rows import numbers_from, slot
from .differences import column_difference, differences_in_groups


@njit(**INTERNAL)
def clear_matrix(work, block, first):
    """Fill the matrix from row `first` on with zeros, where entries will be put."""
    for r in range(first, first + matrix_rows(block, work.shape[1])):
        for i in range(work.shape[1]):
            work[r, i] = 0.0


@njit(**INTERNAL)
def takes_slope(block):
    """True if the Jacobian may need the derivative at its state.

    Differences need the derivative.  Entries by a function become differences if they are not
    finite.
    """
    if block[JACOBIAN] == 0:
        return True
    return words_at(block[JACOBIAN])[N_ENTRIES] > 0 and not is_constant(block)


@njit(**INTERNAL)
def is_constant(block):
    """Whether the Jacobian is a matrix that the user gave."""
    if block[JACOBIAN] == 0:
        return False
    words = words_at(block[JACOBIAN])
    return words[ADDRESS] == 0 and words[GROUPS] == 0


@njit(**INTERNAL)
def is_exact(given):
    """Whether the block at an address is that of an exact Jacobian."""
    words = words_at(given)
    return given != 0 and words[N_ENTRIES] > 0 and words[ADDRESS] != 0 and words[OWN_BLOCK] == 0


@njit(**INTERNAL)
def entries_at(work, block, first):
    """The places in `work` of the entries of a Jacobian, and of the numbers behind the entries."""
    rows = matrix_rows(block, work.shape[1])
    outside = block[MATRICES] != 0 and words_at(block[MATRICES])[KIND] == OUTSIDE
    return numbers_from(work, first if outside else first + rows, 0)


@njit(**INTERNAL)
def evaluate_jacobian(s, t, work, y, f, block, factor, first):
    """The Jacobian at the state in row `y`, in the rows from `first` on, and its bandwidths.

    Parameters
    ----------
    s : record
        The state record.
    t : float
    work, block : array
    y, f : int
        Rows of the state and of its derivative.
    factor, first : int
        The row of the factors of differences, and the first row of the matrix.  Two free rows lie
        behind the factors, one free row behind the matrix.

    Returns
    -------
    int
        RUNNING, RAISED or BAD_JACOBIAN.
    """
    if is_exact(block[JACOBIAN]):
        words = words_at(block[JACOBIAN])
        entries = entries_at(work, block, first)
        call_with(words[ADDRESS], address_of(block), t, slot(None, work, y), entries)
        if _are_finite(entries, words[N_ENTRIES]):
            _put_entries(s, work, block, entries, first)
            return RUNNING
    given = s, t, work, y, f, block, factor, first
    return invoke(rare(block, OTHER_JACOBIAN), given)


@njit(**INTERNAL)
def other_jacobian(state, t, work, y, f, block, factor, first):
    """`evaluate_jacobian` for all Jacobians: a kernel of its own, which few solves need."""
    s = state[0]
    n = work.shape[1]
    given = block[JACOBIAN]
    if given != 0 and words_at(given)[N_ENTRIES] > 0:
        status = _put_other_entries(s, t, work, y, f, block, given, factor, first)
        if status != BAD_JACOBIAN or (block[MATRICES] != 0 and leading(block, n)[0] != n):
            return status
        given = 0
    matrix = matrix_at(work, block, first)
    if given == 0:
        for j in range(n):
            column = matrix[j * n : (j + 1) * n]
            if not column_difference(by_pointer, t, work, y, f, block, factor, column, j):
                return RAISED
    elif words_at(given)[ADDRESS] == 0:
        _copy_constant(given, matrix, n)
    else:
        call_function(given, t, slot(None, work, y), matrix)
        if raised(given):
            return RAISED
        _transpose(matrix, n)
    for e in range(n * n):
        if not np.isfinite(matrix[e]):
            return BAD_JACOBIAN
    s.lower, s.upper = bandwidths(matrix, n)
    return RUNNING


@njit(**INTERNAL)
def _put_other_entries(s, t, work, y, f, block, given, factor, first):
    """Evaluate the entries of a Jacobian, and put the entries into the matrix."""
    words = words_at(given)
    entries = entries_at(work, block, first)
    status = _evaluate_entries(t, slot(None, work, y), block, given, entries)
    if status == BAD_JACOBIAN and words[GROUPS] > 0:
        if not differences_in_groups(by_pointer, t, work, y, f, block, given, factor, entries):
            return RAISED
        status = RUNNING if _are_finite(entries, words[N_ENTRIES]) else BAD_JACOBIAN
    if status == RUNNING:
        _put_entries(s, work, block, entries, first)
    return status


@njit(**INTERNAL)
def _put_entries(s, work, block, entries, first):
    """Put the entries of a Jacobian into the matrix, which `clear_matrix` filled with zeros."""
    n = work.shape[1]
    given = block[JACOBIAN]
    if block[MATRICES] == 0 or words_at(block[MATRICES])[KIND] == FULL:
        s.lower, s.upper = _spread(given, entries, matrix_at(work, block, first), n)
        return
    if words_at(block[MATRICES])[KIND] != OUTSIDE:
        _spread(given, entries, matrix_at(work, block, first), n)
    s.lower, s.upper = words_at(block[MATRICES])[BELOW], words_at(block[MATRICES])[ABOVE]


@njit(**INTERNAL)
def _evaluate_entries(t, y, block, given, entries):
    """Evaluate the entries by their function, or copy constant entries.

    Returns RUNNING, RAISED, or BAD_JACOBIAN if an entry is missing or not finite.
    """
    words = words_at(given)
    if words[ADDRESS] == 0:
        if words[GROUPS] > 0:
            return BAD_JACOBIAN
        numbers = numbers_at(given + 8 * (FIRST + words[N_ENTRIES]))
        for e in range(words[N_ENTRIES]):
            entries[e] = numbers[e]
        return RUNNING
    if words[OWN_BLOCK] != 0:
        call_function(given, t, y, entries)
        if raised(given):
            return RAISED
    else:
        call_with(words[ADDRESS], address_of(block), t, y, entries)
    return RUNNING if _are_finite(entries, words[N_ENTRIES]) else BAD_JACOBIAN


@njit(**INTERNAL)
def _are_finite(entries, count):
    for e in range(count):
        if not np.isfinite(entries[e]):
            return False
    return True


@njit(**INTERNAL)
def _spread(given, entries, matrix, n):
    """Put entries in their places; return the bandwidths, for columns of n numbers."""
    words = words_at(given)
    lower = 0
    upper = 0
    for e in range(words[N_ENTRIES]):
        place = words[FIRST + e]
        i = place % n
        j = place // n
        lower = max(lower, i - j)
        upper = max(upper, j - i)
        matrix[place] = entries[e]
    return lower, upper


@njit(**INTERNAL)
def _copy_constant(given, matrix, n):
    numbers = numbers_at(given + 8 * FIRST)
    for i in range(n):
        for j in range(n):
            matrix[j * n + i] = numbers[i * n + j]


@njit(**INTERNAL)
def _transpose(matrix, n):
    for i in range(n):
        for j in range(i):
            a = i * n + j
            b = j * n + i
            matrix[a], matrix[b] = matrix[b], matrix[a]
