"""Schedules: times known beforehand, at which a step ends and a function may change the state."""

import numpy as np

from ..calls.user_function import numbers_at
from ..jit.options import INTERNAL, njit
from ..state.record import EVENT, RAISED, RUNNING, Y
from ..state.rows import copy_row, slot
from .arguments import WHOLE
from .dense_output import polynomial
from .jumps import act, begin, store_behind, watch_from
from .meetings import has_rate, have_met, near
from .projection import project_row


@njit(**INTERNAL)
def aim(s, o, segments, schedules):
    """Let the steps end at the next time of a schedule, or at the end of the segment."""
    end = segments[o.i_segment, 1]
    for i in range(len(schedules)):
        if s.direction * (schedules[i].t_next - end) < 0.0:
            end = schedules[i].t_next
    s.t_end = end


@njit(**INTERNAL)
def _move_on(e, direction):
    """Let a schedule proceed to its next time."""
    e.next += e.way
    if e.next == e.end:
        e.t_next = direction * np.inf
    elif e.times != 0:
        e.t_next = numbers_at(e.times)[e.next]
    else:
        e.t_next = e.start + e.next * e.period


@njit(**INTERNAL)
def arrive(kernels, solve, output, events, scratch, d, t, t_old, h):
    """Interpolate to a schedule's time that a constant step has passed, and begin anew there."""
    y = slot(None, solve.work, Y)
    polynomial(d, (t - t_old) / h, y)
    if not project_row(kernels.project, t, y, scratch[0]):
        return RAISED
    return _begin_behind(kernels, solve, output, events, scratch, t, h)


@njit(**INTERNAL)
def _begin_behind(kernels, solve, output, events, scratch, t, h):
    """Begin a new solve at a schedule's time t; a status."""
    status = begin(kernels, solve, output, events, scratch, t)
    if status != RUNNING:
        return status
    return _watch_on(kernels, solve, events.table, scratch, t, h if h != 0.0 else solve.state[0].h)


@njit(**INTERNAL)
def _watch_on(kernels, solve, table, scratch, t, h):
    """Set the values of the events behind a schedule's time t; RUNNING or RAISED."""
    for i in range(len(table)):
        e = table[i]
        if not abs(e.t_jump - t) <= near(t, e.unit):  # an occurrence earlier in the step
            e.active = 0
    return watch_from(kernels, solve, table, scratch, h)


@njit(**INTERNAL)
def act_on_schedule(kernels, solve, output, events, scratch):
    """Let the schedules act whose time is reached, in their order; RUNNING, EVENT or a failure."""
    s = solve.state[0]
    o = output.record[0]
    schedules = events.schedules
    y = slot(None, solve.work, Y)
    acted = False
    t = s.t
    due = False
    for i in range(len(schedules)):
        e = schedules[i]
        if s.direction * (e.t_next - s.t) > 0.0:
            continue
        t = e.t_next
        due = True
        _sample_before(s, o, output, t, y)
        events.index[o.n_events] = len(events.table) + i
        events.t[o.n_events] = t
        copy_row(y, events.y[o.n_events])
        o.n_events += 1
        e.count += 1
        _move_on(e, s.direction)
        if e.limit > 0 and e.count >= e.limit:
            return EVENT
        if e.jump != 0:
            acted = True
            status = act(kernels, solve, scratch, e.jump, len(events.table) + i, t)
            if status != RUNNING:
                return status
    aim(s, o, output.segments, schedules)
    if acted or (due and o.every_step == WHOLE and s.t == s.t_old):  # begun anew by `arrive`
        store_behind(output, t, y)
    if acted:
        pass
    elif not have_met(events.table, t):
        return RUNNING
    elif has_rate(o, s.t != s.t_old):
        return _watch_on(kernels, solve, events.table, scratch, t, s.t - s.t_old)
    return _begin_behind(kernels, solve, output, events, scratch, t, s.t - s.t_old)


@njit(**INTERNAL)
def _sample_before(s, o, output, t, y):
    """Store the state before an action at the start of the span, if that time is asked for."""
    while o.i_eval < len(output.t_eval) and s.direction * (output.t_eval[o.i_eval] - t) <= 0.0:
        output.t[o.i_eval] = output.t_eval[o.i_eval]
        copy_row(y, output.y[o.i_eval])
        o.i_eval += 1
