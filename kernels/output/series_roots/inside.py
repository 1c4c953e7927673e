"""Events of a step by signs inside the step: two crossings between its ends are found, too.

A function that has one sign at both ends of a step may cross zero twice between them.  If the
parabola through its values at both ends and in the middle comes near zero (`look`), the function is
evaluated on the interpolant, at PARTS - 1 points inside the step and where the values turn towards
zero between them: each change of sign is an occurrence.

Methods whose results are SciPy's or MATLAB's keep their occurrences, at most one a step; the first
two crossings of an event that are lost so are noted, for a warning.  Where the error of the step
may move the function more than it changes (`shallow`), crossings are not noted, and of a step of a
method that counts all the signs at the ends decide alone.
"""

import numpy as np

from ...calls.block import RAISED_WORD
from ...calls.user_function import raised, words_at
from ...jit.options import INTERNAL, njit
from ...state.rows import rows_on_stack
from ..arguments import COUNTS, PARTS, TELLS
from ..brent import crossing, edge, value
from ..dense_output import interpolate
from ..events import (
    FAILED,
    LEAVES,
    NONE,
    accept,
    changes_sign,
    is_contact,
    note,
    note_border,
    rests,
    root_in,
    settle,
)
from ..meetings import MET, NEVER, RAISES, distance_to_meet, has_rate, meet_schedule
from ..segments import is_border
from .shallow import TIME, VALUE, fill_shallow, is_noise

TURNS = 8  # most evaluations in search of one turning point
CLOSE = 1e-3  # distance of two estimates of a turning point, in parts, that ends the search
POINTS = 2 * PARTS  # most points in a step
WIDTH = 32  # length of the rows of the points


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
    cut = settle(kernels, solve, output, events, scratch, t, d, end, meets, 1)
    if lost and cut >= 0:
        lost = _forget_behind(s, table, table[cut].root)
    o.lost |= lost
    return cut


@njit(**INTERNAL)
def note_lost(solve, table, d, t, scratch):
    """Note the first two crossings of each event of which a step up to t loses some; 1 if any.

    One time twice notes a time at which the function of the event stays exactly zero.
    """
    s = solve.state[0]
    lost = 0
    points = rows_on_stack(2, WIDTH)
    h = s.t - s.t_old
    for i in range(len(table)):
        e = table[i]
        if e.within != TELLS:
            continue
        n = _points(e, d, t, s.t_old, h, points, scratch)
        e.size = 0.0
        flat = _flat(points, n)
        if flat >= 0:
            if not is_noise(solve, e, d, points, n, scratch):
                e.lost = e.lost_next = points[TIME, flat]
                lost = 1
        elif _loses(solve, e, d, points, n, scratch):
            _time_lost(e, d, s.t_old, h, points, n, scratch)
            lost = 1
        if raised(e.block):  # where SciPy does not look, nothing raises
            words_at(e.block)[RAISED_WORD] = 0
            e.lost = e.lost_next = np.nan
    return lost


@njit(**INTERNAL)
def _flat(points, n):
    """The first of two points, one after the other, at which a function is exactly zero; or -1."""
    for k in range(1, n):
        if points[VALUE, k - 1] == 0.0 and points[VALUE, k] == 0.0:
            return k - 1
    return -1


@njit(**INTERNAL)
def _forget_behind(s, table, t):
    """Forget lost crossings behind the event that ends a step at t; 1 if others are left."""
    left = 0
    for i in range(len(table)):
        e = table[i]
        if s.direction * (e.lost - t) > 0.0:
            e.lost = e.lost_next = np.nan
        left |= e.lost == e.lost
    return left


@njit(**INTERNAL)
def note_inside(solve, o, events, i, d, t, meets, end, scratch):
    """Note the occurrences of event i in a step; return the new end of the notes."""
    s = solve.state[0]
    e = events.table[i]
    h = s.t - s.t_old
    e.active = 0
    e.size = abs(e.g_new - e.g)
    points = rows_on_stack(2, WIDTH)
    n = 0
    changes = 0
    if e.within == COUNTS:
        n = _points(e, d, t, s.t_old, h, points, scratch)
        changes = _changes(points, n, 0.0)
        if _has_zeros(points, n):
            return _note_edges(s, o, events, i, d, (points, n), t, meets, end, scratch)
        if changes > 1 and is_noise(solve, e, d, points, n, scratch):
            changes = 0
    if changes <= 1:
        if changes_sign(e):
            root = root_in(e, d, s.t_old, t, s.t_old, h, scratch)
            if is_contact(e, root, s.t_old):
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
        if turn == 0.0:  # zero at the end of the step
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
        elif side == 0.0 and k > 0:  # zero at the start of the step
            root = root_in(e, d, s.t_old, points[TIME, k], s.t_old, h, scratch)
            wanted = e.direction == 0.0 or turn * e.direction > 0.0
            if wanted and not is_contact(e, root, s.t_old):
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

    Only the first if the event changes the state.  `looked` are the points and their number.
    """
    points, n = looked
    e = events.table[i]
    t_old = s.t_old
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
            known = root == t_old and (e.begins == LEAVES or is_contact(e, root, t_old))
        elif was == 0.0:
            root = edge(e, d, begin, stop, t_old, h, scratch[0], scratch[1])
        else:
            root = crossing(e, d, begin, stop, t_old, h, scratch[0], scratch[1])
        touches = now == 0.0 and root == stop and k < n - 1 and points[VALUE, k + 1] * was > 0.0
        if not (known or touches or turn * e.direction < 0.0):
            end = note(o, events, i, root, t, t_old, meets, end)
            if e.jump != 0:
                return end
    return end


@njit(**INTERNAL)
def _points(e, d, t, t_old, h, points, scratch):
    """Times and values of an event function in a step, in the order of the times; their number."""
    y = scratch[0]
    out = scratch[1]
    part = (t - t_old) / PARTS
    points[TIME, 0] = t_old
    points[VALUE, 0] = e.g
    points[TIME, PARTS] = t
    points[VALUE, PARTS] = e.g_new
    for k in range(1, PARTS):
        points[TIME, k] = t_old + k * part
        points[VALUE, k] = value(e.block, d, t_old, h, points[TIME, k], y, out)
        e.size = max(e.size, abs(points[VALUE, k] - e.g))
    n = PARTS + 1
    k = 1
    while k < n - 1 and n < POINTS:
        found = _turn(e, d, t_old, h, points, k, y, out)
        if found == found:
            after = k if abs(found - t_old) < abs(points[TIME, k] - t_old) else k + 1
            for j in range(n, after, -1):
                points[TIME, j] = points[TIME, j - 1]
                points[VALUE, j] = points[VALUE, j - 1]
            points[TIME, after] = found
            points[VALUE, after] = value(e.block, d, t_old, h, found, y, out)
            n += 1
            k += 2
        k += 1
    return n


@njit(**INTERNAL)
def _turn(e, d, t_old, h, points, k, y, out):
    """A time between points k - 1 and k + 1 at which a function has the other sign; NaN if none.

    The three values have one sign; parabolas through three points lead to the least size between.
    """
    a = points[TIME, k - 1]
    b = points[TIME, k]
    c = points[TIME, k + 1]
    sign = np.sign(points[VALUE, k])
    if points[VALUE, k - 1] * sign < 0.0 or not points[VALUE, k + 1] * sign > 0.0:
        return np.nan
    ga = abs(points[VALUE, k - 1])
    gb = abs(points[VALUE, k])
    gc = abs(points[VALUE, k + 1])
    bend = ga - 2.0 * gb + gc
    inside = abs(gc - ga) < 2.0 * bend and gb - (gc - ga) ** 2 / (8.0 * bend) < bend
    if not inside:
        return np.nan
    whole = abs(c - a)
    for _ in range(TURNS):
        left = (b - a) * (gb - gc)
        right = (b - c) * (gb - ga)
        if left == right:
            break
        x = b - 0.5 * ((b - a) * left - (b - c) * right) / (left - right)
        if not min(a, c) < x < max(a, c) or abs(x - b) < CLOSE * whole:
            break
        g = sign * value(e.block, d, t_old, h, x, y, out)
        if g < 0.0:
            return x
        between = (x - a) * (x - b) < 0.0
        if g < gb:
            if between:
                c = b
                gc = gb
            else:
                a = b
                ga = gb
            b = x
            gb = g
        elif between:
            a = x
            ga = g
        else:
            c = x
            gc = g
    return np.nan


@njit(**INTERNAL)
def _changes(points, n, direction):
    """The number of changes of sign between points in a direction, without those at zeros."""
    side = np.nan
    changes = 0
    for k in range(n):
        g = points[VALUE, k]
        if abs(g) > 0.0:
            turn = np.sign(g) - side
            if abs(turn) > 0.0 and turn * direction >= 0.0:
                changes += 1
            side = np.sign(g)
    return changes


@njit(**INTERNAL)
def _loses(solve, e, d, points, n, scratch):
    """Whether a step has more occurrences of an event than SciPy's; points of noise become zero."""
    while _changes(points, n, 0.0) > 1 and _changes(points, n, e.direction) > changes_sign(e):
        if not fill_shallow(solve, e, d, points, n, scratch):
            return True
    return False


@njit(**INTERNAL)
def _time_lost(e, d, t_old, h, points, n, scratch):
    """Note the times of the first two changes of sign between points."""
    at = 0
    for k in range(1, n):
        was = points[VALUE, at]
        now = points[VALUE, k]
        if now == 0.0:
            continue
        begin = points[TIME, at]
        at = k
        if was * now < 0.0:
            root = crossing(e, d, begin, points[TIME, k], t_old, h, scratch[0], scratch[1])
            if e.lost == e.lost:
                e.lost_next = root
                return
            e.lost = root
