"""Events: the sign changes of event functions, and their times within a step."""

import numpy as np

from ..calls.user_function import evaluate
from ..jit.options import INLINED, INTERNAL, njit
from ..state.record import RAISED, RUNNING, Y
from ..state.rows import copy_row
from .brent import crossing, crossing_from_zero, resolution
from .dense_output import interpolate, polynomial
from .meetings import (
    APART,
    MET,
    NEVER,
    RAISES,
    ROUNDING,
    distance_to_meet,
    has_rate,
    meet_schedule,
    near,
    note_meeting,
)
from .projection import project_events
from .segments import first_time

# The value of an event function at the start of a step.  PLAIN: any value.  LEAVES: zero, because
# the event has just occurred; `g` has the sign behind.  TOUCHES: zero, because of another event.
PLAIN, LEAVES, TOUCHES = range(3)
PENDING = 2

NONE, FAILED, ENDLESS = -1, -2, -3  # no event; a function raised; events accumulate at one time
MOST_REPEATS = 1000
SIGN = 1e-300  # value of an event function of which only the sign is known


@njit(**INTERNAL)
def evaluate_all(events, t, y, scratch):
    """Evaluate g_new of each event; False if a function raised."""
    for i in range(len(events)):
        if not evaluate(events[i].block, t, y, scratch):
            return False
        events[i].g_new = scratch[0]
    return True


@njit(**INTERNAL)
def accept(events):
    """Let the next step begin with the values at the end of this step."""
    for i in range(len(events)):
        events[i].g, events[i].begins = events[i].g_new, PLAIN


@njit(**INTERNAL)
def open_events(events, t, y, scratch):
    """Evaluate the events at the start, before the first step; RUNNING or RAISED."""
    if not evaluate_all(events, t, y, scratch):
        return RAISED
    accept(events)
    for i in range(len(events)):
        events[i].count, events[i].t_jump = 0, np.nan
    return RUNNING


@njit(**INTERNAL)
def find_active(events):
    """Mark the events that changed sign in their direction; return their number."""
    n = 0
    for i in range(len(events)):
        events[i].active = changes_sign(events[i])
        n += events[i].active
    return n


@njit(**INLINED)
def changes_sign(e):
    """1 if an event changed sign in its direction, else 0."""
    up = e.g <= 0.0 and e.g_new >= 0.0
    down = e.g >= 0.0 and e.g_new <= 0.0
    wanted = (up and e.direction >= 0.0) or (down and e.direction <= 0.0)
    return 1 if wanted and not (e.jump != 0 and _rests(e)) else 0


@njit(**INTERNAL)
def _rests(e):
    """True if the function of an event that changes the state was zero, and did not cross zero.

    Such an event is switched off, stays in contact, or leaves zero in a direction not asked for.
    """
    if e.begins == PLAIN:
        return e.g == 0.0 and (e.g_new == 0.0 or e.direction == 0.0)
    return e.g_new == 0.0


@njit(**INTERNAL)
def ends_run(e):
    """True if the next occurrence of an event ends the run."""
    return e.limit > 0 and e.count + 1 >= e.limit


@njit(**INTERNAL)
def never_ends(e, t):
    """True if an event has just changed the state at t, and may not act there again."""
    just = e.jump != 0 and abs(t - e.t_jump) <= near(t)
    return just and (e.begins != TOUCHES or e.repeats == MOST_REPEATS)


@njit(**INTERNAL)
def root_in(e, d, t_from, t, t_old, h, scratch):
    """The time in a step at which an active event occurs."""
    if e.begins == PLAIN:
        return crossing(e.block, d, t_from, t, t_old, h, scratch[0], scratch[1])
    if e.begins == TOUCHES or e.g == 0.0:
        return t_old
    return crossing_from_zero(e.block, e.g, d, t_old, t, t_old, h, scratch[0], scratch[1])


@njit(**INTERNAL)
def locate(events, d, t_from, t, t_old, h, direction, jumps, meets, scratch):
    """Find the root of each active event in [t_from, t]; the first event that ends the step.

    Roots within the distance `meets` of t are at t.
    """
    first = NONE
    for i in range(len(events)):
        e = events[i]
        if not e.active:
            continue
        if e.active == MET:
            e.active = 1
        else:
            e.root = root_in(e, d, t_from, t, t_old, h, scratch)
        if abs(e.root - t) <= meets:
            e.root = t
        elif (jumps != 0 or e.begins == LEAVES) and abs(e.root - t_old) <= resolution(t_old):
            e.root = t_old
            if e.begins == LEAVES and e.jump == 0:
                e.active = 0  # already recorded
                continue
        if e.jump != 0 or ends_run(e):
            if first < 0 or direction * (e.root - events[first].root) < 0.0:
                first = i
    return first


@njit(**INTERNAL)
def coincide(events, cut, d, t_old, h, direction, scratch):
    """Activate every event whose function is zero at the time of the event that ends the step.

    Returns the event among them that ends the run, otherwise `cut`; FAILED if a function raised;
    ENDLESS if events accumulate at one time.
    """
    t, final = events[cut].root, NONE
    for i in range(len(events)):
        e = events[i]
        if e.active:
            e.noise = abs(e.g_new - e.g) * (ROUNDING + near(t) / abs(h))
    polynomial(d, (t - t_old) / h, scratch[0])
    if not evaluate_all(events, t, scratch[0], scratch[1]):
        return FAILED
    for i in range(len(events)):
        e = events[i]
        if not e.active:
            continue
        if direction * (e.root - t) > 0.0:
            if (e.g > 0.0 and e.g_new > 0.0) or (e.g < 0.0 and e.g_new < 0.0):
                continue
            e.root = t
        e.noise += APART * abs(e.g_new)
        if never_ends(e, t):
            return ENDLESS
        if final < 0 and ends_run(e):
            final = i
    return cut if final < 0 else final


@njit(**INTERNAL)
def record(events, cut, d, t_old, h, direction, n):
    """Store the active events up to the event that ends the step; return the new count."""
    table = events.table
    ends = cut >= 0 and ends_run(table[cut])
    for i in range(len(table)):
        e = table[i]
        if not e.active:
            continue
        if cut >= 0:
            later = direction * (e.root - table[cut].root)
            if later > 0.0 or (later == 0.0 and i > cut and ends):
                e.active = 0
                continue
            if e.jump != 0 and i != cut:
                e.active = PENDING  # one event acts at a time: this event acts after the other
                continue
        e.count += 1
        events.index[n], events.t[n] = i, e.root
        polynomial(d, (e.root - t_old) / h, events.y[n])
        n += 1
    return n


@njit(**INLINED)
def evaluate_end(solve, events, scratch, t, reached, d):
    """Evaluate g_new of each event at the end of a step; False if a function raised."""
    s = solve.state[0]
    if reached:
        copy_row(solve.work[Y], scratch[0])
    else:
        polynomial(d, (t - s.t_old) / (s.t - s.t_old), scratch[0])
    return evaluate_all(events.table, t, scratch[0], scratch[1])


@njit(**INTERNAL)
def find_events(kernels, solve, output, events, scratch, t, reached, ready, d, acts):
    """Record the events of a step up to t.

    `acts` is None for a solve without schedules, jumps, projection and breakpoints.

    Returns the event that ends the step, NONE, FAILED or ENDLESS.
    """
    s, o, table = solve.state[0], output.record[0], events.table
    t_old, h = s.t_old, s.t - s.t_old
    if not evaluate_end(solve, events, scratch, t, reached, d):
        return FAILED
    n_active, meets, t_from = find_active(table), NEVER, t_old
    if acts is not None:
        t_from = first_time(s, o, output.segments)
        meets = distance_to_meet(s, output.segments, events.schedules, t)
        if meets != NEVER:
            by_rate = has_rate(o, reached)
            if not ready and not by_rate:
                interpolate(kernels, solve, d)
                ready = True
            met = meet_schedule(kernels, solve, table, d, t, s.direction * meets, by_rate, scratch)
            if met == RAISES:
                return FAILED
            n_active += met
    if n_active == 0:
        accept(table)
        return NONE
    if not ready:
        interpolate(kernels, solve, d)
    cut = locate(table, d, t_from, t, t_old, h, s.direction, o.jumps, meets, scratch)
    if acts is not None:
        if cut >= 0 and table[cut].jump != 0:
            cut = coincide(table, cut, d, t_old, h, s.direction, scratch)
            if cut < 0:
                return cut
    first = o.n_events
    o.n_events = record(events, cut, d, t_old, h, s.direction, first)
    if acts is not None:
        if not project_events(kernels, events, first, o.n_events, scratch):
            return FAILED
    if cut < 0:
        if acts is not None:
            for i in range(len(table)):
                if table[i].active and abs(table[i].root - t) <= meets:
                    note_meeting(table[i], t, h, abs(table[i].g_new - table[i].g))
        accept(table)
    return cut
