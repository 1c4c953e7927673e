"""Where a step may have an event: its function has changed its sign, or may have, twice.

The functions are evaluated at the end of each step, and in its middle if the values at the ends of
the last two steps come near zero, compared with their second difference.  The phases of functions
that may be faster than the solution are read in each step (`phases.py`).
"""

from ...calls.block import MASS, RAISED_WORD
from ...calls.user_function import evaluate, words_at
from ...jit.options import INLINED, INTERNAL, njit
from ...state.record import Y_OLD, K, Y
from ...state.rows import copy_row
from ..arguments import ASKS, COUNTS, IN_PARTS, KEEPS, SERIES, SLOPES, TELLS, WHOLE_STEP
from ..dense_output import interpolate, polynomial
from ..events import FAILED, NONE, accept, evaluate_all, find_active
from ..meetings import NEVER, distance_to_meet
from ..segments import is_border
from .phases import is_fast

BUSY = -4  # an event may have occurred
# Share of the second difference within which a function comes near zero.  A sine of a period a step
# is a fifth of it away from the parabola; with 0.5 instead of 0.75, and without FADES, 18 of 241
# steps with two crossings of random functions were lost, up to 0.28 of a step apart.
SHARE = 0.75
FADES = 0.5  # share of an earlier step's second difference; a power of 2, see `from_lane`
FAR = 8.0  # second differences from zero, beyond which the middle of a step is not looked at
STEEP = 4.0  # second differences to which a change of sign rises that is the only one of a step


@njit(**INLINED)
def look(kernels, solve, output, events, scratch, t, reached, ready, d, acts):
    """Evaluate the events at the end t of a step, and in the middle; mark those that may occur.

    `acts` is None for a solve without schedules, jumps, projection and breakpoints.  Returns BUSY
    if an event may occur, else NONE, with the next step begun; or FAILED.
    """
    s = solve.state[0]
    o = output.record[0]
    table = events.table
    if table[0].middle == SERIES:  # the kernel at the address `find` looks at all coefficients
        return BUSY
    if not evaluate_end(solve, events, scratch, t, reached, d):
        return FAILED
    n_active = find_active(table)
    if find_doubtful(table, t - s.t_old) > 0:
        n_active += find_turning(kernels, solve, table, t, reached, ready, d, scratch)
    if acts is not None:
        if is_border(s, o, output.segments):
            return BUSY
        if len(events.schedules) > 0:
            if distance_to_meet(s, o, output.segments, events, t) != NEVER:
                return BUSY
    if n_active > 0:
        return BUSY
    accept(table)
    return NONE


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
def find_doubtful(table, h):
    """Mark the events whose middle is to be looked at in a step of length h; their number.

    Their values at the ends of this step and the last come near zero, or change sign slowly,
    compared with `bend`; or they have phases.
    """
    n = 0
    for i in range(len(table)):
        e = table[i]
        e.within = KEEPS
        e.parts = WHOLE_STEP
        if e.inside == KEEPS or (e.inside == TELLS and e.lost == e.lost):  # known to be lost
            continue
        rise = e.g_new - e.g
        length = abs(h)
        change = abs(rise / h - e.slope) * length * length / (2.0 * (length + e.length))
        e.slope = rise / h
        e.length = length
        e.bend = max(change, e.bend) if change == change else e.bend
        if e.g * e.g_new > 0.0:
            clear = min(abs(e.g), abs(e.g_new)) > FAR * e.bend
        else:  # zeros over an interval have two ends
            clear = e.jump == 0 and e.g * e.g_new < 0.0 and is_steep(e)
        doubtful = not (clear and change == change) or e.fine < length
        if doubtful or e.phases != 0:
            e.within = e.inside
            e.parts = WHOLE_STEP if doubtful else ASKS
            n += 1
    return n


@njit(**INLINED)
def is_steep(e):
    """Whether an event function with other signs at the ends of a step changes sign once."""
    return abs(e.g_new - e.g) > STEEP * e.bend


@njit(**INTERNAL)
def find_turning(kernels, solve, table, t, reached, ready, d, scratch):
    """Keep the marks of events that may have changed their sign twice in a step up to t.

    Returns the number of the events that are marked and have one sign at both ends.
    The slopes at both ends tell the state in the middle, if the method stores them.
    """
    s = solve.state[0]
    work = solve.work
    y = scratch[0]
    n = 0
    t_middle = 0.5 * (s.t_old + t)
    if reached and table[0].middle == SLOPES and solve.block[MASS] == 0:
        eighth = 0.125 * (s.t - s.t_old)
        last = K + kernels.fsal_stage
        for i in range(len(y)):
            y[i] = 0.5 * (work[Y_OLD, i] + work[Y, i]) + eighth * (work[K, i] - work[last, i])
    else:
        if not ready:
            interpolate(kernels, solve, d)
        polynomial(d, (t_middle - s.t_old) / (s.t - s.t_old), y)
    for i in range(len(table)):
        e = table[i]
        if e.within == KEEPS:
            continue
        if e.phases != 0 and is_fast(solve, e, t, reached, d, y, scratch[1]):
            e.parts = IN_PARTS
        elif e.parts == ASKS:
            e.within = KEEPS
            continue
        elif e.fine < abs(t - s.t_old):
            pass
        elif not evaluate(e.block, t_middle, y, scratch[1]):
            words_at(e.block)[RAISED_WORD] = 0  # the state is an estimate: the interpolant decides
        elif not _turns(e, scratch[1, 0]):
            e.within = KEEPS
            continue
        if e.active == 0:
            n += 1
            e.active = 1 if e.within == COUNTS else 0
    return n


@njit(**INLINED)
def _turns(e, middle):
    """Whether an event may have changed its sign twice; note the second difference."""
    e.bend = max(second_difference(e.g, middle, e.g_new), FADES * e.bend)
    if e.jump == 0 and e.g * e.g_new < 0.0 and is_steep(e):
        return False
    return may_turn(e.g, middle, e.g_new, e.bend)


@njit(**INLINED)
def second_difference(before, middle, after):
    """The size of the second difference of three values."""
    return abs(before - 2.0 * middle + after)


@njit(**INLINED)
def may_turn(before, middle, after, bend):
    """Whether a function with three values in a step may change its sign twice in the step.

    The parabola through the values comes near zero, compared with `bend`, the largest second
    difference of late.  For numbers, and for lanes of vectors.
    """
    one_side = ((before > 0.0) & (middle > 0.0) & (after > 0.0)) | (
        (before < 0.0) & (middle < 0.0) & (after < 0.0)
    )
    begins, turns, ends, near = abs(before), abs(middle), abs(after), SHARE * bend
    own = begins - 2.0 * turns + ends
    rise = ends - begins
    inside = (abs(rise) < 2.0 * own) & (8.0 * own * (turns - near) <= rise * rise)
    return ~one_side | inside | (begins <= near) | (turns <= near) | (ends <= near)
