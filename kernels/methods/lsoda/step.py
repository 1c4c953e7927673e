"""LSODA: Adams' formulas of orders 1 to 12 or BDF of orders 1 to 5, whichever takes longer steps.

A. C. Hindmarsh, "ODEPACK, a systematized collection of ODE solvers", in Scientific Computing
(1983), and L. Petzold, "Automatic selection of methods for solving stiff and nonstiff systems of
ordinary differential equations", SIAM J. Sci. Stat. Comput. 4 (1983): steps as SciPy's.

The size of the next step is chosen when a step is accepted.  The Nordsieck array is changed to the
new size when the next step begins: until then, the array gives the polynomial of the last step.
"""

import numpy as np

from ...jit.options import INTERNAL, njit
from ...output.arguments import NOTHING
from ...state.record import (
    ATOL,
    FAILED_AGAIN,
    NO_TOLERANCE,
    RAISED,
    RTOL,
    RUNNING,
    STEP_TOO_SMALL,
    Y_OLD,
    Y,
)
from ...state.rows import copy_row
from ...stepping import first_step
from ...stepping.differences import evaluate_row
from ...stepping.implicit import weigh
from ...stepping.jacobian import clear_matrix
from ..implicit import implicit
from .control import (
    AGAIN,
    FIRST_GROWTH,
    GROWTH,
    SHRUNK_GROWTH,
    WAIT,
    change_step,
    highest,
    load_formula,
    next_family,
    next_order,
)
from .corrector import EPS, correct
from .past import (
    CHANGE,
    KEPT,
    N_ROWS,
    ORDER,
    RATE,
    SLOPE,
    WEIGHT,
    J,
    K,
    Z,
    dense_rows,
    norm,
    predict,
    rescale,
    retract,
)
from .table import CORRECTION, SAME

MOST_FAILURES = 10  # as in ODEPACK
# Most steps that do not change the time, unless they double their size; none of them may fail.  A
# component may grow by many powers of ten in such steps, as y does in y' = 1e50 / y from 1e6 on.
MOST_STANDING = 50
RESTARTS = 3  # failures of a step after which the step restarts with order 1
OLD, FAR = 20, 0.3  # steps, and a change of h l0, after which a Jacobian is renewed


@njit(**INTERNAL)
def _begin(state, work, block):
    """Begin with Adams' formula of order 1; RUNNING or a failure."""
    s = state[0]
    if s.t != s.t_old:  # behind a breakpoint
        s.h = s.h_first
        status = first_step.lsoda(state, work, block, 1, SLOPE - K)
        if status != RUNNING:
            return status
    s.stiff = int(s.highest_adams == 0)  # if the user wants BDF alone
    s.order = 1
    s.rescale = 1.0
    s.l0 = 1.0
    s.wait = 2
    s.wait_family = WAIT
    s.growth = FIRST_GROWTH
    s.rate = 0.7
    s.was_stiff = s.stiff  # BDF if steps of BDF were taken back: see `output/borders.py`
    s.limited = s.factorised = s.age = s.n_standing = 0
    s.t_switched = s.t_start
    s.h_standing = s.drift = s.lipschitz = s.lipschitz_now = s.jacobian_norm = 0.0
    h = s.h * s.direction
    for i in range(work.shape[1]):
        work[Z, i] = work[Y, i]
        work[Z + 1, i] = h * work[SLOPE, i]
    clear_matrix(work, block, J)
    return RUNNING


@njit(**INTERNAL)
def _prepare(s, work):
    """Change the Nordsieck array to the chosen step, shortened if it would pass its limit."""
    if s.rescale != 1.0:
        rescale(work, s.order, s.rescale)
        s.rescale = 1.0
    limit = s.t_limit if s.passes_end else s.t_end
    chosen = s.h
    room = abs(limit - s.t)
    beyond = s.direction * (s.t + s.direction * s.h * (1.0 + 4.0 * EPS) - limit)
    if beyond > 0.0 and abs(limit) < np.inf:
        chosen = room * (1.0 - 4.0 * EPS)
    if s.stiff != s.was_stiff:
        s.factorised = 0
        s.wait = s.order + 1
        load_formula(s)
    if chosen != s.h:
        rescale(work, s.order, change_step(s, chosen / s.h))


@njit(**INTERNAL)
def _shorten(s, work, factor):
    """Multiply the step by `factor`, below 1, for another trial."""
    rescale(work, s.order, change_step(s, max(factor, s.h_least / s.h)))


@njit(**INTERNAL)
def _restart(rhs, s, work, block):
    """Prepare a trial with a tenth of the step and order 1; False if the function raised."""
    s.h *= max(s.h_least / s.h, 0.1)
    s.n_extra += 1
    copy_row(work[Z], work[CHANGE])
    if not evaluate_row(rhs, s.t, work, CHANGE, RATE, block):
        return False
    for i in range(work.shape[1]):
        work[Z + 1, i] = s.h * s.direction * work[RATE, i]
    s.factorised = 0
    s.wait = 5
    if s.order > 1:
        s.order = 1
        load_formula(s)
    return True


@njit(**INTERNAL)
def _go_on(s, work, t_new, error, predicted):
    """Accept a step, and choose the next."""
    order = s.order
    n = work.shape[1]
    for j in range(order + 1):
        for i in range(n):
            work[Z + j, i] += CORRECTION[s.stiff, order, j] * work[CHANGE, i]
    copy_row(work[Y], work[Y_OLD])
    copy_row(work[Z], work[Y])
    h = s.h * s.direction
    for i in range(n):
        work[SLOPE, i] = work[Z + 1, i] / h
    s.t_old = s.t
    s.t = t_new
    s.h_old = s.h
    s.error = error
    s.was_stiff = s.stiff
    s.n_equal = order
    s.age += 1
    s.wait_family -= 1
    s.wait -= 1
    factor = next_family(s, work, error, predicted) if s.wait_family < 0 else 0.0
    if factor == 0.0 and s.wait == 0:
        factor = next_order(s, work, error, 0)
        if factor == 0.0:
            s.wait = AGAIN
    elif factor == 0.0 and s.wait == 1 and order < highest(s, s.stiff):
        copy_row(work[CHANGE], work[KEPT])
    if s.stiff != s.was_stiff:
        s.t_switched = t_new
    if factor > 0.0:
        s.rescale = change_step(s, max(factor, s.h_least / s.h))
        s.growth = GROWTH
    work[ORDER, 0] = order
    if s.passes_end:
        if s.order != order:  # ODEPACK interpolates by the order of the next step
            work[ORDER, 0] = -s.order
    elif abs(s.t - s.t_end) <= 100.0 * EPS * (abs(s.t) + s.h):
        s.t = s.t_end


@njit(**INTERNAL)
def step(rhs, state, work, block, h_min):
    """One step; see `implicit.kernel`.  The option `min_step`, not `h_min`, bounds the step."""
    s = state[0]
    if not weigh(work, Y, WEIGHT, RTOL, ATOL):
        return NO_TOLERANCE
    if s.order == 0:
        status = _begin(state, work, block)
        if status != RUNNING:
            return status
    else:
        _prepare(s, work)
    n_failed = n_unsolved = 0
    while True:
        if abs(s.drift - 1.0) > FAR or s.age >= OLD:
            s.factorised = 0
        h = s.h * s.direction
        t_new = s.t + h
        if t_new != s.t or s.h > 2.0 * s.h_standing:
            s.n_standing = 0
            s.h_standing = s.h
        s.n_standing += t_new == s.t
        hopeless = n_failed + n_unsolved > 0 or s.h >= s.h_max
        if s.n_standing > (0 if hopeless else MOST_STANDING):
            return STEP_TOO_SMALL
        predict(work, s.order)
        predicted = norm(work, Z)
        status, converged, n_iterations, change = correct(rhs, s, t_new, work, block, h, predicted)
        if status != RUNNING:
            return status
        error = change if n_iterations == 1 else norm(work, CHANGE)
        error /= SAME[s.stiff, s.order]
        if converged and error <= 1.0:
            _go_on(s, work, t_new, error, predicted)
            return RUNNING
        retract(work, s.order)
        s.n_rejected += 1
        s.growth = SHRUNK_GROWTH
        s.error = error
        n_failed += converged
        n_unsolved += not converged
        shortest = s.h <= s.h_least * 1.00001
        if shortest or n_failed == MOST_FAILURES or n_unsolved == MOST_FAILURES:
            return FAILED_AGAIN
        if not converged:
            s.factorised = 0
            _shorten(s, work, 0.25)
        elif n_failed < RESTARTS:
            _shorten(s, work, next_order(s, work, error, n_failed))
        elif not _restart(rhs, s, work, block):
            return RAISED


LSODA = implicit(
    "LSODA", step, SLOPE, start=first_step.lsoda, before_events=NOTHING, order=12, error_order=1,
    n_rows=N_ROWS, n_matrices=2, dense_rows=dense_rows, dense_order=12, projects=False, cost=4,
    past=Z, n_past=CHANGE - Z, looks=(1.0,),
)  # fmt: skip
