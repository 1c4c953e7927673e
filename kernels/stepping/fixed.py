"""The loop for constant steps."""

import numpy as np

from ..calls.block import RAISED_WORD
from ..jit.options import INTERNAL, njit
from ..state.elementwise import assign
from ..state.record import FINISHED, NON_FINITE, RAISED, RUNNING, Y_OLD, K, Y
from ..state.reduce import add, reduce_components
from ..state.rows import fetch, keep, slot

LANDED = 1e-6  # a step whose end differs from t_end by less than this share of a step ends at t_end


@njit(**INTERNAL)
def add_size(total, y):
    return total + abs(y)


def kernel(step, fsal_stage, compensation_stage, rhs, form):
    """The loop around `rhs`, as `adaptive.kernel`, with steps of size state.h.

    Step i ends at t_start + (i + 1) h, so that the times carry no accumulated rounding.  The last
    step is as long as the others and ends at t_end or beyond.  A state that is no longer finite
    ends the run with NON_FINITE.  Stage `compensation_stage` carries the rounding errors of a
    compensated summation to the next step; without this summation the stage is `fsal_stage`.
    """

    @njit(**INTERNAL)
    def loop(state, work, block, n_steps):
        s = state[0]
        direction = s.direction
        t_end = s.t_end
        t_stop = s.t_stop
        t_start = s.t_start
        h = direction * s.h
        t = s.t
        t_old = s.t_old
        y = fetch(form, work, Y)
        k_last = fetch(form, work, K + fsal_stage)
        compensation = fetch(form, work, K + compensation_stage)
        status = RUNNING
        taken = 0
        done = s.n_accepted
        if direction * (t - t_end) >= 0.0:
            return FINISHED
        while taken < n_steps:
            y_old = assign(slot(form, work, Y_OLD), y)
            k1 = assign(slot(form, work, K), k_last)
            y, k = step(rhs, t, y_old, h, k1, compensation, block, form, work)
            if block[RAISED_WORD] != 0:
                status = RAISED
            elif not reduce_components(add_size, add, 0.0, (y,)) < np.inf:
                status = NON_FINITE
            if status != RUNNING:
                y = assign(slot(form, work, Y), y_old)
                keep(work, Y, (y, y_old))
                break
            taken += 1
            t_old = t
            t = t_start + (done + taken) * h
            k_last = k[fsal_stage]
            compensation = k[compensation_stage]
            if abs(t - t_end) <= LANDED * s.h:
                t = t_end
            if direction * (t - t_end) >= 0.0:
                status = FINISHED
            if status == FINISHED or taken == n_steps or direction * (t - t_stop) >= 0.0:
                keep(work, Y, (y, y_old))
                keep(work, K, k)
                break
        s.t = t
        s.t_old = t_old
        s.n_accepted += taken
        return status

    return loop
