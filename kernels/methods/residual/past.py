"""The past of the BDF of residuals: modified divided differences, coefficients, prediction.

K. E. Brenan, S. L. Campbell and L. R. Petzold, "Numerical Solution of Initial-Value Problems in
Differential-Algebraic Equations", SIAM 1996, section 5.2: the predictor polynomial through the last
order + 1 states, on steps of any size, and the corrector with fixed leading coefficient.

All rows here have n numbers, half a row of the work array: see `in_halves`.
"""

import numpy as np
from numba import carray

from ...calls.user_function import address_of, numbers_at
from ...jit.options import INLINED, INTERNAL, njit
from ...output.dense_output import F as DENSE
from ...output.dense_output import nest
from ...state.record import ATOL, RTOL, STAGE, Y_OLD, K, Y
from ...state.rows import scratch

MAX_ORDER = 5
SIZE = MAX_ORDER + 1

# Whole rows of the work array: the derivative of the state (and zeros), the residual (and zeros).
SLOPE = K
FOUND = K + 1
# Rows of n numbers: the state and its derivative; the state before; the state and the derivative of
# a trial; tolerances; the derivative; the residual.
STATE = 2 * Y
RATE = 2 * Y + 1
STATE_OLD = 2 * Y_OLD
TRIAL = 2 * STAGE
TRIAL_RATE = 2 * STAGE + 1
RELATIVE = 2 * RTOL
ABSOLUTE = 2 * ATOL
SLOPES = 2 * SLOPE
RESIDUAL = 2 * FOUND
# The divided differences PHI[j]; the predicted state and its derivative; the change of the state in
# one iteration, the change in all iterations; 1 / tolerance; pivots; a free row.
PHI = 2 * (K + 2)
PREDICTED, PREDICTED_RATE, CHANGE, RISE, WEIGHT, PIVOTS, FREE = (PHI + SIZE + i for i in range(7))
# Rows with one number each: the times PSI[j] from the state j + 1 steps before to the end of the
# last step; the order of the last step, 0 before the first step; whether order and size still grow
# with each step; dy'/dy in the factors; the bound of Newton's error by its last change.
PSI = FREE + 1
USED, CLIMBS, FACTORED, BOUND = (PSI + SIZE + i for i in range(4))
N_ROWS = (BOUND + 2) // 2 - K
J = 2 * (K + N_ROWS)  # the first row of the iteration matrix; its factors lie behind

coefficients = scratch(5 * SIZE)
ALPHA, BETA, GAMMA, SIGMA, NEW_PSI = (i * SIZE for i in range(5))
powers = scratch(SIZE * SIZE)


@njit(**INTERNAL)
def in_halves(work):
    """`work` with two rows for each row: the first half of the row, and the second half."""
    return carray(numbers_at(address_of(work)), (2 * len(work), work.shape[1] // 2))


@njit(**INLINED)
def fill_coefficients(rows, order, h, v):
    """The coefficients of a step of signed size h, in `v`: (d y' / d y, factor of the error)."""
    v[ALPHA] = 1.0
    v[BETA] = 1.0
    v[GAMMA] = 0.0
    v[SIGMA] = 1.0
    distance = h
    leading = 0.0
    alpha_sum = 0.0
    for i in range(1, order + 1):
        before = rows[PSI + i - 1, 0]
        v[NEW_PSI + i - 1] = distance
        v[BETA + i] = v[BETA + i - 1] * distance / before
        distance = before + h
        v[ALPHA + i] = h / distance
        v[SIGMA + i] = i * v[SIGMA + i - 1] * v[ALPHA + i]
        v[GAMMA + i] = v[GAMMA + i - 1] + v[ALPHA + i - 1] / h
        leading += 1.0 / i
        alpha_sum += v[ALPHA + i - 1]
    v[NEW_PSI + order] = distance
    return leading / h, max(abs(v[ALPHA + order] + alpha_sum - leading), v[ALPHA + order])


@njit(**INTERNAL)
def predict(rows, order, v):
    """Evaluate the polynomial of the past, and its derivative, at the end of the step."""
    for i in range(rows.shape[1]):
        state = rows[PHI, i]
        rate = 0.0
        for j in range(1, order + 1):
            difference = v[BETA + j] * rows[PHI + j, i]
            state += difference
            rate += v[GAMMA + j] * difference
        rows[PREDICTED, i] = state
        rows[PREDICTED_RATE, i] = rate


@njit(**INLINED)
def norm(rows, row, more, factor, less):
    """The norm of ``row + factor more - less`` in units of the tolerance.

    `less` is a row of PHI; PHI itself stands for no row.
    """
    total = 0.0
    for i in range(rows.shape[1]):
        x = rows[row, i] + factor * rows[more, i]
        if less != PHI:
            x -= rows[less, i]
        x *= rows[WEIGHT, i]
        total += x * x
    return np.sqrt(total / rows.shape[1])


@njit(**INTERNAL)
def remember(rows, order, v):
    """Add the step to the differences, and the next difference for a higher order."""
    for i in range(rows.shape[1]):
        rise = rows[RISE, i]
        if order < MAX_ORDER:
            rows[PHI + order + 1, i] = rise
        total = rise
        for j in range(order, -1, -1):
            total += v[BETA + j] * rows[PHI + j, i]
            rows[PHI + j, i] = total
    for j in range(order + 1):
        rows[PSI + j, 0] = v[NEW_PSI + j]
    rows[USED, 0] = order


@njit(**INLINED)
def dense_rows(rhs, t, h, work, block, d):
    """The polynomial through the last states, and its derivative; 0 evaluations."""
    rows = in_halves(work)
    c = powers()
    order = int(rows[USED, 0])
    n = rows.shape[1]
    for e in range(SIZE * SIZE):
        c[e] = 0.0
    c[0] = 1.0
    distance = 0.0
    for j in range(1, order + 1):  # times (h u + distance) / PSI, in powers of u = x - 1
        psi = rows[PSI + j - 1, 0]
        for m in range(j + 1):
            higher = h * c[(j - 1) * SIZE + m - 1] if m > 0 else 0.0
            c[j * SIZE + m] = (higher + distance * c[(j - 1) * SIZE + m]) / psi
        distance = psi
    for m in range(SIZE):
        for i in range(n):
            total = 0.0
            for j in range(m, order + 1):
                total += c[j * SIZE + m] * rows[PHI + j, i]
            d[m, i] = total
            d[m, n + i] = 0.0
            if m > 0:
                d[m - 1, n + i] = m * total / h
    nest(d, order)
    for i in range(n):
        d[0, i], d[DENSE, i] = rows[STATE_OLD, i], rows[STATE, i] - rows[STATE_OLD, i]
    return 0
