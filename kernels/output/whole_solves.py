"""Solves in one call: the start, the first values of the events, and steps.

Many short solves in one call have their end states, or their states at given times.
"""

from ..calls.calling_convention import call_kernel, invoke
from ..calls.user_function import address_of, words_at
from ..jit.options import INTERNAL, njit
from ..state.record import BAD_STATE, FINISHED, FULL, RAISED, RUNNING, STEP_LIMIT, STEP_TOO_SMALL, Y
from ..state.rows import copy_row
from .arguments import BEGUN, COUNT, FRESH, GIVEN_UP, JACOBIAN, NEXT, NOTHING, Y0, Launch


@njit(**INTERNAL)
def launch(launched):
    """Copy the image into the memory, its addresses into the kernel's words, and solve.

    Returns the status of `whole_solve`.
    """
    head, words = words_at(launched.memory), words_at(launched.words)
    image, places = launched.image, launched.places
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
    o, work, y0 = output.record[0], solve.work, begin.y0
    not_finite = 0
    for i in range(len(y0)):
        work[Y, i] = y0[i]
        not_finite += int(y0[i] - y0[i] != 0.0)
    if not_finite > 0:
        return BAD_STATE
    if o.every_step != 0:
        output.t[0] = o.t_last
        copy_row(y0, output.y[0])
    status, has_events = RUNNING, len(events.table) > 0
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


@njit(**INTERNAL)
def solve_many(launched, many, budget):
    """Go on for about `budget` steps: RUNNING, FINISHED, or RAISED by the present solve."""
    queue, s = many.queue, many.state[0]
    while queue[NEXT] < queue[COUNT]:
        if budget <= 0:
            return RUNNING
        taken = s.n_accepted if queue[BEGUN] != 0 else 0
        if queue[BEGUN] == GIVEN_UP:
            status = STEP_TOO_SMALL
        else:
            status = _chunk(launched, many, min(budget, many.max_steps - taken))
        queue[BEGUN] = 1
        budget -= s.n_accepted - taken + 1
        if status == FULL:
            _keep_last(many)
            continue
        if status == RUNNING:
            if s.n_accepted < many.max_steps:
                continue
            status = STEP_LIMIT
        _store(many, queue[NEXT], status)
        if status == RAISED:
            return RAISED
        queue[NEXT] += 1
        queue[BEGUN] = 0
    return FINISHED


@njit(**INTERNAL)
def _chunk(launched, many, n_steps):
    """Take at most `n_steps` steps of the present solve, which begins if necessary; the status."""
    words, i = words_at(launched.words), many.queue[NEXT]
    words[many.n_steps] = n_steps
    if many.queue[BEGUN] != 0:
        words[FRESH] = 0
        return call_kernel(launched.kernel, launched.words)
    for j in range(len(many.places)):
        words_at(many.places[j, 0])[0] = many.values[i, many.places[j, 1]]
    y0 = address_of(many.y0[i if len(many.y0) > 1 else 0])
    return launch(
        Launch(
            launched.kernel, launched.words, launched.memory, y0, launched.image, launched.places
        )
    )


@njit(**INTERNAL)
def _keep_last(many):
    """Make room in the output: keep only the last step, and no event."""
    o = many.record[0]
    if o.every_step != 0:
        many.t[0] = many.t[o.n_out - 1]
        copy_row(many.y[o.n_out - 1], many.y[0])
        o.n_out = 1
    o.n_events = 0


@njit(**INTERNAL)
def _store(many, i, status):
    """Copy the results of solve i."""
    s, o = many.state[0], many.record[0]
    if o.every_step != 0:
        many.t_end[i] = many.t[o.n_out - 1]
        copy_row(many.y[o.n_out - 1], many.y_end[i, 0])
    for j in range(o.i_eval):
        copy_row(many.y[j], many.y_end[i, j])
    counts = many.counts[i]
    counts[0], counts[1], counts[2], counts[3] = status, s.n_accepted, s.n_rejected, s.n_extra
