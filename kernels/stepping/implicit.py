"""The loop for adaptive methods that solve equations in each step, and keep factors of matrices."""

import numpy as np

from ..jit.options import INLINED, INTERNAL, njit
from ..state.record import ATOL, FINISHED, RTOL, RUNNING, Y
from ..vector.scalar_or_vector import spacing

EPS = float(np.finfo(float).eps)
# A step changes a component by h times a mean of its derivatives, which `fun` gives where Newton's
# iteration has converged: in 46 000 steps of 28 stiff problems at rtol 1e-2 to 1e-4, the change was
# at most 1.15 h times the largest |f|.  Where f jumps, as v / |v| does with a guard, the iteration
# may end anywhere, with changes 3 to 1e12 times as large.
LARGEST_CHANGE = 2.0  # of that product
LEAST_CHANGE = 10.0  # tolerances, from which a change counts


@njit(**INTERNAL)
def begins_in_step(rhs, state, work, block):
    """The `begin` of a method whose first step computes the past and the matrices."""
    return RUNNING


def kernel(begin, step, rhs, form):
    """The loop around `rhs`, as `adaptive.kernel`, on rows: `form` is None.

    ``begin(rhs, state, work, block)`` is called where `state.order` is 0: before the first step,
    and where the method begins anew.  `begin` sets the order.  ``step(rhs, state, work, block,
    h_min)`` takes one step that is not shorter than h_min, updates all counters but n_accepted, and
    sets the size of the next step.  Both return RUNNING or a failure.
    """

    @njit(**INTERNAL)
    def loop(state, work, block, n_steps):
        s = state[0]
        taken = 0
        if s.direction * (s.t - s.t_end) >= 0.0:
            return FINISHED
        if s.order == 0:
            status = begin(rhs, state, work, block)
            if status != RUNNING:
                return status
        while taken < n_steps:
            status = step(rhs, state, work, block, 10.0 * spacing(s.t, s.direction))
            if status != RUNNING:
                return status
            taken += 1
            s.n_accepted += 1
            if s.direction * (s.t - s.t_end) >= 0.0:
                return FINISHED
            if s.direction * (s.t - s.t_stop) >= 0.0 or abs(s.t - s.t_old) < s.h_short:
                break
        return RUNNING

    return loop


@njit(**INTERNAL)
def newton_tolerance(work):
    """The distance to the solution at which Newton's iteration ends, in units of the tolerance."""
    rtol = work[RTOL, 0]
    for i in range(work.shape[1]):
        rtol = min(rtol, work[RTOL, i])
    return max(10.0 * EPS / rtol, min(0.03, np.sqrt(rtol)))


@njit(**INTERNAL)
def weigh(rows, state, weight, relative, absolute):
    """Store 1 / tolerance at a state in the row `weight`; False if a tolerance is 0.

    `relative` and `absolute` are the rows of the tolerances.
    """
    for i in range(rows.shape[1]):
        tolerance = rows[relative, i] * abs(rows[state, i]) + rows[absolute, i]
        if not tolerance > 0.0:
            return False
        rows[weight, i] = 1.0 / tolerance
    return True


@njit(**INLINED)
def take_larger(work, most, row):
    """Let each number of the row `most` be at least the size of that of another row."""
    for i in range(work.shape[1]):
        work[most, i] = max(work[most, i], abs(work[row, i]))


@njit(**INLINED)
def beyond(work, change, most, h):
    """1 if a step changes a component far more than its derivatives, of size `most`, can; else 0.

    The change is the row `change` less the row Y.
    """
    for i in range(work.shape[1]):
        by = abs(work[change, i] - work[Y, i])
        tolerance = work[ATOL, i] + abs(work[Y, i]) * work[RTOL, i]
        if by > LARGEST_CHANGE * abs(h) * work[most, i] and by > LEAST_CHANGE * tolerance:
            return 1
    return 0


@njit(**INLINED)
def scaled_squares(s, work, row, sizes):
    """The sum of (|x| / (atol + rtol |sizes|))^2 over the numbers x of a row.

    If the components are pairs, x are the complex numbers of the row.
    """
    total = 0.0
    if s.pairs:
        for i in range(0, work.shape[1], 2):
            size = np.hypot(work[sizes, i], work[sizes, i + 1])
            scale = work[ATOL, i] + size * work[RTOL, i]
            re = work[row, i] / scale
            im = work[row, i + 1] / scale
            total += re * re + im * im
        return total
    for i in range(work.shape[1]):
        x = work[row, i] / (work[ATOL, i] + abs(work[sizes, i]) * work[RTOL, i])
        total += x * x
    return total


@njit(**INLINED)
def n_components(s, work):
    """The number of components, real or complex."""
    return work.shape[1] // 2 if s.pairs else work.shape[1]
