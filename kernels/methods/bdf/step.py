"""BDF: the numerical differentiation formulas of orders 1 to 5 in quasi-constant steps, as SciPy's.

L. F. Shampine and M. W. Reichelt, "The MATLAB ODE suite", SIAM J. Sci. Comput. 18 (1997): the
formulas with their constants kappa, and the change of the step.  E. Hairer, S. P. Norsett and G.
Wanner, "Solving Ordinary Differential Equations I", section III.2: the error constants.

The past is kept as backward differences D[j] for steps of size h_old.  If the step size changes,
the differences are changed when the next step begins: until then, the differences give the
polynomial of the last step.
"""

import numpy as np

from ...algebra.mass import add_product, widened
from ...algebra.matrices import factorise_sum, matrix_rows, solve_sum
from ...calls.block import MASS, RAISED_WORD
from ...jit.options import INLINED, INTERNAL, njit
from ...output.arguments import JACOBIAN
from ...state.record import RAISED, RUNNING, STAGE, STEP_TOO_SMALL, Y_OLD, K, Y
from ...state.rows import copy_row
from ...stepping import first_step
from ...stepping.differences import evaluate_row, first_factors, keep_factors
from ...stepping.implicit import (
    beyond,
    n_components,
    newton_tolerance,
    scaled_squares,
    take_larger,
)
from ...stepping.jacobian import (
    clear_matrix,
    evaluate_jacobian,
    is_constant,
    takes_slope,
)
from ...stepping.step_size import MAX_FACTOR, MIN_FACTOR, SAFETY
from ..implicit import implicit
from .differences import ALPHA, ERROR, GAMMA, MAX_ORDER, ORDER, D, change_size, dense_rows

MAX_ITERATIONS = 4  # as in SciPy
KEPT = 0.8  # share of the largest |f| of past steps, from which a step of BDF follows, too

# Rows: the derivative, the known terms of the formula, the predicted state, the change of the state
# in one iteration, the change in all iterations, factors of differences and two rows of work space,
# pivots, the largest |f| in the last steps.
SLOPE, PSI, PREDICTED, CHANGE, RISE, FACTOR, PIVOTS, MOST = (
    K + i for i in (1, 10, 11, 12, 13, 14, 17, 18)
)
N_ROWS = 19
J = K + N_ROWS  # the first row of the Jacobian; the factors of I - c J lie behind the Jacobian


@njit(**INTERNAL)
def _factorise(s, work, block, c):
    factors = J + matrix_rows(block, work.shape[1])
    factorise_sum(s, work, block, J, factors, PIVOTS, -c, 1.0)
    s.factorised = 1


@njit(**INTERNAL)
def _renew_jacobian(rhs, s, t, work, block, y):
    """The Jacobian at the state in row y; RUNNING, RAISED or BAD_JACOBIAN."""
    s.current = 1
    s.factorised = 0
    s.n_jacobians += not is_constant(block)
    if takes_slope(block) and not evaluate_row(rhs, t, work, y, CHANGE, block):
        return RAISED
    status = evaluate_jacobian(s, t, work, y, CHANGE, block, FACTOR, J)
    if block[MASS] != 0:
        keep_factors(work, FACTOR)
        s.lower, s.upper = widened(block[MASS], s.lower, s.upper)
    return status


@njit(**INLINED)
def _residual(work, block, c):
    """c f - M (psi + rise), in the row of f."""
    n = work.shape[1]
    if block[MASS] != 0:
        for i in range(n):
            work[CHANGE, i] *= c
            work[FACTOR + 1, i] = -work[PSI, i] - work[RISE, i]
        add_product(block[MASS], work[FACTOR + 1], work[CHANGE])
        return
    for i in range(n):
        work[CHANGE, i] = c * work[CHANGE, i] - work[PSI, i] - work[RISE, i]


@njit(**INTERNAL)
def _iterate(rhs, s, t, work, block, c, tolerance):
    """Newton's iteration from the predicted state: (converged, iterations).

    The new state is in row STAGE, its distance from the predicted state in row RISE.
    """
    n = work.shape[1]
    copy_row(work[PREDICTED], work[STAGE])
    for i in range(n):
        work[RISE, i] = 0.0
    before = 0.0
    for k in range(MAX_ITERATIONS):
        s.n_extra += 1
        if not evaluate_row(rhs, t, work, STAGE, CHANGE, block):
            return False, k + 1
        for i in range(n):
            if not np.isfinite(work[CHANGE, i]):
                return False, k + 1
        take_larger(work, MOST, CHANGE)
        _residual(work, block, c)
        solve_sum(s, work, block, J, J + matrix_rows(block, n), PIVOTS, CHANGE, FACTOR + 1)
        size = np.sqrt(scaled_squares(s, work, CHANGE, PREDICTED) / n_components(s, work))
        rate = size / before if k > 0 else 0.0
        if rate >= 1.0 or (
            k > 0 and rate ** (MAX_ITERATIONS - k) / (1.0 - rate) * size > tolerance
        ):
            return False, k + 1
        for i in range(n):
            work[STAGE, i] += work[CHANGE, i]
            work[RISE, i] += work[CHANGE, i]
        if size == 0.0 or (k > 0 and rate / (1.0 - rate) * size < tolerance):
            return True, k + 1
        before = size
    return False, MAX_ITERATIONS


@njit(**INTERNAL)
def _solve_formula(rhs, s, t, work, block, h, tolerance):
    """The state at t, the end of a step of size h: (status, converged, iterations)."""
    order = s.order
    n = work.shape[1]
    total = work[PREDICTED]
    psi = work[PSI]
    copy_row(work[D], total)
    for i in range(n):
        psi[i] = 0.0
    for j in range(1, order + 1):  # row by row, in vectors
        difference = work[D + j]
        for i in range(n):
            total[i] += difference[i]
            psi[i] += difference[i] * GAMMA[j]
    for i in range(n):
        psi[i] /= ALPHA[order]
    c = h / ALPHA[order]
    while True:
        if s.factorised == 0:
            _factorise(s, work, block, c)
        converged, n_iterations = _iterate(rhs, s, t, work, block, c, tolerance)
        status = RAISED if block[RAISED_WORD] != 0 else RUNNING
        if status == RUNNING and not converged and s.current == 0:
            status = _renew_jacobian(rhs, s, t, work, block, PREDICTED)
            if status == RUNNING:
                continue
        return status, converged, n_iterations


@njit(**INLINED)
def _norm(s, work, row, order):
    """The norm of the error of a formula of this order, from a difference of order + 1."""
    return abs(ERROR[order]) * np.sqrt(scaled_squares(s, work, row, Y) / n_components(s, work))


@njit(**INTERNAL)
def _next_order(s, work, error, safety):
    """Choose order and size of the next steps, after order + 1 equal steps."""
    order = s.order
    best = error ** (-1.0 / (s.order + 1))
    chosen = s.order
    if order > 1:
        lower = _norm(s, work, D + order, order - 1) ** (-1.0 / order)
        if lower >= best:
            best = lower
            chosen = order - 1
    if order < MAX_ORDER:
        higher = _norm(s, work, D + order + 2, order + 1) ** (-1.0 / (order + 2))
        if higher > best:
            best = higher
            chosen = order + 1
    s.order = chosen
    s.h *= min(MAX_FACTOR, safety * best)
    s.n_equal = s.factorised = 0


@njit(**INTERNAL)
def _go_on(s, work, block, t_new, h, error, safety):
    """Accept a step."""
    order = s.order
    c = h / ALPHA[order]
    if block[MASS] == 0:
        s.n_standing += beyond(work, STAGE, MOST, h)
    copy_row(work[Y], work[Y_OLD])
    copy_row(work[STAGE], work[Y])
    for i in range(work.shape[1]):
        work[SLOPE, i] = (work[PSI, i] + work[RISE, i]) / c
        work[D + order + 2, i] = work[RISE, i] - work[D + order + 1, i]
        work[D + order + 1, i] = work[RISE, i]
    for j in range(order, -1, -1):
        difference = work[D + j]
        higher = work[D + j + 1]
        for i in range(work.shape[1]):
            difference[i] += higher[i]
    s.t_old = s.t
    s.t = t_new
    s.n_equal += 1
    s.h = s.h_old = abs(h)
    s.error = error
    if s.n_equal > order:
        _next_order(s, work, error, safety)
    work[ORDER, 0] = s.order


@njit(**INTERNAL)
def begin(rhs, state, work, block):
    """Begin with order 1; see `implicit.kernel`."""
    s = state[0]
    if s.t != s.t_old:  # behind a breakpoint
        s.h = s.h_first
        status = first_step.implicit(state, work, block, 1, SLOPE - K)
        if status != RUNNING:
            return status
    s.order = 1
    s.n_equal = 0
    for i in range(work.shape[1]):
        work[D, i] = work[Y, i]
        # f is not the slope of M y' = f
        work[D + 1, i] = 0.0 if block[MASS] != 0 else work[SLOPE, i] * s.h * s.direction
        for j in range(2, MAX_ORDER + 3):
            work[D + j, i] = 0.0
    s.h_old = s.h
    for i in range(work.shape[1]):
        work[MOST, i] = abs(work[SLOPE, i])
    clear_matrix(work, block, J)
    if block[MASS] != 0:
        first_factors(work, FACTOR)
    return _renew_jacobian(rhs, s, s.t, work, block, Y)


@njit(**INTERNAL)
def step(rhs, state, work, block, h_min):
    """One step; see `implicit.kernel`."""
    s = state[0]
    tolerance = newton_tolerance(work)
    s.current = 1 if is_constant(block) else 0
    for i in range(work.shape[1]):
        work[MOST, i] *= KEPT
    size = s.h_max if s.h > s.h_max else max(s.h, h_min)
    while size >= h_min:
        t_new = s.t + size * s.direction
        if s.direction * (t_new - s.t_end) > 0.0:
            t_new = s.t_end
            size = abs(t_new - s.t)
            s.factorised = 0
        if size != s.h_old:
            change_size(work, s.order, size / s.h_old)
            s.h_old = size
            s.n_equal = 0
        h = t_new - s.t
        size = s.h_old = abs(h)
        found = _solve_formula(rhs, s, t_new, work, block, h, tolerance)
        status, converged, n_iterations = found
        if status != RUNNING:
            return status
        if not converged:
            size *= 0.5
            s.factorised = 0
            s.n_rejected += 1
            continue
        safety = SAFETY * (2 * MAX_ITERATIONS + 1) / (2 * MAX_ITERATIONS + n_iterations)
        squares = scaled_squares(s, work, RISE, STAGE)
        error = abs(ERROR[s.order]) * np.sqrt(squares / n_components(s, work))
        if not error > 1.0:
            _go_on(s, work, block, t_new, h, error, safety)
            return RUNNING
        size *= max(MIN_FACTOR, safety * error ** (-1.0 / (s.order + 1)))
        s.n_rejected += 1
    return STEP_TOO_SMALL


BDF = implicit(
    "BDF", step, SLOPE, begin, before_events=JACOBIAN, order=5, error_order=1,
    n_rows=N_ROWS, n_matrices=2, dense_rows=dense_rows, dense_order=5,
    on_pairs=True, takes_mass=True, projects=False, cost=8, past=D, n_past=MAX_ORDER + 3,
    looks=(1.0,),
)  # fmt: skip
