"""Projection of states onto their constraints: at the end of a step, and in the output."""

from ..calls.block import RAISED_WORD
from ..calls.user_function import by_pointer, evaluate
from ..jit.options import INTERNAL, njit
from ..state.record import RAISED, RUNNING, K, Y
from ..state.rows import copy_row, slot


@njit(**INTERNAL)
def derive(solve, fsal_stage):
    """Evaluate the derivative at the present state, for the next step; RUNNING or RAISED."""
    s = solve.state[0]
    work = solve.work
    by_pointer(s.t, slot(None, work, Y), solve.block, slot(None, work, K + fsal_stage))
    s.n_extra += 1
    return RAISED if solve.block[RAISED_WORD] != 0 else RUNNING


@njit(**INTERNAL)
def project_row(project, t, y, scratch):
    """Project a state of the output; False if the function raised."""
    if project == 0:
        return True
    copy_row(y, scratch)
    return evaluate(project, t, scratch, y)


@njit(**INTERNAL)
def project_state(kernels, solve, scratch, by_series):
    """Project the new state; False if a function raised.

    If events are found `by_series`, the rows hold the series, and no derivative is stored.
    """
    if not evaluate(kernels.project, solve.state[0].t, slot(None, solve.work, Y), scratch):
        return False
    copy_row(scratch, solve.work[Y])
    if by_series:
        return True
    return derive(solve, kernels.fsal_stage) == RUNNING


@njit(**INTERNAL)
def project_events(kernels, events, first, end, scratch):
    """Project the states of the recorded events; False if a function raised."""
    for i in range(first, end):
        if not project_row(kernels.project, events.t[i], events.y[i], scratch[1]):
            return False
    return True
