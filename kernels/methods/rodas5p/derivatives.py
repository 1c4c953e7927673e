"""The derivatives df/dy and df/dt at the start of a step of Rodas5P; the rows of the work array."""

import numpy as np

from ...algebra.mass import widened
from ...calls.block import JACOBIAN, MASS, N_ENTRIES
from ...calls.user_function import words_at
from ...jit.options import INTERNAL, njit
from ...state.record import RAISED, RUNNING, K, Y
from ...stepping.differences import evaluate_row, first_factors, keep_factors
from ...stepping.jacobian import clear_matrix, entries_at, evaluate_jacobian, is_constant, is_exact
from ...vector.scalar_or_vector import spacing

# Rows: the derivative at the start of a step, the stages, df/dt, the combination of stages that M
# multiplies, the combination of derivatives for the end of the step, factors of differences and two
# rows of work space, pivots.
SLOPE, U, TIME, SUM, TOTAL, FACTOR, PIVOTS = (K + i for i in (1, 2, 10, 11, 12, 13, 16))
N_ROWS = 17
J = K + N_ROWS  # first row of the Jacobian; behind lie the factors, and exact entries


@njit(**INTERNAL)
def _time_difference(rhs, s, work, block):
    """df/dt by a one-sided difference of order 2 inside the step; False if a function raised.

    The difference takes one evaluation if f does not change, else two.
    """
    dt = s.direction * max(3e-5 * s.h, 4.0 * spacing(s.t, s.direction))
    near = s.t + dt
    far = s.t + 2.0 * dt
    s.n_extra += 1
    if not evaluate_row(rhs, near, work, Y, TIME, block):
        return False
    same = True
    for i in range(work.shape[1]):
        same = same and work[TIME, i] == work[SLOPE, i]
        work[SUM, i] = work[TIME, i] - work[SLOPE, i]
    if not same:
        s.n_extra += 1
        if not evaluate_row(rhs, far, work, Y, TIME, block):
            return False
    a = near - s.t
    b = far - s.t
    for i in range(work.shape[1]):
        rise = work[TIME, i] - work[SLOPE, i]
        work[TIME, i] = (b * b * work[SUM, i] - a * a * rise) / (a * b * (b - a))
    return True


@njit(**INTERNAL)
def derive(rhs, s, work, block):
    """The Jacobian and the time derivative at the present state; RUNNING or a failure."""
    n = work.shape[1]
    given = block[JACOBIAN]
    if s.order == 0:
        clear_matrix(work, block, J)
        first_factors(work, FACTOR)
    if s.order == 0 or not is_constant(block):
        s.n_jacobians += not is_constant(block)
        status = evaluate_jacobian(s, s.t, work, Y, SLOPE, block, FACTOR, J)
        if status != RUNNING:
            return status
        keep_factors(work, FACTOR)
        s.lower, s.upper = widened(block[MASS], s.lower, s.upper)
    s.order = 5
    finite = False
    if is_exact(given):
        behind = entries_at(work, block, J)[words_at(given)[N_ENTRIES] :]
        finite = True
        for i in range(n):
            work[TIME, i] = behind[i]
            finite = finite and np.isfinite(behind[i])
    if not finite and not _time_difference(rhs, s, work, block):
        return RAISED
    return RUNNING
