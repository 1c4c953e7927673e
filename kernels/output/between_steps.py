"""Between the steps: output, dense output, events, jumps, schedules, projection, breakpoints.

The loop calls the stepping kernel and the interpolant through their addresses, so that one compiled
loop serves every method, with shared and with inlined kernels.  The loop asks for one step at a
time if each step is stored, projected or searched for events, else for all steps up to the next
output time.

The loop is compiled three times: whole; for solves with events only, where `acts` is None; and for
the many solves without events, too, where `events` is None.  The compiler omits what stands behind
``is not None``: a first solve with events compiles for a quarter of the time of the whole loop, and
a step with events takes three quarters (RK45, two components).
"""

from ..calls.calling_convention import invoke
from ..jit.options import INLINED, INTERNAL, njit
from ..state.record import (
    BORDER,
    EVENT,
    FINISHED,
    FULL,
    RAISED,
    RUNNING,
    STEP_LIMIT,
    STEP_TOO_SMALL,
    Y_OLD,
    ZENO,
    Y,
)
from ..state.rows import copy_row
from ..state.snapshots import take_snapshot, until_next
from .arguments import SERIES, WHOLE
from .borders import (
    BEYOND,
    CHANGED,
    ENDS,
    RAISES,
    TAKEN_BACK,
    TOO_SHORT,
    at_border,
    goes_on,
    keep_inside,
    settle,
)
from .dense_output import interpolate, polynomial, polynomials
from .events import ENDLESS, FAILED
from .jumps import jump
from .projection import project_row, project_state
from .schedules import act_on_schedule, arrive
from .segments import (
    end_of_span,
    ends_segment,
    is_border,
    jumps_over,
    next_segment,
    time_reached,
)
from .series_roots.look import BUSY, look


@njit(**INTERNAL)
def watch(kernels, solve, output, events, scratch, n_steps):
    """Take at most `n_steps` steps, and store the requested output; see `_watch`."""
    return _watch(kernels, solve, output, events, 1, scratch, n_steps)


@njit(**INTERNAL)
def watch_events(kernels, solve, output, events, scratch, n_steps):
    """`watch` for solves with events, but without what `acts` stands for."""
    return _watch(kernels, solve, output, events, None, scratch, n_steps)


@njit(**INTERNAL)
def watch_plain(kernels, solve, output, events, scratch, n_steps):
    """`watch` for solves without events, and without what `acts` stands for."""
    return _watch(kernels, solve, output, None, None, scratch, n_steps)


@njit(**INTERNAL)
def _watch(kernels, solve, output, events, acts, scratch, n_steps):
    """Take at most `n_steps` steps, and store the requested output.

    Parameters
    ----------
    kernels : Kernels
    solve : state.record.Solve
    output : Output
    events : events.Events or None
        With room for all events of one step; None for a solve without events.
    acts : int or None
        None for a solve without schedules, jumps, projection, domain, breakpoints and `changes`.
    scratch : array, (2, n)

    Returns
    -------
    int
        RUNNING, FINISHED, FULL, EVENT, or a failure.
    """
    s, o = solve.state[0], output.record[0]
    each = o.every_step != 0 or o.dense != 0
    if events is not None:
        each = each or len(events.table) > 0
    if acts is not None:
        each = each or kernels.project != 0 or kernels.keeps != 0 or len(output.changes) > 0
    kept = 0
    while True:
        if acts is not None:
            if len(events.schedules) > 0 and o.sampled != 0:
                if _is_full(o, output, events):
                    return FULL
                o.sampled = 0
                status = act_on_schedule(kernels, solve, output, events, scratch)
                if status != RUNNING:
                    return status
        if n_steps <= 0:
            return RUNNING
        if _is_full(o, output, events):
            return FULL
        s.t_stop = end_of_span(s, output.segments)
        if not each and o.i_eval < len(output.t_eval):
            s.t_stop = output.t_eval[o.i_eval]
        before = s.n_accepted
        status = _advance(kernels, solve, output, 1 if each else n_steps)
        n_steps -= s.n_accepted - before
        if status >= STEP_TOO_SMALL or s.n_accepted == before:
            if acts is not None:
                if kernels.inside != 0 or kernels.keeps != 0:
                    if not goes_on(kernels, solve, scratch, status):
                        return at_border(kernels, solve, scratch, status)
                    n_steps -= 1
                    continue
            return status
        if acts is not None:
            if kernels.keeps != 0:
                kept = keep_inside(kernels, solve, output.d[o.n_dense], scratch)
                if kept == TAKEN_BACK:
                    continue
                if kept == TOO_SHORT:
                    return at_border(kernels, solve, scratch, STEP_TOO_SMALL)
                if kept == RAISES:
                    return RAISED
                if kept == BEYOND:
                    return BORDER
            elif kernels.project != 0:
                by_series = len(events.table) > 0 and events.table[0].middle == SERIES
                if not project_state(kernels, solve, scratch[0], by_series):
                    return RAISED
            jumped = len(output.changes) > 0 and jumps_over(s, o, output)
        status = _sample(kernels, solve, output, events, acts, scratch, status)
        if acts is not None:
            if kept == CHANGED and status <= FINISHED and not settle(kernels, solve, scratch):
                return RAISED
            if kept == ENDS and status == RUNNING:
                return BORDER
        if status <= FINISHED:
            take_snapshot(s, solve.work[Y], output.snapshots, s.n_accepted - before)
        if acts is not None:
            if jumped and status <= FINISHED:  # so that the caller sees it, also at the end
                o.sampled = int(status == RUNNING)
                return RUNNING
        if status != RUNNING:
            return status
        o.sampled = 1


@njit(**INTERNAL)
def _advance(kernels, solve, output, n_steps):
    """Take at most `n_steps` steps, up to the next snapshot, if `most_between` allows a step."""
    s = solve.state[0]
    o = output.record[0]
    if o.most_between > 0:
        n_steps = min(n_steps, o.n_before + o.most_between - s.n_accepted)
        if n_steps == 0:
            return STEP_LIMIT
    budget = until_next(s, output.snapshots, n_steps)
    return invoke(kernels.advance, (solve.state, solve.work, solve.block, budget))


@njit(**INTERNAL)
def _is_full(o, output, events):
    """True if a piece of the output has no room for one more step."""
    stored = o.every_step != 0 and o.n_out + o.jumps >= len(output.t)
    full = stored or o.n_dense == len(output.d)
    if events is not None:
        n = len(events.table)
        if n > 0:
            n *= events.table[0].at_once
        n += len(events.schedules)
        full = full or o.n_events + n > len(events.t)
    return full


@njit(**INTERNAL)
def _sample(kernels, solve, output, events, acts, scratch, status):
    """Store the requested output of the last step; return the status to go on with."""
    s, o = solve.state[0], output.record[0]
    t_old, h = s.t_old, s.t - s.t_old
    over = status == FINISHED and len(output.segments) > 0
    t = time_reached(s, o, output.segments, over)
    reached = t == s.t or (over and s.t == s.t_end)  # the state at t is in row Y
    d = output.d[o.n_dense]
    due = _is_due(s, o, output.t_eval, t) and not _ends(o, output.t_eval, t)
    ready = o.dense != 0 or due or not reached
    if ready:
        interpolate(kernels, solve, d)
    if o.dense != 0:
        output.spans[o.n_dense, 0], output.spans[o.n_dense, 1] = t_old, h
        o.n_dense += 1
    jumps, t_row, at_end = False, t, reached
    if o.every_step == WHOLE and not reached:  # a constant step that passes the end
        t_row, at_end = s.t, True
    if events is not None:
        if len(events.table) > 0:
            cut = _find(kernels, solve, output, events, acts, scratch, t, reached, ready, d)
            if cut == FAILED:
                return RAISED
            if cut == ENDLESS:
                return _undo(solve, o)
            if cut >= 0:
                e = events.table[cut]
                t, reached, jumps = e.root, False, e.limit == 0 or e.count < e.limit
                if o.every_step != WHOLE:
                    t_row, at_end = t, False
                if not jumps:
                    status = EVENT
    if jumps and t_row == t_old:  # this point is stored already
        o.n_dense -= o.dense
    elif o.every_step != 0:
        if not _store_step(kernels, solve, output, acts, scratch[1], t_row, at_end, d, h):
            return RAISED
    first, end = o.i_eval, o.i_eval
    while end < len(output.t_eval) and s.direction * (output.t_eval[end] - t) <= 0.0:
        output.t[end] = output.t_eval[end]
        end += 1
    if end > first:
        exact = reached and o.ends != 0 and output.t_eval[end - 1] == t
        polynomials(d, t_old, h, output.t_eval, first, end - exact, output.y)
        if exact:
            copy_row(solve.work[Y], output.y[end - 1])
        if acts is not None:
            for o.i_eval in range(first, end):
                i = o.i_eval
                if not project_row(kernels.project, output.t[i], output.y[i], scratch[1]):
                    return RAISED
        _count(s, o, output.told, first, end)
    if acts is not None:
        if jumps:
            return jump(kernels, solve, output, events, scratch, d, t, t_old, h)
        if over and status == FINISHED:
            if not ends_segment(s, o, output.segments):
                if reached:
                    return RUNNING
                return arrive(kernels, solve, output, events, scratch, d, t, t_old, h)
            if o.i_segment < len(output.segments) - 1:
                return next_segment(kernels, solve, output)
    return status


@njit(**INLINED)
def _find(kernels, solve, output, events, acts, scratch, t, reached, ready, d):
    """Record the events of a step up to t; results as `find_inside`."""
    s = solve.state[0]
    given = (kernels, solve, output, events, scratch)
    if acts is not None:
        if is_border(s, output.record[0], output.segments):  # before the breakpoint t
            t = s.t
    cut = look(*given, t, reached, ready, d, acts)
    if cut == BUSY:
        cut = invoke(events.table[0].find, (*given, t, int(reached), int(ready), d))
    return cut


@njit(**INTERNAL)
def _undo(solve, o):
    """Return to the start of a step in which events accumulate."""
    s = solve.state[0]
    copy_row(solve.work[Y_OLD], solve.work[Y])
    s.t = s.t_old
    o.n_dense -= o.dense
    return ZENO


@njit(**INTERNAL)
def _count(s, o, told, first, end):
    """Count the times of output from `first` to `end`, and keep the solver's state there."""
    if len(told) > 0:
        for i in range(first, end):
            told[i] = s
    o.i_eval = end
    o.n_before = s.n_accepted


@njit(**INTERNAL)
def _is_due(s, o, t_eval, t):
    return o.i_eval < len(t_eval) and s.direction * (t_eval[o.i_eval] - t) <= 0.0


@njit(**INTERNAL)
def _ends(o, t_eval, t):
    """True if the next time of output is the end t of the step: no interpolant is needed."""
    return o.ends != 0 and t_eval[o.i_eval] == t


@njit(**INTERNAL)
def _store_step(kernels, solve, output, acts, scratch, t, reached, d, h):
    """Store the end of a step; False if the projection raised."""
    s = solve.state[0]
    o = output.record[0]
    if o.dense != 0 and o.n_total > 1 and o.t_last == t:
        o.n_dense -= 1
        return True
    y_out = output.y[o.n_out]
    output.t[o.n_out] = o.t_last = t
    if reached:
        copy_row(solve.work[Y], y_out)
    else:
        polynomial(d, (t - s.t_old) / h, y_out)
        if acts is not None:
            if not project_row(kernels.project, t, y_out, scratch):
                return False
    o.n_out += 1
    o.n_total += 1
    return True
