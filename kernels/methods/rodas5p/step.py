"""Rodas5P: a Rosenbrock method of order 5(4) with 8 stages, for M y' = f(t, y).

The method is stiffly accurate and L-stable, and has dense output of order 4.  On stiff problems and
DAEs of index 1 its order falls less than the order of other Rosenbrock methods.  A step factorises
the matrix M / (h gamma) - df/dy once, solves 8 systems with the factors, and does not iterate.  See
`table.py` for the paper.
"""

from ...algebra.mass import add_product
from ...algebra.matrices import add_jacobian_product, factorise_sum, matrix_rows, solve_sum
from ...calls.block import MASS
from ...jit.options import INLINED, INTERNAL, njit
from ...output.dense_output import F
from ...state.elementwise import combine, weigh
from ...state.record import ATOL, RAISED, RTOL, RUNNING, SINGULAR, STAGE, STEP_TOO_SMALL, Y_OLD, Y
from ...state.rows import copy_row, slot
from ...stepping.differences import evaluate_row
from ...stepping.step_size import SCIPY, rms
from ..implicit import implicit
from . import lanes
from .derivatives import FACTOR, N_ROWS, PIVOTS, SLOPE, SUM, TIME, TOTAL, J, U, derive
from .table import DENSE, END, GAMMA, N_STAGES, SLOPES, TIMES, A, C

MOST_SINGULAR = 4  # consecutive singular matrices, each for a step ten times shorter
FIRST = END.floats[0]


@njit(**INTERNAL)
def _factorise(s, work, block, h):
    """Factorise the matrix for a step of this size; True if the matrix is regular."""
    factors = J + matrix_rows(block, work.shape[1])
    return factorise_sum(s, work, block, J, factors, PIVOTS, -1.0, 1.0 / (h * GAMMA))


@njit(**INTERNAL)
def _solve_stage(s, work, block, i, slope, b):
    """Solve for stage i, from the derivative in the row of the stage and the combination in SUM.

    b times the derivative, with its term in df/dt, is added to TOTAL.
    """
    n = work.shape[1]
    row = work[U + i]
    total = work[TOTAL]
    for k in range(n):
        row[k] += slope * work[TIME, k]
        total[k] = b * row[k] + (total[k] if i > 0 else 0.0)
    if i > 0:
        add_product(block[MASS], work[SUM], row)
    solve_sum(s, work, block, J, J + matrix_rows(block, n), PIVOTS, U + i, FACTOR + 1)


@njit(**INTERNAL)
def _solve_last_stage(s, work, block, h):
    """Solve for the last stage, from the derivative in its row and the combination in SUM.

    The equation of the stage is replaced by the equation of the end of the step, M (y_1 - y_0) =
    sum(b_i h (f_i + J U_i)).  In exact arithmetic, the two equations are equivalent.  But each
    stage has a rounding error of eps h |J U_i| in a linear invariant l M y, and nothing damps this
    error.  With the equation of the end, only two rounding errors remain: the error of the last
    stage, which is small, and the error of one product with J.
    """
    n = work.shape[1]
    row = work[U + N_STAGES - 1]
    total = work[TOTAL]
    add_jacobian_product(s, work, block, J, SUM, TOTAL, FACTOR + 1)
    for k in range(n):
        row[k] += total[k]
        work[SUM, k] = (work[Y, k] - work[STAGE, k]) / (h * GAMMA)
    add_product(block[MASS], work[SUM], row)
    solve_sum(s, work, block, J, J + matrix_rows(block, n), PIVOTS, U + N_STAGES - 1, FACTOR + 1)


@njit(**INLINED)
def _no_stages(work):
    return ()


def _stages_and(before, i):
    """A function that returns the rows of the stages up to stage i."""

    @njit(**INLINED)
    def stages(work):
        return (*before(work), slot(None, work, U + i))

    return stages


@njit(**INLINED)
def _first_stage(rhs, s, work, block, h):
    copy_row(work[SLOPE], work[U])
    _solve_stage(s, work, block, 0, h * GAMMA, FIRST)
    return True


def _state_of_stage(known, i):
    """A function that puts the state of stage i into row STAGE."""
    row = A[min(i, len(A)) - 1]

    @njit(**INLINED)
    def combined(work):
        combine(slot(None, work, STAGE), slot(None, work, Y), 1.0, row, known(work))

    @njit(**INLINED)
    def gone_on(work):
        for k in range(work.shape[1]):
            work[STAGE, k] += work[U + i - 1, k]

    return combined if i <= len(A) else gone_on


def _and_stage(before, known, i):
    """A function that solves for the stages up to stage i; it returns False if `rhs` raised."""
    state = _state_of_stage(known, i)
    last = i == N_STAGES - 1
    time = TIMES.floats[i - 1]
    slope = SLOPES.floats[i]
    c = C[i - 1]
    b = 0.0 if last else END.floats[i]

    @njit(**INLINED)
    def next_stage(rhs, s, work, block, h):
        if not before(rhs, s, work, block, h):
            return False
        state(work)
        s.n_extra += 1
        if not evaluate_row(rhs, s.t + time * h, work, STAGE, U + i, block):
            return False
        if last:
            weigh(slot(None, work, SUM), 1.0, END, known(work))
            _solve_last_stage(s, work, block, h)
        else:
            weigh(slot(None, work, SUM), 1.0 / h, c, known(work))
            _solve_stage(s, work, block, i, h * slope, b)
        return True

    return next_stage


def _all_stages():
    """A function that solves for all stages, and a function that returns the rows of the stages."""
    find = _first_stage
    known = _stages_and(_no_stages, 0)
    for i in range(1, N_STAGES):
        find = _and_stage(find, known, i)
        known = _stages_and(known, i)
    return find, known


_find_stages, _rows_of_stages = _all_stages()


@njit(**INTERNAL)
def _go_on(rhs, s, work, block, t_new):
    """Accept a step; RUNNING or RAISED."""
    copy_row(work[Y], work[Y_OLD])
    copy_row(work[STAGE], work[Y])
    s.t_old = s.t
    s.t = t_new
    s.n_extra += 1
    return RUNNING if evaluate_row(rhs, t_new, work, Y, SLOPE, block) else RAISED


@njit(**INTERNAL)
def step(rhs, state, work, block, h_min):
    """One step; see `implicit.kernel`."""
    s = state[0]
    rejections = 0
    singular = 0
    size = s.h_max if s.h > s.h_max else max(s.h, h_min)
    s.h = size
    status = derive(rhs, s, work, block)
    if status != RUNNING:
        return status
    last = slot(None, work, U + N_STAGES - 1)
    while size >= h_min:
        t_new = SCIPY.aim(s.t, size, s.t_end, s.direction)
        wanted = size
        size = abs(t_new - s.t)
        if not _factorise(s, work, block, t_new - s.t):
            singular += 1
            if singular > MOST_SINGULAR:
                return SINGULAR
            size = size / 10.0
            rejections = rejections + 1
            s.n_rejected += 1
            continue
        if not _find_stages(rhs, s, work, block, t_new - s.t):
            return RAISED
        for i in range(work.shape[1]):
            work[STAGE, i] += last[i]
        tolerances = slot(None, work, RTOL), slot(None, work, ATOL)
        s.error = rms(last, slot(None, work, Y), slot(None, work, STAGE), *tolerances)
        if s.error < 1.0:
            status = _go_on(rhs, s, work, block, t_new)
            s.h = SCIPY.grow(size, s.error, -0.2, rejections)
            if t_new == s.t_end:  # the step was shortened to reach t_end, not for its error
                s.h = max(s.h, wanted)
            return status
        size = SCIPY.shrink(size, s.error, -0.2, rejections, h_min)
        rejections += 1
        s.n_rejected += 1
    return STEP_TOO_SMALL


@njit(**INLINED)
def dense_rows(rhs, t, h, work, block, d):
    """The polynomial of the stages, in the form of `dense_output.py`; 0 evaluations."""
    stages = _rows_of_stages(work)
    weigh(slot(None, d, F + 1), 1.0, DENSE[0], stages)
    weigh(slot(None, d, F + 2), 1.0, DENSE[1], stages)
    weigh(slot(None, d, F + 3), -1.0, DENSE[2], stages)
    for i in range(work.shape[1]):
        d[F + 2, i] -= d[F + 3, i]
    return 0


RODAS5P = implicit(
    "Rodas5P", step, SLOPE, order=5, error_order=4, n_rows=N_ROWS, n_matrices=3, takes_mass=True,
    by_time=True, backward="rosenbrock", dense_rows=dense_rows, dense_order=4,
    lane_kernel=lanes.kernel, cost=10,
)  # fmt: skip
