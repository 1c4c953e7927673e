"""Events of a step by series: all zeros of an event function, not only its changes of sign.

The field `series` of an event is the address of a kernel

    series(t_old, h, work, block, out),

which reads the rows of the last step, writes to `out` the coefficients of the event function,

    g(t_old + x h) = sum out[k] x^k,

and returns the number of coefficients: at most MOST_TERMS, or 0 if the event has no series in this
step, or -1 if a part of the step may have one.  Without a series, Brent's method finds the zero.
`block` is the address of the event's block.

The remainder of the series at x = 1 is added as one more term, so that the polynomial ends with the
value of the event function, and no crossing is lost between two steps.
"""

import numpy as np

from ...calls.calling_convention import invoke
from ...jit.options import INTERNAL, njit
from ...state.rows import rows_on_stack, slot
from ..arguments import IN_PARTS, MOST_ROOTS, MOST_TERMS, WHOLE_STEP
from ..brent import value
from ..dense_output import interpolate, polynomial
from ..events import (
    FAILED,
    LEAVES,
    NONE,
    PLAIN,
    SIGN,
    accept,
    changes_sign,
    is_contact,
    note,
    settle,
)
from ..meetings import (
    NEVER,
    RAISES,
    crosses_behind,
    distance_to_meet,
)
from ..segments import is_border
from .at_border import note_border
from .bernstein import WIDTH
from .inside import note_inside
from .look import evaluate_end, may_turn, second_difference
from .phases import is_fast
from .polynomial_roots import GIVEN, PLACES, ROWS, TURNS, polynomial_roots
from .roots_in_parts import agrees, roots_in_parts

CONVERGED = 1e-9  # largest remainder of a series that is used, as a share of its sum


@njit(**INTERNAL)
def find_all(kernels, solve, output, events, scratch, t, reached, ready, d):
    """Record the events of a step up to t, each as often as it occurs; results as `find_inside`."""
    s = solve.state[0]
    o = output.record[0]
    table = events.table
    first = o.n_events
    if not evaluate_end(solve, events, scratch, t, reached, d):
        return FAILED
    at_border = is_border(s, o, output.segments)
    meets = distance_to_meet(s, o, output.segments, events, t)
    if not ready and _have_phases(table):
        interpolate(kernels, solve, d)
        ready = 1
    end, by_sign = _note_series(solve, o, events, d, t, meets, scratch)
    if end == first and not (by_sign or at_border) and meets == NEVER:
        accept(table)
        return NONE
    if not ready:
        interpolate(kernels, solve, d)
    if by_sign:
        end = _note_others(solve, o, events, d, t, meets, end, scratch)
    if meets != NEVER:
        end = _note_met(s, events, d, t, meets, first, end, scratch)
        if end == RAISES:
            return FAILED
    if at_border:
        end = note_border(solve, output, events, scratch, meets, end)
        if end == FAILED:
            return FAILED
        t = output.segments[o.i_segment, 2]
    return settle(kernels, solve, output, events, scratch, t, d, end, meets, 1)


@njit(**INTERNAL)
def _note_met(s, events, d, t, meets, first, end, scratch):
    """Note the events that meet a schedule at t; return the new end of the notes, or RAISES."""
    behind = t + s.direction * meets
    noted = end
    for k in range(first, end):
        if abs(events.t[k] - t) <= meets:
            events.table[events.index[k]].active = 1
    polynomial(d, (behind - s.t_old) / (s.t - s.t_old), scratch[0])
    for i in range(len(events.table)):
        e = events.table[i]
        if e.active == 0:
            found = crosses_behind(e, behind, scratch[0], scratch[1])
            if found == RAISES:
                return RAISES
            if found == 1:
                events.index[noted] = i
                events.t[noted] = t
                noted += 1
        e.active = 0
    return noted


@njit(**INTERNAL)
def _have_phases(table):
    for i in range(len(table)):
        if table[i].phases != 0:
            return True
    return False


@njit(**INTERNAL)
def _note_series(solve, o, events, d, t, meets, scratch):
    """Note the roots of all series; return the end of the notes, and whether other events act."""
    s = solve.state[0]
    room = rows_on_stack(ROWS, WIDTH)
    kept = rows_on_stack(2, MOST_ROOTS)
    end = o.n_events
    by_sign = False
    for i in range(len(events.table)):
        e = events.table[i]
        n = -1
        first = 0.0
        e.active = 0
        e.parts = WHOLE_STEP
        if e.phases != 0:
            polynomial(d, 0.5 * (t - s.t_old) / (s.t - s.t_old), scratch[0])
            if is_fast(solve, e, t, False, d, scratch[0], scratch[1]):
                e.parts = IN_PARTS
        if e.series != 0 and e.parts == WHOLE_STEP:
            n, first = _roots(e, solve, t, room, kept, scratch)
        if n < 0:
            e.active = 1
            by_sign = True
        elif _leaves_zero(e, first, s.t_old):
            end = note(o, events, i, s.t_old, t, s.t_old, meets, end)
        for j in range(n):
            if _is_wanted(e, kept[1, j]):
                x = kept[0, j]
                root = s.t_old if x == 0.0 else t if x == 1.0 else s.t_old + x * (t - s.t_old)
                end = note(o, events, i, root, t, s.t_old, meets, end)
    return end, by_sign


@njit(**INTERNAL)
def _roots(e, solve, t, room, kept, scratch):
    """The number of roots of an event function up to t, and its first sign; -1 without a series.

    `kept` receives the places of the roots and the signs behind the roots; g_new receives the value
    at the end of the step, or the sign behind the end if that value cannot be told from zero.
    """
    s = solve.state[0]
    c = slot(None, room, GIVEN)
    n = invoke(e.series, (s.t_old, t - s.t_old, solve.work, e.block, c))
    if n == 0 or n > MOST_TERMS:
        return -1, 0.0
    c[0] = begins = e.g if e.begins == PLAIN else SIGN * np.sign(e.g)
    total = size = 0.0
    for k in range(n):
        total += c[k]
        size += abs(c[k])
    c[max(n, 0)] = e.g_new - total
    believed = CONVERGED * size
    if (
        n > 0
        and abs(c[n]) <= believed
        and agrees(e, solve, 0.0, t - s.t_old, c[: n + 1], believed, scratch)
    ):
        found, side = polynomial_roots(c[: n + 1], room)
        for j in range(found):
            kept[0, j], kept[1, j] = room[PLACES, j], room[TURNS, j]
    else:
        scale_row = len(solve.work) - 1
        moved = scratch[2:]
        found, side, size = roots_in_parts(e, solve, t, begins, scale_row, room, kept, moved)
    e.size = size
    first = side
    for j in range(found - 1, -1, -1):
        if kept[1, j] != 0.0:
            first = -kept[1, j]
    if found >= 0 and side * e.g_new <= 0.0:  # else NaN stays NaN
        e.g_new = SIGN * side
    return found, first


@njit(**INTERNAL)
def _is_wanted(e, turn):
    """True if the user asks for events with the sign `turn` behind a root; 0: the same sign."""
    return e.direction == 0.0 or turn * e.direction > 0.0


@njit(**INTERNAL)
def _leaves_zero(e, first, t_old):
    """True if an event occurs because its function leaves zero at t_old, to the sign `first`.

    The function was zero before t_old, too, or the run begins there: the series has no root.
    """
    goes_on = e.jump != 0 and e.came * first < 0.0  # behind an action, across the zero
    leaves = e.g == 0.0 and abs(first) > 0.0 and (e.begins != LEAVES or goes_on)
    return leaves and _is_wanted(e, first) and not is_contact(e, t_old, t_old)


@njit(**INTERNAL)
def _note_others(solve, o, events, d, t, meets, end, scratch):
    """Note the events without a series by their signs; return the new end of the notes."""
    s = solve.state[0]
    middle = 0.5 * (s.t_old + t)
    h = s.t - s.t_old
    for i in range(len(events.table)):
        e = events.table[i]
        if e.active:
            e.active = 0
            e.within = e.inside
            if e.parts == IN_PARTS:
                end = note_inside(solve, o, events, i, d, t, meets, end, scratch)
                continue
            g = value(e.block, d, s.t_old, h, middle, scratch[0], scratch[1])
            bend = second_difference(e.g, g, e.g_new)
            if may_turn(e.g, g, e.g_new, bend) or changes_sign(e):
                end = note_inside(solve, o, events, i, d, t, meets, end, scratch)
    return end
