"""Parts of a step in each of which an event function turns once or twice at most.

An event function may be much faster than the solution: sin(50 t) in steps of a second, a narrow
peak of an exponential function.  Its trace tells its phases, the numbers with which it turns.  The
field `phases` of an event is the address of their function, of the form of the event's function
and with its block, or 0; it writes first `n_periodic` operands of functions that turn once in
every pi or so, then `n_transitions` operands of functions that turn near zero and flatten far
away, then `n_divisors` denominators, with whose relative changes quotients turn.  A step in which a
phase changes by more than LIMIT is divided into parts in which all change by less than one.
"""

import numpy as np

from ...calls.user_function import call_with
from ...jit.options import INTERNAL, njit
from ...state.record import Y_OLD, Y
from ...state.rows import copy_row, rows_on_stack
from ..arguments import MOST_PHASES
from ..brent import resolution
from ..dense_output import polynomial

QUARTER = np.pi / 2.0  # change of the operand of a sine that counts as one
LIMIT = 1.0  # change of a phase in a whole step beyond which the step is divided
SMALL = 0.1  # the same behind an action, where the slope of the function is read
HALVINGS = 40  # of the rest of a step, at most, for one part
MOST_PARTS = 4096  # of a step, to which one event is looked at: 16 an occurrence
START, MIDDLE, END = range(3)  # rows of phases, at three times


@njit(**INTERNAL)
def is_fast(solve, e, t, reached, d, y_middle, scratch):
    """Whether an event function is to be looked at in parts of a step up to t.

    `y_middle` is the state in the middle; d is filled unless the step is `reached`, its end row Y.
    """
    s = solve.state[0]
    rows = rows_on_stack(3, MOST_PHASES)
    call_with(e.phases, e.block, s.t_old, solve.work[Y_OLD], rows[START])
    call_with(e.phases, e.block, 0.5 * (s.t_old + t), y_middle, rows[MIDDLE])
    if reached:
        call_with(e.phases, e.block, t, solve.work[Y], rows[END])
    else:
        polynomial(d, (t - s.t_old) / (s.t - s.t_old), scratch)
        call_with(e.phases, e.block, t, scratch, rows[END])
    return _change(e, rows) > LIMIT


@njit(**INTERNAL)
def slow_step(e, t, step, least, y, rate, moved):
    """The part of a step from the state y, at least `least`, in which phases change by SMALL."""
    if e.phases == 0:
        return step
    rows = rows_on_stack(3, MOST_PHASES)
    call_with(e.phases, e.block, t, y, rows[START])
    while abs(step) > 2.0 * least:
        for share, row in ((0.5, MIDDLE), (1.0, END)):
            for i in range(len(y)):
                moved[i] = y[i] + share * step * rate[i]
            call_with(e.phases, e.block, t + share * step, moved, rows[row])
        if not _change(e, rows) > SMALL:
            break
        step *= 0.5
    return step


@njit(**INTERNAL)
def begin_parts(e, d, t_old, h, rows, y):
    """Read the phases at the start of a step, before its first part."""
    _read(e, d, t_old, h, t_old, y, rows[START])


@njit(**INTERNAL)
def next_part(e, d, t_old, h, a, length, t, rows, y):
    """The end of the part from a on, at most t, for which the phases at a are known.

    `length` is the longest one, as the step is directed.  Where a phase jumps, or has a pole, parts
    are no shorter than what tells two roots apart.
    """
    shortest = 2.0 * resolution(a, e.unit)
    length = min(max(abs(length), shortest), abs(t - a))
    for _ in range(HALVINGS):
        b = t if length >= abs(t - a) else a + np.copysign(length, h)
        _read(e, d, t_old, h, 0.5 * (a + b), y, rows[MIDDLE])
        _read(e, d, t_old, h, b, y, rows[END])
        if not _change(e, rows) > 1.0 or 0.5 * length < shortest:
            break
        length *= 0.5
    copy_row(rows[END], rows[START])
    return b


@njit(**INTERNAL)
def _read(e, d, t_old, h, t, y, out):
    polynomial(d, (t - t_old) / h, y)
    call_with(e.phases, e.block, t, y, out)


@njit(**INTERNAL)
def _change(e, rows):
    """The largest change of a phase between three times; NaN counts as none.

    Phases that count by their size may have come nearer to zero than the three values, by the
    distance between these.
    """
    most = 0.0
    n_absolute = e.n_periodic + e.n_transitions
    for j in range(n_absolute + e.n_divisors):
        before = rows[START, j]
        middle = rows[MIDDLE, j]
        after = rows[END, j]
        low = min(before, middle, after)
        high = max(before, middle, after)
        change = high - low
        if j < e.n_periodic:
            change /= QUARTER
        elif change > 0.0:
            near = max(max(low, -high) - change, 0.0)
            change /= near + 1.0 if j < n_absolute else near
        most = max(most, change) if change == change else most
    return most
