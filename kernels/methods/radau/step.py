"""Radau: the Radau IIA method of order 5 with SciPy's control of step and iteration.

E. Hairer and G. Wanner, "Solving Ordinary Differential Equations II: Stiff and
Differential-Algebraic Problems", second edition, section IV.8: coefficients, transformation, the
error estimate of order 3, the choice of the step.

The state record and the rows of the work array carry all data from one step to the next.
`stages.py` names the rows.
"""

import numpy as np

from ...algebra.mass import add_product
from ...calls.block import MASS, RAISED_WORD
from ...jit.options import INLINED, INTERNAL, njit
from ...output.arguments import JACOBIAN
from ...output.dense_output import F as DENSE
from ...state.record import RAISED, RUNNING, STAGE, STEP_TOO_SMALL, Y_OLD, Y
from ...state.rows import copy_row
from ...stepping.differences import evaluate_row, first_factors
from ...stepping.implicit import (
    beyond,
    n_components,
    newton_tolerance,
    scaled_squares,
    take_larger,
)
from ...stepping.jacobian import clear_matrix, is_constant
from ...stepping.step_size import MAX_FACTOR, MIN_FACTOR, SAFETY
from ..implicit import implicit
from .stages import (
    CORRECTION,
    ERROR,
    FACTOR,
    MAX_ITERATIONS,
    MOST,
    N_ROWS,
    ROOT,
    SLOPE,
    C,
    J,
    P,
    Q,
    Z,
    renew_jacobian,
    solve_real,
    solve_stages,
)

E = ((-13 - 7 * ROOT) / 3, (-13 + 7 * ROOT) / 3, -1 / 3)


@njit(**INTERNAL)
def _error(s, work, block):
    """Solve for the error, with the right-hand side in row ERROR; return the norm of the error.

    The new state is Y + Z[2].
    """
    n = work.shape[1]
    solve_real(s, work, block, ERROR)
    if s.pairs:
        for i in range(0, n, 2):
            re = work[Y, i] + work[Z + 2, i]
            im = work[Y, i + 1] + work[Z + 2, i + 1]
            work[STAGE, i] = max(np.hypot(work[Y, i], work[Y, i + 1]), np.hypot(re, im))
            work[STAGE, i + 1] = 0.0
    else:
        for i in range(n):
            work[STAGE, i] = max(abs(work[Y, i]), abs(work[Y, i] + work[Z + 2, i]))
    return np.sqrt(scaled_squares(s, work, ERROR, STAGE) / n_components(s, work))


@njit(**INTERNAL)
def _estimate(rhs, s, work, block, h, rejected):
    """The norm of the error of a step, estimated twice if the step before was rejected."""
    n = work.shape[1]
    for i in range(n):
        rise = work[Z, i] * E[0] + work[Z + 1, i] * E[1] + work[Z + 2, i] * E[2]
        work[CORRECTION, i] = rise / h
    if block[MASS] != 0:
        copy_row(work[CORRECTION], work[STAGE])
        for i in range(n):
            work[CORRECTION, i] = 0.0
        add_product(block[MASS], work[STAGE], work[CORRECTION])
    for i in range(n):
        work[ERROR, i] = work[SLOPE, i] + work[CORRECTION, i]
    error = _error(s, work, block)
    if rejected and error > 1.0:
        for i in range(n):
            work[STAGE, i] = work[Y, i] + work[ERROR, i]
        s.n_extra += 1
        evaluate_row(rhs, s.t, work, STAGE, ERROR, block)
        for i in range(n):
            work[ERROR, i] += work[CORRECTION, i]
        error = _error(s, work, block)
    return error


@njit(**INTERNAL)
def _factor(h, h_old, error, error_old):
    """The factor by which the step may grow, from two steps, after Gustafsson."""
    ratio = 1.0
    if h_old > 0.0 and error != 0.0:
        ratio = h / h_old * (error_old / error) ** 0.25
    return min(1.0, ratio) * error**-0.25


@njit(**INTERNAL)
def _go_on(rhs, s, work, block, t_new, size, factor, error, n_iterations, rate):
    """Accept a step; RUNNING, RAISED or BAD_JACOBIAN."""
    for i in range(work.shape[1]):
        a = work[Z, i]
        b = work[Z + 1, i]
        c = work[Z + 2, i]
        for r in range(3):
            work[Q + r, i] = P[0, r] * a + P[1, r] * b + P[2, r] * c
        work[STAGE, i] = work[Y, i] + c
    if block[MASS] == 0:
        s.n_standing += beyond(work, STAGE, MOST, t_new - s.t)
    copy_row(work[Y], work[Y_OLD])
    copy_row(work[STAGE], work[Y])
    s.t_old = s.t
    s.t = t_new
    s.n_equal += 1
    s.n_extra += 1
    if not evaluate_row(rhs, t_new, work, Y, SLOPE, block):
        return RAISED
    status = RUNNING
    varies = not is_constant(block)
    renew = varies and n_iterations > 2 and rate > 1e-3
    factor = min(MAX_FACTOR, factor)
    if not renew and factor < 1.2:
        factor = 1.0
    else:
        s.factorised = 0
    if varies:
        s.current = 0
    if renew:
        status = renew_jacobian(rhs, s, work, block)
    s.h_old = s.h
    s.error = error
    s.h = size * factor
    return status


@njit(**INTERNAL)
def begin(rhs, state, work, block):
    """Begin with a Jacobian and without a past; see `implicit.kernel`."""
    s = state[0]
    s.order = 5
    s.n_equal = 0
    s.h_old = 0.0
    clear_matrix(work, block, J)
    if block[MASS] != 0:
        first_factors(work, FACTOR)
    return renew_jacobian(rhs, s, work, block)


@njit(**INTERNAL)
def step(rhs, state, work, block, h_min):
    """One step; see `implicit.kernel`."""
    s = state[0]
    status = RUNNING
    tolerance = newton_tolerance(work)
    size = s.h
    h_old = s.h_old
    rejected = False
    for i in range(work.shape[1]):
        work[MOST, i] = 0.0
    take_larger(work, MOST, SLOPE)
    if size > s.h_max or size < h_min:
        size = s.h_max if size > s.h_max else h_min
        h_old = 0.0
    while status == RUNNING:
        if size < h_min:
            return STEP_TOO_SMALL
        t_new = s.t + size * s.direction
        wanted = size
        if s.direction * (t_new - s.t_end) > 0.0:
            t_new = s.t_end
        h = t_new - s.t
        size = abs(h)
        found = solve_stages(rhs, s, work, block, h, tolerance)
        status, converged, n_iterations, rate = found
        if status != RUNNING:
            break
        if not converged:
            size *= 0.5
            s.factorised = 0
            s.n_rejected += 1
            continue
        error = _estimate(rhs, s, work, block, h, rejected)
        if block[RAISED_WORD] != 0:
            return RAISED
        safety = SAFETY * (2 * MAX_ITERATIONS + 1) / (2 * MAX_ITERATIONS + n_iterations)
        factor = safety * _factor(size, h_old, error, s.error)
        if not error > 1.0:
            given = t_new, size, factor, error, n_iterations, rate
            status = _go_on(rhs, s, work, block, *given)
            if t_new == s.t_end:  # the step was shortened to reach t_end, not for its error
                s.h = max(s.h, wanted)
            return status
        size *= max(MIN_FACTOR, factor)
        s.factorised = 0
        rejected = True
        s.n_rejected += 1
    return status


@njit(**INLINED)
def dense_rows(rhs, t, h, work, block, d):
    """The polynomial through the stages, in the form of `dense_output.py`; 0 evaluations."""
    for i in range(work.shape[1]):
        d[DENSE + 1, i] = -work[Q + 1, i] - work[Q + 2, i]
        d[DENSE + 2, i] = -work[Q + 2, i]
    return 0


ABSCISSAE = tuple(map(float, C))
RADAU = implicit(
    "Radau", step, SLOPE, begin, before_events=JACOBIAN, order=5, error_order=3,
    n_rows=N_ROWS, n_matrices=4, complex_matrices=True, dense_rows=dense_rows, dense_order=3,
    on_pairs=True, takes_mass=True, cost=20, looks=ABSCISSAE,
    backward="collocation",
)  # fmt: skip
