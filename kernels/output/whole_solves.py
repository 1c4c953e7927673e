"""Solves in one call: the start, the first values of the events, and steps."""

from ..calls.calling_convention import call_kernel, invoke
from ..calls.user_function import words_at
from ..jit.options import INTERNAL, njit
from ..state.record import BAD_STATE, FINISHED, RUNNING, Y
from ..state.rows import copy_row
from .arguments import FRESH, JACOBIAN, NOTHING, Y0


@njit(**INTERNAL)
def launch(launched):
    """Copy the image into the memory, its addresses into the kernel's words, and solve.

    Returns the status of `whole_solve`.
    """
    head = words_at(launched.memory)
    words = words_at(launched.words)
    image = launched.image
    places = launched.places
    for i in range(len(image)):
        head[i] = image[i]
    for i in range(len(places)):
        words[places[i, 0]] = launched.memory + places[i, 1]
    words[FRESH], words[Y0] = 1, launched.y0
    return call_kernel(launched.kernel, launched.words)


@njit(**INTERNAL)
def whole_solve(begin, kernels, solve, output, events, scratch, n_steps):
    """Begin a fresh solve, and take at most `n_steps` steps; returns the status of `watch`."""
    if begin.fresh != 0:
        status = _begin(begin, kernels, solve, output, events, scratch)
        if status != RUNNING:
            return status
    return invoke(begin.watch, (kernels, solve, output, events, scratch, n_steps))


@njit(**INTERNAL)
def _begin(begin, kernels, solve, output, events, scratch):
    """Copy the initial state, and compute the first derivative and the first values of the events.

    The records already hold their values at `t0`.  An event may change values that the equations
    read.  Therefore events, derivative and Jacobian are first evaluated in the order of SciPy's
    solver of the same name.  If SciPy evaluates the Jacobian before the events, the step kernel
    computes the Jacobian in a call that takes no step.
    """
    o = output.record[0]
    work = solve.work
    y0 = begin.y0
    not_finite = 0
    for i in range(len(y0)):
        work[Y, i] = y0[i]
        not_finite += int(y0[i] - y0[i] != 0.0)
    if not_finite > 0:
        return BAD_STATE
    if o.every_step != 0:
        output.t[0] = o.t_last
        copy_row(y0, output.y[0])
    if solve.state[0].passes_end:
        solve.state[0].t_stop = output.t_eval[0]
    status = RUNNING
    has_events = len(events.table) > 0
    opened = (events.table, o.t_last, work[Y], scratch[1])
    if has_events and begin.before_events == NOTHING:
        status = invoke(begin.open, opened)
    if status == RUNNING:
        start = (solve.state, work, solve.block, kernels.order, kernels.fsal_stage)
        status = invoke(kernels.start, start)
    if has_events and status == RUNNING and begin.before_events != NOTHING:
        if begin.before_events == JACOBIAN:
            status = invoke(kernels.advance, (solve.state, work, solve.block, 0))
        if status == RUNNING or status == FINISHED:
            status = invoke(begin.open, opened)
    return status
