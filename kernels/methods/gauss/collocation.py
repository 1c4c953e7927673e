"""Implicit Runge-Kutta steps of constant size for y' = f(t, y), solved by fixed-point iteration.

The arrangement is that of M. Antonana, J. Makazaga and A. Murua, "Reducing and monitoring
round-off error propagation for symplectic implicit Runge-Kutta schemes", Numer. Algorithms 76
(2017): with L_j = h b_j f(Y_j) the stages are Y_i = y + sum mu_ij L_j, where mu_ij = a_ij / b_j
is rounded so that mu_ij + mu_ji = 1 holds exactly, and y + sum L_j is summed with compensation.
The iteration starts from the stages of the last step, extrapolated, and goes on until the changes
of no component decrease (E. Hairer, R. I. McLachlan and A. Razakarivony, "Achieving Brouwer's law
with implicit Runge-Kutta methods", BIT 48 (2008)).  A tolerance would leave errors of one sign.

The stages of a component lie side by side, so that the processor loads the stages as one vector.
"""

import numpy as np

from ...calls.block import RAISED_WORD
from ...jit.options import INLINED, INTERNAL, njit
from ...state.layout import Form
from ...state.record import FINISHED, NON_FINITE, NOT_CONVERGED, RAISED, RUNNING, Y_OLD, Y
from ...state.rows import keep_vector, numbers_of, slot, vector_at
from ...stepping.fixed import LANDED
from .iteration import INCREMENTS, all_weights, make_evaluate, make_sweep, outer_weights, rows
from .stages import keep_increments, largest, product

MAX_ITERATIONS = 100  # at a rate of 0.7 they reach rounding
SMALL = 1e-6  # changes above this share of a component are not rounding
STALLS = 2  # iterations without progress after which all changes are rounding errors
MOVING = MAX_ITERATIONS


@njit(**INLINED)
def _patience(change, count, work, row, k, size):
    """The number of iterations without progress that component k allows."""
    if count == 0:  # the first change cannot be compared
        return MOVING
    if change == 0.0:  # the component may move again when other components move
        return 0
    if change < work[row, k]:
        work[row, k] = change
        return MOVING
    return MOVING if change > SMALL * size else STALLS


def make_step(s, mu, ratio, b, c, nystrom=False, batched=False):
    """The step of a method.

    `mu` and `ratio`, for the prediction, are Matrix; `b` and `c` are arrays.  With `nystrom` the
    equations are q'' = a(t, q) for a state [q, v], and `rhs` is a: each iteration first finds the
    velocities, then the positions from the velocities, and so the number of iterations is halved.
    With `batched` the derivatives of all stages are evaluated on vectors, and `form` is a Form.
    """
    LOW, STAGES, CHANGE, SLOPE = rows(s)
    weight = outer_weights(s, b)
    weights = all_weights(b, weight)
    # Without `nystrom`, positions and velocities follow from the velocities and positions of the
    # iteration before.  An iteration must be compared with the second iteration before, because
    # positions or velocities alone may be right by chance at first.
    turns = 1 if nystrom else 2
    stages = Form(1, s, exact=True)

    @njit(**INLINED)
    def refined(work, k, count):
        """Stages of component k from its increments; the patience that the component needs."""
        n = work.shape[1]
        numbers = numbers_of(work)
        at = STAGES * n + k * s
        rise = product(mu, vector_at(stages, numbers, INCREMENTS * n + k * s))
        new = work[Y, k] + (work[LOW, k] + rise)
        change = largest(abs(new - vector_at(stages, numbers, at)))
        keep_vector(stages, numbers, at, new)
        size = abs(numbers[at]) + abs(numbers[at + s - 1])
        return _patience(change, count, work, CHANGE + count % turns, k, size)

    sweep = make_sweep(nystrom, s, weights, refined)
    evaluate = make_evaluate(batched, nystrom, s, c, weight, weights)

    @njit(**INLINED)
    def step(rhs, t, h, first, form, work, block):
        """One step from row Y; (status, evaluations)."""
        n = work.shape[1]
        numbers = numbers_of(work)
        for k in range(n):
            work[CHANGE, k] = work[CHANGE + 1, k] = np.inf
            if not first:
                at = INCREMENTS * n + k * s
                keep_vector(stages, numbers, at, product(ratio, vector_at(stages, numbers, at)))
        if first:
            for i in range(s):
                slope = slot(None, work, SLOPE)
                keep_increments(slope, weight(h, i), numbers, INCREMENTS * n + i, s)
        count = stalls = 0
        while True:
            patience = sweep(work, h, count)
            stalls = 0 if patience == MOVING else stalls + 1
            if stalls >= patience:
                break
            if count == MAX_ITERATIONS:
                return NOT_CONVERGED, s * count
            done = evaluate(rhs, t, h, form, work, block)
            if block[RAISED_WORD] != 0:
                return RAISED, s * count + done
            count += 1
        total = 0.0
        for k in range(n):
            y, rise, at = work[Y, k], 0.0, INCREMENTS * n + k * s
            for i in range(s // 2):  # the smallest weights first
                rise += numbers[at + i] + numbers[at + s - 1 - i]
            rise += work[LOW, k]
            work[Y_OLD, k] = y
            work[Y, k] = y + rise
            work[LOW, k] = rise - (work[Y, k] - y)
            total += abs(work[Y, k])
        return (RUNNING if total < np.inf else NON_FINITE), s * count

    return step


def kernel(step, rhs, form):
    """The loop around `rhs`, as `fixed.kernel`, for implicit steps."""

    @njit(**INTERNAL)
    def loop(state, work, block, n_steps):
        s = state[0]
        direction = s.direction
        t_end = s.t_end
        t_stop = s.t_stop
        t_start = s.t_start
        h = direction * s.h
        status = RUNNING
        taken = 0
        if direction * (s.t - t_end) >= 0.0:
            return FINISHED
        while taken < n_steps:
            status, evaluations = step(rhs, s.t, h, s.t == s.t_old, form, work, block)
            s.n_extra += evaluations
            if status != RUNNING:
                break
            taken += 1
            s.n_accepted += 1
            s.t_old = s.t
            s.t = t_start + s.n_accepted * h
            if abs(s.t - t_end) <= LANDED * s.h:
                s.t = t_end
            if direction * (s.t - t_end) >= 0.0:
                status = FINISHED
            if status == FINISHED or direction * (s.t - t_stop) >= 0.0:
                break
        return status

    return loop
