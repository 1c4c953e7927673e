"""The iteration matrix dF/dy + c dF/dy' of a residual, exact or by differences, and its solution.

The block of the Jacobian of a residual has, behind the words of `calls/block.py`:

- the bandwidths of the matrix;
- the places of the elements of the matrix, column by column, and the rows of the elements;
- for each column, the index of its first element, and its group, for differences;
- for each entry of the exact Jacobian, the place of the element to which the entry is added.  The
  function of the exact Jacobian fills first the entries of dF/dy, then the entries of dF/dy'.
"""

import numpy as np

from ...algebra.matrices import factorise_sum, matrix_at, matrix_rows
from ...calls.block import (
    ADDRESS,
    FIRST,
    GROUPS,
    JACOBIAN,
    N_ENTRIES,
    N_RATE,
    N_STATE,
    RAISED_WORD,
)
from ...calls.user_function import address_of, call_with, words_at
from ...jit.options import INLINED, INTERNAL, njit
from ...state.record import BAD_JACOBIAN, RAISED, RUNNING, SINGULAR, STAGE
from ...state.rows import copy_row, numbers_from, slot
from ...stepping.differences import evaluate_row
from .past import (
    FACTORED,
    FOUND,
    FREE,
    PIVOTS,
    PREDICTED,
    PREDICTED_RATE,
    RESIDUAL,
    TRIAL,
    TRIAL_RATE,
    WEIGHT,
    J,
    in_halves,
)

BELOW = FIRST
ABOVE = FIRST + 1
PLACES = FIRST + 2
STEP = float(np.sqrt(np.finfo(float).eps))


@njit(**INLINED)
def factors_at(block, rows):
    return J + matrix_rows(block, rows.shape[1])


@njit(**INTERNAL)
def clear(s, block, rows):
    """Fill the band of the matrix with zeros, and store the bandwidths."""
    words = words_at(block[JACOBIAN])
    s.lower = words[BELOW]
    s.upper = words[ABOVE]
    for r in range(J, factors_at(block, rows)):
        for i in range(rows.shape[1]):
            rows[r, i] = 0.0


@njit(**INTERNAL)
def renew(rhs, s, t, c, work, block):
    """The matrix and its factors at the predicted state; RUNNING or a failure."""
    rows = in_halves(work)
    n = rows.shape[1]
    for i in range(n):
        rows[TRIAL, i], rows[TRIAL_RATE, i] = rows[PREDICTED, i], rows[PREDICTED_RATE, i]
    s.n_jacobians += 1
    status = BAD_JACOBIAN
    if words_at(block[JACOBIAN])[ADDRESS] != 0:
        status = _add_entries(t, c, work, block, rows)
    if status == BAD_JACOBIAN:
        status = _differences(rhs, s, t, c, work, block, rows)
    if status != RUNNING:
        return status
    rows[FACTORED, 0] = c
    regular = factorise_sum(s, rows, block, J, factors_at(block, rows), PIVOTS, 1.0, 0.0)
    if block[RAISED_WORD] != 0:  # the library behind a sparse matrix
        return RAISED
    s.factorised = 1 if regular else 0
    if regular:
        return RUNNING
    # If F raises, exact elements have no meaning.
    return SINGULAR if evaluate_row(rhs, t, work, STAGE, FOUND, block) else RAISED


@njit(**INTERNAL)
def _add_entries(t, c, work, block, rows):
    """Add the exact entries to the matrix; BAD_JACOBIAN if an entry is not finite."""
    words = words_at(block[JACOBIAN])
    matrix = matrix_at(rows, block, J)
    m = words[N_ENTRIES]
    n_state = words[N_STATE]
    n_rate = words[N_RATE]
    entries = numbers_from(rows, factors_at(block, rows), 0)
    call_with(words[ADDRESS], address_of(block), t, slot(None, work, STAGE), entries)
    to = PLACES + 2 * m + 2 * rows.shape[1] + 1
    for e in range(m):
        matrix[words[PLACES + e]] = 0.0
    finite = True
    for e in range(n_state + n_rate):
        x = entries[e] if e < n_state else c * entries[e]
        finite = finite and np.isfinite(x)
        matrix[words[to + e]] += x
    return RUNNING if finite else BAD_JACOBIAN


@njit(**INTERNAL)
def _differences(rhs, s, t, c, work, block, rows):
    """Fill the matrix by forward differences, one for each group; RUNNING or a failure."""
    words = words_at(block[JACOBIAN])
    matrix = matrix_at(rows, block, J)
    m = words[N_ENTRIES]
    n = rows.shape[1]
    begins = PLACES + 2 * m
    groups = PLACES + 2 * m + n + 1
    if not evaluate_row(rhs, t, work, STAGE, FOUND, block):
        return RAISED
    copy_row(rows[RESIDUAL], rows[FREE])
    s.n_extra += 1 + words[GROUPS]
    for g in range(words[GROUPS]):
        for j in range(n):
            if words[groups + j] == g:
                step = _increment(rows, c, j)
                rows[TRIAL, j] += step
                rows[TRIAL_RATE, j] += c * step
        if not evaluate_row(rhs, t, work, STAGE, FOUND, block):
            return RAISED
        for j in range(n):
            if words[groups + j] != g:
                continue
            step = rows[TRIAL, j] - rows[PREDICTED, j]
            for e in range(words[begins + j], words[begins + j + 1]):
                i = words[PLACES + m + e]
                x = (rows[RESIDUAL, i] - rows[FREE, i]) / step
                if not np.isfinite(x):
                    return BAD_JACOBIAN
                matrix[words[PLACES + e]] = x
            rows[TRIAL, j], rows[TRIAL_RATE, j] = rows[PREDICTED, j], rows[PREDICTED_RATE, j]
    return RUNNING


@njit(**INLINED)
def _increment(rows, c, j):
    """The displacement of component j, in the direction of its derivative."""
    here = rows[PREDICTED, j]
    rate = rows[PREDICTED_RATE, j] / c
    step = STEP * max(abs(here), abs(rate), 1.0 / rows[WEIGHT, j])
    step = -step if rate < 0.0 else step
    return (here + step) - here
