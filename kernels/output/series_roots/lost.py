"""Crossings of zero within a step that do not count, of methods with SciPy's results."""

import numpy as np

from ...calls.block import RAISED_WORD
from ...calls.user_function import raised, words_at
from ...jit.options import INTERNAL, njit
from ...state.rows import rows_on_stack
from ..arguments import IN_PARTS, MOST_PHASES, TELLS
from ..brent import crossing, value
from ..events import changes_sign
from .phases import MOST_PARTS, begin_parts, next_part
from .points import WIDTH, changes_of, fill_points
from .shallow import NOISE, TIME, VALUE, fill_shallow, is_noise, tolerance_of


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
        if e.parts == IN_PARTS:
            lost |= _lost_in_parts(solve, e, d, t, points, scratch)
            continue
        n = fill_points(e, d, s.t_old, t, s.t_old, h, points, scratch)
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
def _lost_in_parts(solve, e, d, t, points, scratch):
    """Note the first two crossings in the parts of a step up to t, if some are lost; 1 if so.

    A dip between two crossings that the tolerance of the step explains does not count.
    """
    s = solve.state[0]
    h = s.t - s.t_old
    counted = changes_sign(e)
    g = e.g
    g_new = e.g_new
    rows = rows_on_stack(3, MOST_PHASES)
    begin_parts(e, d, s.t_old, h, rows, scratch[0])
    a = s.t_old
    length = t - a
    changes = 0
    wanted = 0
    side = np.sign(g)
    begin = a
    deepest = 0.0
    t_deepest = a
    for _ in range(MOST_PARTS):
        b = next_part(e, d, s.t_old, h, a, length, t, rows, scratch[0])
        e.g_new = g_new if b == t else value(e.block, d, s.t_old, h, b, scratch[0], scratch[1])
        n = fill_points(e, d, a, b, s.t_old, h, points, scratch)
        for k in range(n):
            now = points[VALUE, k]
            turn = np.sign(now)
            if turn * side < 0.0:
                dip = tolerance_of(solve, e, d, t_deepest, scratch) if changes > 0 else 0.0
                if changes > 0 and deepest <= NOISE * dip:
                    changes -= 1
                    wanted -= side * e.direction >= 0.0
                else:
                    root = crossing(
                        e, d, begin, points[TIME, k], s.t_old, h, scratch[0], scratch[1]
                    )
                    if changes == 0:
                        e.lost = root
                    elif changes == 1:
                        e.lost_next = root
                    changes += 1
                    wanted += turn * e.direction >= 0.0
                deepest = 0.0
            if turn != 0.0 and turn == turn:
                side = turn
                begin = points[TIME, k]
            if abs(now) > deepest:
                deepest = abs(now)
                t_deepest = points[TIME, k]
        if b == t or raised(e.block) or (changes > 1 and wanted > counted):
            break
        e.g = e.g_new
        length = 2.0 * (b - a)
        a = b
    e.g = g
    e.g_new = g_new
    lost = changes > 1 and wanted > counted and not raised(e.block)
    words_at(e.block)[RAISED_WORD] = 0  # where SciPy does not look, nothing raises
    if not lost:
        e.lost = e.lost_next = np.nan
    return int(lost)


@njit(**INTERNAL)
def _flat(points, n):
    """The first of two points, one after the other, at which a function is exactly zero; or -1."""
    for k in range(1, n):
        if points[VALUE, k - 1] == 0.0 and points[VALUE, k] == 0.0:
            return k - 1
    return -1


@njit(**INTERNAL)
def _loses(solve, e, d, points, n, scratch):
    """Whether a step has more occurrences of an event than SciPy's; points of noise become zero."""
    while changes_of(points, n, 0.0) > 1 and changes_of(points, n, e.direction) > changes_sign(e):
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
