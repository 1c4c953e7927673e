"""Events: the sign changes of event functions, and which of them count.

Where `look` of `series_roots/` finds that an event may occur, at the end of a step or within,
its zeros are noted, by signs or by the series of the event function, in `series_roots/`; `settle`
counts the notes in the order of their times, up to the event that ends the step.  A rule which
occurrences count stands in `changes_sign` (and `_is_wanted` of the series, `note_inside` of signs
inside the step) if it asks for the sign, in `_drop` if it asks for the time, in `ends_run` if it
asks for the number.
"""

import numpy as np

from ..calls.user_function import evaluate
from ..jit.options import INLINED, INTERNAL, njit
from ..state.record import RAISED, RUNNING
from .arguments import APART, COUNTS, IN_PARTS
from .brent import crossing, crossing_from_zero, edge, resolution, takes_edges, value
from .dense_output import polynomial
from .meetings import ROUNDING, forget_behind, near, note_meeting, sort
from .projection import project_events

# The value of an event function at the start of a step.  PLAIN: any value.  LEAVES: zero, because
# the event has just occurred; `g` has the sign behind.  TOUCHES: zero, because of another event.
# STAYS: exactly zero, as one step before; only of an event that changes the state.
PLAIN, LEAVES, TOUCHES, STAYS = range(4)
PENDING = 2

NONE, FAILED, ENDLESS = -1, -2, -3  # no event; a function raised; events accumulate at one time
MOST_REPEATS = 1000
JUMP = 1e-6  # share of the event function's size at which its value at a root is no rounding
# The same for roots by signs, which are less precise: a ball that comes to rest has 228 impacts
# with a share of 1e-6; with 1e-2 it has 274 and more, as by energy.
JUMP_OF_SIGNS = 1e-2
# Share of a step at whose start a function with a slope of zero may be zero by rounding: with a
# curvature, for 1e-8 of its time scale; with a third derivative alone, for 1e-5.
LIFTS = 2.0**-8
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
        e = events[i]
        begin_behind(e)


@njit(**INLINED)
def begin_behind(e):
    """Let the next step, or part of a step, begin with the value at the end of this one."""
    e.begins = STAYS if _stays(e) else PLAIN
    e.g = e.g_new


@njit(**INLINED)
def _stays(e):
    """True if the function of an event that changes the state was zero in all of a step."""
    return e.g == 0.0 and e.g_new == 0.0 and e.jump != 0


@njit(**INTERNAL)
def open_events(events, t, y, scratch):
    """Evaluate the events at the start, before the first step; RUNNING or RAISED."""
    if not evaluate_all(events, t, y, scratch):
        return RAISED
    accept(events)
    for i in range(len(events)):
        e = events[i]
        e.begins = PLAIN
        e.count = 0
        e.bend = 0.0
        e.fine = np.inf
        e.slope = e.lost = e.lost_next = np.nan
        e.t_jump = np.nan
        e.t_last = e.last
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
    return 1 if wanted and not rests(e, e.g_new) else 0


@njit(**INTERNAL)
def rests(e, g):
    """True if the function of an event that changes the state was zero, and has not left zero.

    `g` is a later value in the same step.  Such an event is switched off, or stays in contact.  An
    event that leaves an interval of zeros occurs at the end of the interval; see `is_contact` for a
    zero by itself.
    """
    if e.jump == 0 or g != 0.0:
        return False
    return e.g == 0.0 or e.begins == TOUCHES


@njit(**INLINED)
def is_contact(e, root, t_from):
    """True if an event that changes the state leaves a zero by itself, without a direction.

    The zero is at the start t_from of a step, or of a part, and has not just counted.
    """
    begins = e.jump != 0 and e.begins == PLAIN and e.g == 0.0
    return begins and e.direction == 0.0 and root == t_from


@njit(**INTERNAL)
def ends_run(e):
    """True if the next occurrence of an event ends the run."""
    return e.limit > 0 and e.count + 1 >= e.limit


@njit(**INLINED)
def waits(e, last, t):
    """True if an occurrence at t comes too early behind the last one; NaN before the first."""
    return abs(t - last) < e.wait


@njit(**INTERNAL)
def never_ends(e, t):
    """True if an event has just changed the state at t, and may not act there again."""
    just = e.jump != 0 and abs(t - e.t_jump) <= near(t, e.unit)
    return just and (e.begins != TOUCHES or e.repeats == MOST_REPEATS)


@njit(**INTERNAL)
def root_in(e, d, t_from, t, t_old, h, scratch):
    """The time from t_from on in a step at which an active event occurs."""
    if takes_edges(e) and e.g == 0.0 and e.begins != TOUCHES:
        return edge(e, d, t_from, t, t_old, h, scratch[0], scratch[1])
    if e.begins == PLAIN:
        return crossing(e, d, t_from, t, t_old, h, scratch[0], scratch[1])
    if e.begins == TOUCHES or e.g == 0.0:
        return t_from
    return crossing_from_zero(e, d, t_from, t, t_old, h, scratch[0], scratch[1])


@njit(**INTERNAL)
def note(o, events, i, root, t, t_old, meets, end):
    """Note an occurrence of event i, unless it is recorded; return the new end of the notes.

    A note is an event and a time.  Notes lie in the output of events, behind the counted events.
    A root within the distance `meets` of t is at t.  An event that has just acted does not occur
    if its function goes back to the side that it came from, or keeps its value behind the action.
    """
    e = events.table[i]
    if abs(root - t) <= meets:
        root = t
    elif (o.jumps != 0 or e.begins == LEAVES) and abs(root - t_old) <= resolution(t_old, e.unit):
        root = t_old
        if e.begins == LEAVES and (e.jump == 0 or e.g_new == 0.0):  # zero all the time
            return end
    if e.begins == LEAVES and e.g == 0.0 and e.jump != 0:  # behind the action its slope is zero
        at_once = abs(root - t_old) <= LIFTS * abs(t - t_old)
        if (at_once and e.g_new * e.came >= 0.0) or abs(e.g_new) <= e.rest:
            return end
        root = t_old if at_once else root
    events.index[end] = i
    events.t[end] = root
    return end + 1


@njit(**INTERNAL)
def settle(kernels, solve, output, events, scratch, t, d, end, meets, acts):
    """Record the notes that count, up to the first event that ends the step.

    Returns this event, NONE, FAILED or ENDLESS.
    """
    s = solve.state[0]
    o = output.record[0]
    table = events.table
    first = o.n_events
    sort(events, first, end, s.direction)
    end = _drop(events, first, end)
    n, cut = _count(events, first, end)
    if acts is not None:
        if cut >= 0 and table[cut].jump != 0:
            cut = _meet(events, first, n, end, d, s, scratch)
            if cut < 0:
                return cut
            n = _count_met(events, first, n, cut)
    for i in range(first, n):
        polynomial(d, (events.t[i] - s.t_old) / (s.t - s.t_old), events.y[i])
    o.n_events = n
    if acts is not None:
        if not project_events(kernels, events, first, n, scratch):
            return FAILED
        if cut < 0:
            for i in range(first, n):
                if abs(events.t[i] - t) <= meets:
                    e = table[events.index[i]]
                    note_meeting(e, t, s.t - s.t_old, e.size)
    if cut < 0:
        accept(table)
    elif o.lost != 0:
        o.lost = forget_behind(s, table, table[cut].root)
    return cut


@njit(**INTERNAL)
def _drop(events, first, end):
    """Drop the notes that no rule of their events lets count; return the new end of the notes."""
    n = first
    for k in range(first, end):
        i = events.index[k]
        t = events.t[k]
        e = events.table[i]
        last = e.t_last
        for j in range(first, n):
            if events.index[j] == i:
                last = events.t[j]
        again = t == last and e.inside == COUNTS and e.jump == 0  # a zero where two steps meet
        if not (again or waits(e, last, t)):
            events.index[n] = i
            events.t[n] = t
            n += 1
    return n


@njit(**INLINED)
def _take(e, t):
    """Count an occurrence of an event."""
    e.count += 1
    e.t_last = t


@njit(**INTERNAL)
def _count(events, first, end):
    """Count the notes up to the first event that ends the step; the count, and the event or NONE.

    An event that ends the run is counted; an event that changes the state is counted later.
    """
    for k in range(first, end):
        i = events.index[k]
        e = events.table[i]
        if e.jump != 0:
            return k, i
        ends = ends_run(e)
        _take(e, events.t[k])
        if ends:
            e.root = events.t[k]
            return _count_at_once(events, k, end, e), i
    return end, NONE


@njit(**INTERNAL)
def _count_at_once(events, k, end, e):
    """Count the notes that cannot be told from note k, of the event e, which ends the run.

    SciPy leaves out events behind the one that ends a run, in their order at one time.
    """
    n = k + 1
    for j in range(k + 1, end):
        other = events.table[events.index[j]]
        at_once = abs(events.t[j] - e.root) <= near(e.root, e.unit)
        if (
            at_once
            and e.inside == COUNTS
            and other.jump == 0
            and events.index[j] != events.index[k]
        ):
            events.index[n] = events.index[j]
            events.t[n] = e.root
            _take(other, e.root)
            n += 1
    return n


@njit(**INTERNAL)
def _meet(events, first, n, end, d, s, scratch):
    """Let all events whose times cannot be told from the time of note n occur with note n.

    So does an event that is noted for later and has crossed zero at this time, by rounding.
    Returns the event among them that ends the run, otherwise the event of note n; FAILED if a
    function raised; ENDLESS if events accumulate at one time.
    """
    table = events.table
    t = events.t[n]
    cut = events.index[n]
    final = NONE
    h = s.t - s.t_old
    nearly = LIFTS * abs(h)
    polynomial(d, (t - s.t_old) / h, scratch[0])
    if not evaluate_all(table, t, scratch[0], scratch[1]):
        return FAILED
    for k in range(first, end):
        e = table[events.index[k]]
        if abs(events.t[k] - t) <= near(t, e.unit) or (
            k > n and _is_over(events, first, k, t, nearly)
        ):
            jump = JUMP if e.series != 0 else JUMP_OF_SIGNS
            if abs(e.g_new) > jump * e.size:  # behind a jump, the value tells the sign
                e.noise = 0.0
            else:
                e.noise = e.size * (ROUNDING + near(t, e.unit) / abs(h)) + APART * abs(e.g_new)
                if e.parts == IN_PARTS:  # the function changes faster than `size` in a step
                    before = t - s.direction * near(t, e.unit)
                    moved = value(e.block, d, s.t_old, h, before, scratch[0], scratch[1])
                    e.noise += abs(moved - e.g_new)
            if k >= n:
                e.active = 1
                e.root = t
    for i in range(len(table)):
        e = table[i]
        if not e.active:
            if t != s.t_old and _stays(e):
                e.begins = STAYS
            continue
        if never_ends(e, t):
            return ENDLESS
        if final < 0 and ends_run(e):
            final = i
    return cut if final < 0 else final


@njit(**INTERNAL)
def _is_over(events, first, k, t, nearly):
    """True if note k is the first of an event without series, whose g_new is not on g's side.

    g_new is the value at t, before the note; rounding explains a distance `nearly`.
    """
    e = events.table[events.index[k]]
    if e.series != 0:  # whose root is exact, and may be close behind another root
        return False
    if e.g_new * e.direction < 0.0 or (e.wait > 0.0 and abs(events.t[k] - t) > nearly):
        return False  # behind a crossing that does not count, and has no note
    for j in range(first, k):
        if events.index[j] == events.index[k]:
            return False
    return not ((e.g > 0.0 and e.g_new > 0.0) or (e.g < 0.0 and e.g_new < 0.0))


@njit(**INTERNAL)
def _count_met(events, first, n, cut):
    """Store and count the events that occur together; return the new count."""
    table = events.table
    before = n
    t = table[cut].root
    ends = ends_run(table[cut])
    for i in range(len(table)):
        e = table[i]
        if not e.active:
            continue
        if ends and i > cut:
            e.active = 0
        elif e.jump != 0 and i != cut:
            e.active = PENDING  # one event acts at a time: this event acts on the other's new state
            e.g = e.g if e.direction == 0.0 else -SIGN * np.sign(e.direction)
        else:
            _take(e, t)
            events.index[n] = i
            events.t[n] = t
            n += 1
    for k in range(first, before):
        if abs(events.t[k] - t) <= near(t, table[cut].unit):
            table[events.index[k]].active = 1
    return n
