"""Events at the times of schedules; the notes of events in a step, in the order of their times.

If the zero of an event function cannot be told from the time of a schedule, the event occurs at
this time, before the schedules act.  Rounding may put the zero before or behind the time.
"""

import numpy as np

from ..calls.user_function import evaluate
from ..jit.options import INTERNAL, njit
from ..state.record import K, Y
from .arguments import APART
from .brent import resolution
from .dense_output import polynomial
from .segments import end_of_span, is_border

ROUNDING = 1e-10  # share of the change of an event function that cannot be told from zero
NEVER = -1.0  # distance within which no event meets a schedule
MET = 3
RAISES = -1


@njit(**INTERNAL)
def near(t, unit):
    """The distance from t within which a root is at t."""
    return APART * resolution(t, unit)


@njit(**INTERNAL)
def distance_to_meet(s, o, segments, events, t):
    """The distance from t within which events occur at t: NEVER if no schedule acts at t.

    At a breakpoint, t is the end of the step before.
    """
    if is_border(s, o, segments):
        t = segments[o.i_segment, 2]
    for i in range(len(events.schedules)):
        if events.schedules[i].t_next == t and t != end_of_span(s, segments):
            return near(t, events.table[0].unit)
    return NEVER


@njit(**INTERNAL)
def has_rate(o, reached):
    """True if the rows of a step have the derivative at t; the rows of a series do not."""
    return reached and o.ends == 0


@njit(**INTERNAL)
def crosses_behind(e, t, y, out):
    """1 if an event function crosses zero between the time of g_new and t, where the state is y.

    -1 if the function raised.
    """
    if not ((e.g > 0.0 and e.g_new > 0.0) or (e.g < 0.0 and e.g_new < 0.0)):
        return 0
    if not evaluate(e.block, t, y, out):
        return RAISES
    down = e.g_new > 0.0 and out[0] <= 0.0 and e.direction <= 0.0
    up = e.g_new < 0.0 and out[0] >= 0.0 and e.direction >= 0.0
    return 1 if down or up else 0


@njit(**INTERNAL)
def meet_schedule(kernels, solve, events, d, t, ahead, by_rate, scratch):
    """Mark the events that cross zero within the distance `ahead` behind the time t of a schedule.

    The state at t + ahead is extrapolated by the derivative if `by_rate`, else by the interpolant
    d.  Returns the number of events, or RAISES.
    """
    s = solve.state[0]
    work = solve.work
    y = scratch[0]
    n = 0
    if by_rate:
        for i in range(len(y)):
            y[i] = work[Y, i] + ahead * work[K + kernels.fsal_stage, i]
    else:
        polynomial(d, (t + ahead - s.t_old) / (s.t - s.t_old), y)
    for i in range(len(events)):
        e = events[i]
        found = crosses_behind(e, t + ahead, y, scratch[1])
        if found == RAISES:
            return RAISES
        if found == 1:
            e.active = MET
            e.root = t
            n += 1
    return n


@njit(**INTERNAL)
def note_meeting(e, t, h, size):
    """Note that an event which changes no state has occurred at the time t of a schedule.

    `size` is the change of the event function in the step of length h.
    """
    e.active = 1
    e.t_jump = t
    e.noise = size * (ROUNDING + near(t, e.unit) / abs(h)) + APART * abs(e.g_new)


@njit(**INTERNAL)
def have_met(events, t):
    """True if an event has occurred at the time t of a schedule."""
    for i in range(len(events)):
        if abs(events[i].t_jump - t) <= near(t, events[i].unit):
            return True
    return False


@njit(**INTERNAL)
def sort(events, first, end, direction):
    """Sort the notes by time; notes of one time keep their order."""
    for k in range(first + 1, end):
        i = events.index[k]
        t = events.t[k]
        at = k
        while at > first and direction * (events.t[at - 1] - t) > 0.0:
            events.index[at], events.t[at] = events.index[at - 1], events.t[at - 1]
            at -= 1
        events.index[at] = i
        events.t[at] = t


@njit(**INTERNAL)
def forget_behind(s, table, t):
    """Forget lost crossings behind the event that ends a step at t; 1 if others are left."""
    left = 0
    for i in range(len(table)):
        e = table[i]
        if s.direction * (e.lost - t) > 0.0:
            e.lost = e.lost_next = np.nan
        left |= e.lost == e.lost
    return left
