"""BDF of orders 1 to 5 for F(t, y, y') = 0, with fixed leading coefficient and variable steps.

K. E. Brenan, S. L. Campbell and L. R. Petzold, "Numerical Solution of Initial-Value Problems in
Differential-Algebraic Equations", SIAM 1996, chapter 5: formula, errors, order and size.  A. C.
Hindmarsh and others, "SUNDIALS", ACM TOMS 31 (2005), section 2.3: Newton's iteration, the reuse of
its matrix, and its test of convergence.

A row of the work array has 2 n numbers, [y, y'], so that outputs contain y and y'.
"""

import numpy as np

from ...algebra.matrices import solve_sum
from ...calls.block import RAISED_WORD
from ...jit.options import INLINED, INTERNAL, njit
from ...state.record import (
    NO_TOLERANCE,
    NOT_CONVERGED,
    RAISED,
    RUNNING,
    STAGE,
    STEP_TOO_SMALL,
    Y_OLD,
    Y,
)
from ...state.rows import copy_row
from ...stepping import first_step
from ...stepping.differences import evaluate_row
from ...stepping.implicit import weigh
from ..implicit import implicit
from .control import after_failures, next_order_and_size, order_below
from .matrix import clear, factors_at, renew
from .past import (
    ABSOLUTE,
    BOUND,
    CHANGE,
    CLIMBS,
    FACTORED,
    FOUND,
    FREE,
    MAX_ORDER,
    N_ROWS,
    PHI,
    PIVOTS,
    PREDICTED,
    PREDICTED_RATE,
    PSI,
    RATE,
    RELATIVE,
    RESIDUAL,
    RISE,
    SLOPE,
    SLOPES,
    STATE,
    TRIAL,
    TRIAL_RATE,
    USED,
    WEIGHT,
    J,
    coefficients,
    dense_rows,
    fill_coefficients,
    in_halves,
    norm,
    predict,
)

MAX_ITERATIONS, DIVERGES = 4, 0.9  # as in IDA
NEWTON = 0.33  # the error that Newton's iteration may leave, in units of the tolerance
TINY = 1e-4 * NEWTON  # the iteration ends after a first change below this size
LEAST_RATIO = 0.6  # least ratio of the present dy'/dy to the dy'/dy of the factors in use
FRESH, OTHER = 20.0, 100.0  # Newton's error over its last change: with new factors, with old ones
LONG, SHORT = 1e-3, 0.5  # the first step: a share of the span, and the most that the state moves


@njit(**INTERNAL)
def start(state, work, block, order, fsal_stage):
    """The start kernel: y' is given, and nothing is evaluated."""
    first_step.forget(state[0], 0)
    rows = in_halves(work)
    copy_row(rows[RATE], rows[SLOPES])
    return RUNNING


@njit(**INTERNAL)
def begin(rhs, state, work, block):
    """Begin with order 1; see `implicit.kernel`."""
    s = state[0]
    rows = in_halves(work)
    s.order = 1
    rows[USED, 0] = 0.0
    rows[CLIMBS, 0] = 1.0
    rows[BOUND, 0] = FRESH
    clear(s, block, rows)
    if not weigh(rows, STATE, WEIGHT, RELATIVE, ABSOLUTE):
        return NO_TOLERANCE
    if s.h <= 0.0:
        s.h = LONG * abs(s.t_end - s.t)
        rate = norm(rows, RATE, RATE, 0.0, PHI)
        if rate * s.h > SHORT:
            s.h = SHORT / rate
        if not np.isfinite(s.h):  # the state is at rest, and the span has no end
            s.h = 1.0
    return RUNNING


@njit(**INTERNAL)
def _iterate(rhs, s, t, c, work, block):
    """Newton's iteration from the predicted state: RUNNING, NOT_CONVERGED or RAISED."""
    rows = in_halves(work)
    n = rows.shape[1]
    factors = factors_at(block, rows)
    ratio = c / rows[FACTORED, 0]
    for i in range(n):
        rows[RISE, i] = 0.0
        rows[TRIAL, i], rows[TRIAL_RATE, i] = rows[PREDICTED, i], rows[PREDICTED_RATE, i]
    first = 0.0
    for k in range(MAX_ITERATIONS):
        s.n_extra += 1
        if not evaluate_row(rhs, t, work, STAGE, FOUND, block):
            return RAISED
        for i in range(n):
            rows[CHANGE, i] = -rows[RESIDUAL, i] * (2.0 / (1.0 + ratio))
        solve_sum(s, rows, block, J, factors, PIVOTS, CHANGE, FREE)
        if block[RAISED_WORD] != 0:
            return RAISED
        size = norm(rows, CHANGE, CHANGE, 0.0, PHI)
        if not np.isfinite(size):
            return NOT_CONVERGED
        for i in range(n):
            rows[RISE, i] += rows[CHANGE, i]
            rows[TRIAL, i] = rows[PREDICTED, i] + rows[RISE, i]
            rows[TRIAL_RATE, i] = rows[PREDICTED_RATE, i] + c * rows[RISE, i]
        if k == 0:
            first = size
            if size <= TINY:
                return RUNNING
        else:
            rate = (size / first) ** (1.0 / k)
            if rate > DIVERGES:
                return NOT_CONVERGED
            rows[BOUND, 0] = rate / (1.0 - rate)
        if rows[BOUND, 0] * size <= NEWTON:
            return RUNNING
    return NOT_CONVERGED


@njit(**INTERNAL)
def _solve_formula(rhs, s, t, c, work, block):
    """Solve the equations of a step, with new factors if necessary; RUNNING or a failure."""
    rows = in_halves(work)
    if s.factorised:
        ratio = c / rows[FACTORED, 0]
        if LEAST_RATIO <= ratio <= 1.0 / LEAST_RATIO:
            if ratio != 1.0:
                rows[BOUND, 0] = OTHER
            status = _iterate(rhs, s, t, c, work, block)
            if status != NOT_CONVERGED:
                return status
    rows[BOUND, 0] = FRESH
    status = renew(rhs, s, t, c, work, block)
    return _iterate(rhs, s, t, c, work, block) if status == RUNNING else status


@njit(**INTERNAL)
def step(rhs, state, work, block, h_min):
    """One step; see `implicit.kernel`."""
    s = state[0]
    rows = in_halves(work)
    v = coefficients()
    if not weigh(rows, STATE, WEIGHT, RELATIVE, ABSOLUTE):
        return NO_TOLERANCE
    size = s.h_max if s.h > s.h_max else max(s.h, h_min)
    n_failed = 0
    last = STEP_TOO_SMALL
    while size >= h_min:
        t_new = s.t + size * s.direction
        if s.direction * (t_new - s.t_end) > 0.0:
            t_new = s.t_end
            size = abs(t_new - s.t)
        h = size * s.direction
        if rows[USED, 0] == 0.0:
            _first_differences(rows, h)
        order = s.order
        c, of_error = fill_coefficients(rows, order, h, v)
        predict(rows, order, v)
        status = _solve_formula(rhs, s, t_new, c, work, block)
        if status == RAISED or block[RAISED_WORD] != 0:
            return RAISED
        if status != RUNNING:
            last = status
            rows[CLIMBS, 0] = 0.0
            s.n_rejected += 1
            size *= 0.25
            continue
        s.error = of_error * norm(rows, RISE, RISE, 0.0, PHI)
        below = order_below(rows, order, v)
        if s.error <= 1.0:
            _accept(s, work, rows, t_new, size)
            next_order_and_size(s, rows, below, v)
            return RUNNING
        n_failed += 1
        last = STEP_TOO_SMALL
        rows[CLIMBS, 0] = 0.0
        s.n_rejected += 1
        size *= after_failures(s, below, n_failed)
    return last


@njit(**INLINED)
def _first_differences(rows, h):
    """Store the state and its derivative as the past before the first step."""
    for i in range(rows.shape[1]):
        rows[PHI, i], rows[PHI + 1, i] = rows[STATE, i], h * rows[RATE, i]
    rows[PSI, 0] = h


@njit(**INLINED)
def _accept(s, work, rows, t_new, size):
    """Store the new state and its derivative."""
    copy_row(work[Y], work[Y_OLD])
    copy_row(work[STAGE], work[Y])
    copy_row(rows[RATE], rows[SLOPES])
    equal = size == s.h_old and s.order == int(rows[USED, 0])
    s.n_equal = min((s.n_equal if equal else 0) + 1, int(rows[USED, 0]) + 2)
    s.t_old = s.t
    s.t = t_new
    s.h_old = size


RESIDUAL_BDF = implicit(
    "BDF of residuals", step, SLOPE, begin, start=start, order=MAX_ORDER, error_order=1,
    n_rows=N_ROWS, n_matrices=3, dense_rows=dense_rows, dense_order=MAX_ORDER,
    projects=False, cost=8,
)  # fmt: skip
