"""The events of a step in the order of their times, up to the event that ends the step.

A note is an event and a time.  Notes lie in the output of events, behind the counted events.
"""

import numpy as np

from ...jit.options import INTERNAL, njit
from ..dense_output import polynomial
from ..events import ENDLESS, FAILED, NONE, PENDING, SIGN, ends_run, evaluate_all, never_ends
from ..meetings import APART, ROUNDING, near

JUMP = 1e-6  # share of the event function's size at which its value at a root is no rounding


@njit(**INTERNAL)
def sort(events, first, end, direction):
    """Sort the notes by time; notes of one time keep their order."""
    for k in range(first + 1, end):
        i, t, at = events.index[k], events.t[k], k
        while at > first and direction * (events.t[at - 1] - t) > 0.0:
            events.index[at], events.t[at] = events.index[at - 1], events.t[at - 1]
            at -= 1
        events.index[at], events.t[at] = i, t


@njit(**INTERNAL)
def count(events, first, end):
    """Count the notes up to the first event that ends the step; the count, and the event or NONE.

    An event that ends the run is counted; an event that changes the state is counted later.
    """
    for k in range(first, end):
        i = events.index[k]
        e = events.table[i]
        if e.jump != 0:
            return k, i
        ends = ends_run(e)
        e.count += 1
        if ends:
            e.root = events.t[k]
            return k + 1, i
    return end, NONE


@njit(**INTERNAL)
def meet(events, first, n, end, d, s, scratch):
    """Let all events whose times cannot be told from the time of note n occur with note n.

    Returns the event among them that ends the run, otherwise the event of note n; FAILED if a
    function raised; ENDLESS if events accumulate at one time.
    """
    table, t, cut, final = events.table, events.t[n], events.index[n], NONE
    h = s.t - s.t_old
    polynomial(d, (t - s.t_old) / h, scratch[0])
    if not evaluate_all(table, t, scratch[0], scratch[1]):
        return FAILED
    for k in range(first, end):
        if abs(events.t[k] - t) <= near(t):
            e = table[events.index[k]]
            if abs(e.g_new) > JUMP * e.size:  # behind a jump, the value tells the sign
                e.noise = 0.0
            else:
                e.noise = e.size * (ROUNDING + near(t) / abs(h)) + APART * abs(e.g_new)
            if k >= n:
                e.active, e.root = 1, t
    for i in range(len(table)):
        e = table[i]
        if not e.active:
            continue
        if never_ends(e, t):
            return ENDLESS
        if final < 0 and ends_run(e):
            final = i
    return cut if final < 0 else final


@njit(**INTERNAL)
def count_met(events, first, n, cut):
    """Store and count the events that occur together; return the new count."""
    table, before = events.table, n
    t, ends = table[cut].root, ends_run(table[cut])
    for i in range(len(table)):
        e = table[i]
        if not e.active:
            continue
        if ends and i > cut:
            e.active = 0
        elif e.jump != 0 and i != cut:
            e.active = (
                PENDING  # events act one after the other: this event acts on the other's new state
            )
            e.g = e.g if e.direction == 0.0 else -SIGN * np.sign(e.direction)
        else:
            e.count += 1
            events.index[n], events.t[n] = i, t
            n += 1
    for k in range(first, before):
        if abs(events.t[k] - t) <= near(t):
            table[events.index[k]].active = 1
    return n
