"""Events of a step by signs inside the step: two crossings between its ends are found, too.

A function that has one sign at both ends of a step may cross zero twice between them.  If the
parabola through its values at both ends and in the middle comes near zero (`look`), the function is
evaluated on the interpolant, at PARTS - 1 points inside the step and where the values turn towards
zero between them: each change of sign is an occurrence.  A step in which an event function is
faster than the solution is looked at in parts (`phases.py`), each like a step.

Methods whose results are SciPy's or MATLAB's keep their occurrences, at most one a step; the first
two crossings of an event that are lost so are noted, for a warning.  Where the error of the step
may move the function more than it changes (`shallow`), crossings are not noted, and of a step of a
method that counts all the signs at the ends decide alone.
"""

import numpy as np

from ...calls.user_function import raised
from ...jit.options import INTERNAL, njit
from ...state.rows import rows_on_stack
from ..arguments import COUNTS, IN_PARTS, MOST_INSIDE, MOST_PHASES, TELLS
from ..brent import crossing, edge, value
from ..dense_output import interpolate
from ..events import (
    FAILED,
    LEAVES,
    NONE,
    accept,
    begin_behind,
    changes_sign,
    is_contact,
    note,
    rests,
    root_in,
    settle,
    waits,
)
from ..meetings import MET, NEVER, RAISES, distance_to_meet, has_rate, meet_schedule
from ..segments import is_border
from .at_border import note_border
from .lost import note_lost
from .phases import MOST_PARTS, begin_parts, next_part
from .points import POINTS, WIDTH, changes_of, fill_points, is_rough
from .shallow import TIME, VALUE, is_noise

SHORTEST = 2.0**-14  # share of a step, of the parts of a function without phases


@njit(**INTERNAL)
def find_inside(kernels, solve, output, events, scratch, t, reached, ready, d):
    """Record the events that `look` has marked, up to t.

    Returns the event that ends the step, NONE, FAILED or ENDLESS.
    """
    s = solve.state[0]
    o = output.record[0]
    table = events.table
    meets = distance_to_meet(s, o, output.segments, events, t)
    if meets != NEVER:
        by_rate = has_rate(o, reached)
        if not ready and not by_rate:
            interpolate(kernels, solve, d)
            ready = 1
        met = meet_schedule(kernels, solve, table, d, t, s.direction * meets, by_rate, scratch)
        if met == RAISES:
            return FAILED
    at_border = is_border(s, o, output.segments)
    n_active = 0
    n_told = 0
    for i in range(len(table)):
        table[i].size = 0.0
        n_active += table[i].active != 0
        n_told += table[i].within == TELLS
    occurs = n_active > 0 or at_border
    counted = s.n_extra
    if not ready and (occurs or n_told > 0):
        interpolate(kernels, solve, d)
    lost = note_lost(solve, table, d, t, scratch) if n_told > 0 else 0
    if not occurs:
        s.n_extra = counted  # the look alone takes no evaluations of SciPy's
        o.lost |= lost
        accept(table)
        return NONE
    end = o.n_events
    for i in range(len(table)):
        e = table[i]
        met = e.active == MET
        if e.active and (e.within == COUNTS or not met):
            end = note_inside(solve, o, events, i, d, t, meets, end, scratch)
            if raised(e.block):
                return FAILED
        if met:
            e.active = 0
            e.size = max(e.size, abs(e.g_new - e.g))
            end = note(o, events, i, t, t, s.t_old, meets, end)
    if at_border:
        end = note_border(solve, output, events, scratch, meets, end)
        if end == FAILED:
            return FAILED
        t = output.segments[o.i_segment, 2]
    o.lost |= lost
    return settle(kernels, solve, output, events, scratch, t, d, end, meets, 1)


@njit(**INTERNAL)
def note_inside(solve, o, events, i, d, t, meets, end, scratch):
    """Note the occurrences of event i in a step; return the new end of the notes."""
    s = solve.state[0]
    e = events.table[i]
    g = e.g
    g_new = e.g_new
    begins = e.begins
    most = end + MOST_INSIDE - POINTS
    points = rows_on_stack(2, WIDTH)
    rows = rows_on_stack(3, MOST_PHASES)
    h = s.t - s.t_old
    a = s.t_old
    length = t - a
    fast = e.parts == IN_PARTS and e.within == COUNTS  # else at most one occurrence in a step
    if fast:
        begin_parts(e, d, s.t_old, h, rows, scratch[0])
    elif e.fine < abs(length):
        length = np.copysign(e.fine, h)
    e.active = 0
    e.size = 0.0
    n = 0
    for part in range(MOST_PARTS):
        if fast:
            b = next_part(e, d, s.t_old, h, a, length, t, rows, scratch[0])
        else:
            b = t if abs(length) >= abs(t - a) else a + length
        e.g_new = g_new if b == t else value(e.block, d, s.t_old, h, b, scratch[0], scratch[1])
        e.size = max(e.size, abs(e.g_new - e.g))
        if e.within == COUNTS:
            n = fill_points(e, d, a, b, s.t_old, h, points, scratch)
        if not fast and abs(length) > SHORTEST * abs(h) and is_rough(points, n):
            if not is_noise(solve, e, d, points, n, scratch):
                length *= 0.25
                e.fine = abs(length)
                continue
        before = end
        end = _note_part(solve, o, events, i, d, (points, n, a, b), t, meets, end, scratch)
        if b == t or raised(e.block) or _acts(events, before, end):
            break
        if end > most or part + 1 == MOST_PARTS:
            e.lost = b
            e.lost_next = s.t_old
            o.lost = 1
            break
        begin_behind(e)
        length = 2.0 * (b - a)
        a = b
    e.g = g
    e.g_new = g_new
    e.begins = begins
    return end


@njit(**INTERNAL)
def _acts(events, before, end):
    """True if one of the notes of an event, from `before` on, changes the state."""
    for k in range(before, end):
        e = events.table[events.index[k]]
        if e.jump != 0 and not waits(e, e.t_last, events.t[k]):
            return True
    return False


@njit(**INTERNAL)
def _note_part(solve, o, events, i, d, part, t, meets, end, scratch):
    """Note the occurrences of event i in a part of a step up to t.

    `part` has the points of the part, their number, its start and its end, at which e has the
    values of the function.
    """
    s = solve.state[0]
    e = events.table[i]
    h = s.t - s.t_old
    points, n, a, b = part
    changes = 0
    if n > 0:
        changes = changes_of(points, n, 0.0) + (e.g == 0.0) + (e.g_new == 0.0)
        if _has_zeros(points, n):
            return _note_edges(s, o, events, i, d, (points, n), t, meets, end, scratch)
        if changes > 1 and is_noise(solve, e, d, points, n, scratch):
            changes = 0
    if changes <= 1:
        if changes_sign(e):
            root = root_in(e, d, a, b, s.t_old, h, scratch)
            if is_contact(e, root, a):
                return end
            end = note(o, events, i, root, t, s.t_old, meets, end)
        return end
    side = 0.0
    at = 0
    for k in range(n):
        g = points[VALUE, k]
        turn = np.sign(g)
        if not abs(g) > 0.0 and not (k == n - 1 and g == 0.0):
            continue
        if turn == 0.0:  # zero at the end
            turn = -side
        if turn * side < 0.0:
            if e.direction == 0.0 or turn * e.direction > 0.0:
                begin = points[TIME, at]
                stop = points[TIME, k]
                if at == 0:
                    root = root_in(e, d, begin, stop, s.t_old, h, scratch)
                else:
                    root = crossing(e, d, begin, stop, s.t_old, h, scratch[0], scratch[1])
                end = note(o, events, i, root, t, s.t_old, meets, end)
        elif side == 0.0 and k > 0:  # zero at the start
            root = root_in(e, d, a, points[TIME, k], s.t_old, h, scratch)
            wanted = e.direction == 0.0 or turn * e.direction > 0.0
            if wanted and not is_contact(e, root, a):
                end = note(o, events, i, root, t, s.t_old, meets, end)
        side = turn
        at = k
    return end


@njit(**INTERNAL)
def _has_zeros(points, n):
    """True if a function is exactly zero at both ends of the step, or at a point inside."""
    if points[VALUE, 0] == 0.0 and points[VALUE, n - 1] == 0.0:
        return True
    for k in range(1, n - 1):
        if points[VALUE, k] == 0.0:
            return True
    return False


@njit(**INTERNAL)
def _note_edges(s, o, events, i, d, looked, t, meets, end, scratch):
    """Note the occurrences of event i with zeros as `_has_zeros` says; return the end of the notes.

    Up to the first that changes the state.  `looked` are the points and their number.
    """
    points, n = looked
    e = events.table[i]
    t_old = s.t_old
    a = points[TIME, 0]
    h = s.t - t_old
    root = np.nan
    for k in range(1, n):
        was = points[VALUE, k - 1]
        now = points[VALUE, k]
        turn = np.sign(now) - np.sign(was)
        if not abs(turn) > 0.0 or (k == 1 and rests(e, now)):
            continue
        begin = points[TIME, k - 1]
        stop = points[TIME, k]
        known = root == begin  # a zero by itself, of which both sides are seen
        if k == 1:
            root = root_in(e, d, begin, stop, t_old, h, scratch)
            known = root == a and (e.begins == LEAVES or is_contact(e, root, a))
        elif was == 0.0:
            root = edge(e, d, begin, stop, t_old, h, scratch[0], scratch[1])
        else:
            root = crossing(e, d, begin, stop, t_old, h, scratch[0], scratch[1])
        touches = now == 0.0 and root == stop and k < n - 1 and points[VALUE, k + 1] * was > 0.0
        if not (known or touches or turn * e.direction < 0.0):
            before = end
            end = note(o, events, i, root, t, t_old, meets, end)
            if e.jump != 0 and (end == before or _acts(events, before, end)):
                return end
    return end
