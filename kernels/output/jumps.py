"""Jumps: events that change the state, and the start of the solve behind the jump."""

import numpy as np

from ..calls.block import MASS, RAISED_WORD
from ..calls.calling_convention import invoke
from ..calls.consistent import rates_of
from ..calls.user_function import evaluate
from ..jit.options import INTERNAL, njit
from ..state.record import (
    ATOL,
    BAD_JUMP,
    FINISHED,
    NEGATIVE,
    OUTSIDE,
    RAISED,
    RUNNING,
    K,
    Y,
)
from ..state.rows import copy_row, slot
from .arguments import CLIPS
from .brent import resolution
from .dense_output import polynomial
from .events import LEAVES, PENDING, PLAIN, SIGN, STAYS, TOUCHES, evaluate_all
from .projection import derive, project_row
from .segments import ends_segment, next_segment
from .series_roots.phases import slow_step

AHEAD = 1e-3  # share of the last step behind a jump, where the sign of a zero function is found


@njit(**INTERNAL)
def jump(kernels, solve, output, events, scratch, d, t, t_old, h):
    """Let the event at time t of the step from t_old, of length h, change the state at t.

    A new solve begins behind the jump.  Returns RUNNING, FINISHED, NON_FINITE, or a failure of
    `act`.
    """
    y = slot(None, solve.work, Y)
    polynomial(d, (t - t_old) / h, y)
    solve.state[0].t = t
    if not project_row(kernels.project, t, y, scratch[0]):
        return RAISED
    for i in range(len(events.table)):
        e = events.table[i]
        if e.active == 1 and e.jump != 0:
            status = act(kernels, solve, scratch, e.jump, i, t)
            if status != RUNNING:
                return status
    store_behind(output, t, y)
    status = begin(kernels, solve, output, events, scratch, t)
    if status != RUNNING:
        return status
    return watch_from(kernels, solve, events.table, scratch, h)


@njit(**INTERNAL)
def act(kernels, solve, scratch, function, place, t):
    """Let the function of `on_event` at an address change the state at t.

    `place` is the index of the event of the function.  Returns RUNNING; or RAISED, BAD_JUMP,
    OUTSIDE or NEGATIVE, with the state unchanged.
    """
    s = solve.state[0]
    y = slot(None, solve.work, Y)
    s.acted = place
    copy_row(y, scratch[0])
    if not evaluate(function, t, scratch[0], y):
        return RAISED
    status = _admit(kernels, solve, t, y, scratch[1])
    if status != RUNNING:
        copy_row(scratch[0], y)
    return status


@njit(**INTERNAL)
def _admit(kernels, solve, t, y, found):
    """Check a state that `on_event` returned; return a status.

    A component of `nonnegative` between -atol and 0 becomes 0, as at the end of a step.
    """
    s = solve.state[0]
    for i in range(len(y)):
        if not np.isfinite(y[i]):
            s.component = i
            return BAD_JUMP
    if kernels.keeps & CLIPS:
        if not evaluate(kernels.project, t, y, found):
            return RAISED
        for i in range(len(y)):
            if found[i] - y[i] > solve.work[ATOL, i]:
                s.component = i
                return NEGATIVE
        for i in range(len(y)):
            if found[i] != y[i]:
                s.cut += (found[i] - y[i]) / solve.work[ATOL, i]
                y[i] = found[i]
    if kernels.inside != 0:
        if not evaluate(kernels.inside, t, y, found):
            return RAISED
        if not found[0] > 0.0:
            return OUTSIDE
    return RUNNING


@njit(**INTERNAL)
def store_behind(output, t, y):
    """Store the state behind the jump, if steps are stored."""
    o = output.record[0]
    if o.every_step != 0:
        output.t[o.n_out] = o.t_last = t
        copy_row(y, output.y[o.n_out])
        o.n_out += 1
        o.n_total += 1


@njit(**INTERNAL)
def begin(kernels, solve, output, events, scratch, t):
    """Begin a solve at t, in the segment of t."""
    s = solve.state[0]
    o = output.record[0]
    work = solve.work
    segments = output.segments
    s.t = t
    if len(segments) > 0 and s.direction * (segments[o.i_segment, 0] - t) > 0.0:
        s.t = segments[o.i_segment, 0]
    if s.direction * (s.t - s.t_end) >= 0.0:
        s.t = s.t_end
        if ends_segment(s, o, segments):
            if o.i_segment >= len(segments) - 1:
                return FINISHED
            status = derive(solve, kernels.fsal_stage)
            if status == RUNNING:
                status = next_segment(kernels, solve, output)
            if status != RUNNING:
                return status
    for i in range(K, work.shape[0]):
        for j in range(work.shape[1]):
            work[i, j] = 0.0
    s.t_old = s.t
    s.h = s.h_first
    s.stiff = 0
    s.t_start = s.t - s.n_accepted * (s.direction * s.h)  # where constant steps would have begun
    start = (solve.state, work, solve.block, kernels.order, kernels.fsal_stage)
    return invoke(kernels.start, start)


@njit(**INTERNAL)
def watch_from(kernels, solve, table, scratch, h):
    """Set the values of the events at the start of the new solve; RUNNING or RAISED.

    The function of an event that has just occurred is zero to rounding.  The event takes the next
    sign of this function, which is found by means of the derivative of the state.
    """
    s = solve.state[0]
    y = slot(None, solve.work, Y)
    rate = slot(None, solve.work, K + kernels.fsal_stage)
    if not evaluate_all(table, s.t, y, scratch[1]):
        return RAISED
    if len(table) > 0 and solve.block[MASS] != 0:
        rate = scratch[0]
        rates_of(solve.block[MASS], s.t, y, rate)
        if solve.block[RAISED_WORD] != 0:
            return RAISED
    step = 0.0
    if len(table) > 0:
        least = 4.0 * resolution(s.t, table[0].unit)
        step = s.direction * max(AHEAD * abs(h), least)
        for i in range(len(table)):
            if table[i].t_jump == s.t or table[i].active:
                step = slow_step(table[i], s.t, step, least, y, rate, scratch[0])
    for i in range(len(y)):
        scratch[0, i] = y[i] + step * rate[i]
    for i in range(len(table)):
        e = table[i]
        e.slope = np.nan
        if e.active:
            if e.active != PENDING:
                e.repeats = e.repeats + 1 if e.begins == TOUCHES else 0
            e.t_jump = s.t
        if e.t_jump != s.t or not abs(e.g_new) <= e.noise:
            e.g = e.g_new
            e.begins = STAYS if e.begins == STAYS and e.g == 0.0 else PLAIN
            continue
        if not evaluate(e.block, s.t + step, scratch[0], scratch[1]):
            return RAISED
        rise = scratch[1, 0] - e.g_new
        sign = SIGN if rise > 0.0 else -SIGN if rise < 0.0 else 0.0
        same = (e.g > 0.0 and sign > 0.0) or (e.g < 0.0 and sign < 0.0)
        if e.active == 1:
            e.came = np.sign(e.g)
            e.rest = abs(e.g_new)
            e.g = sign
        e.begins = LEAVES if e.active == 1 or same else TOUCHES
    return RUNNING
