"""Many short solves in one call: their end states, or their states at given times."""

from ..calls.calling_convention import call_kernel
from ..calls.user_function import address_of, words_at
from ..jit.options import INTERNAL, njit
from ..state.record import FINISHED, FULL, RAISED, RUNNING, STEP_LIMIT, STEP_TOO_SMALL
from ..state.rows import copy_row
from .arguments import BEGUN, COUNT, FRESH, GIVEN_UP, NEXT, Launch
from .whole_solve import launch


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
