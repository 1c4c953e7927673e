"""The loop above the steps: output, dense output, events.

It calls a stepping kernel through its address, one step at a time where every step must be
looked at and otherwise up to the next output time, and the interpolant through another, so that
one compiled loop serves every method in both tiers.
"""

import numpy as np

from ..calls.user_function import RAISED, by_pointer, call, word
from ..calls.words import invoke
from ..jit_options import BARE, njit
from ..state.elementwise import slot
from ..state.record import EVENT, FINISHED, FULL, RUNNING, STEP_TOO_SMALL, K, Y
from ..state.record import RAISED as RAISED_STATUS
from .dense_output import hermite, polynomial
from .events import evaluate_all, find_active, leave_zero, locate, record

# What is wanted and how much of it there is.
OUTPUT = np.dtype(
    [
        ("every_step", "i8"),  # store each step; else the times of t_eval
        ("dense", "i8"),  # store each step's polynomial
        ("n_out", "i8"),  # points in this piece of the output
        ("n_total", "i8"),  # points in all pieces
        ("n_dense", "i8"),
        ("n_events", "i8"),  # occurrences in this piece
        ("i_eval", "i8"),  # next entry of t_eval
        ("i_leg", "i8"),  # present row of legs
        ("t_last", "f8"),  # last time stored
    ]
)


@njit(**BARE)
def _copy(row, out):
    # A loop: the assignment of a row to a row allocates, in case they overlap.
    for i in range(len(row)):
        out[i] = row[i]


@njit(**BARE)
def _interpolate(enrich, last, s, work, block, d):
    """The polynomial of the last step, in the rows of d."""
    h = s.t - s.t_old
    hermite(h, last, work, d)
    s.n_extra += invoke(enrich, (s.t_old, h, work, block, d))


@njit(**BARE)
def _derive(s, work, block, last):
    """The derivative at the present state, for the step that comes next; RUNNING or RAISED."""
    by_pointer(s.t, slot(None, work, Y), block, slot(None, work, K + last))
    s.n_extra += 1
    return RAISED_STATUS if block[RAISED] != 0 else RUNNING


@njit(**BARE)
def _drift(work, last, gap):
    """Move the state by its slope, over a few roundings of the time."""
    for i in range(work.shape[1]):
        work[Y, i] += gap * work[K + last, i]


@njit(**BARE)
def _project_row(project, t, y, scratch):
    """Take a state of the output to its constraints; False if the function raised."""
    if project == 0:
        return True
    _copy(y, scratch)
    call(project, t, scratch, y)
    return word(project, RAISED) == 0


@njit(**BARE)
def _project(project, s, work, block, last, scratch):
    """Take the new state to its constraints; False if a function raised."""
    call(project, s.t, slot(None, work, Y), scratch)
    if word(project, RAISED) != 0:
        return False
    _copy(scratch, work[Y])
    return _derive(s, work, block, last) == RUNNING


@njit(**BARE)
def watch(
    enrich,
    last,
    advance,
    state,
    work,
    block,
    out,
    t_out,
    y_out,
    d_out,
    span_out,
    t_eval,
    legs,
    project,
    events,
    e_index,
    e_t,
    e_y,
    scratch,
    n_steps,
):
    """Take at most `n_steps` steps by the kernel at address `advance`, and store what is wanted.

    Parameters
    ----------
    enrich : int
        Address of the kernel ``enrich(t, h, work, block, d)`` that adds the rows of the method's
        interpolant to the Hermite cubic, and returns how often it evaluated the derivative.
    last : int
        See `method.Method`.
    state, work, block : arrays
        The solve; see `state.py` and `calls.py`.
    out, t_out, y_out : arrays
        OUTPUT record, times (room,), values (room, n).
    d_out, span_out : arrays
        Polynomials (room, rows, n), and their t_old and h (room, 2); one place is always free.
    t_eval : array
    legs : array, (n_legs, 3)
        Where the parts of a span with breakpoints begin and end, and the time that their end is
        called in the output; without rows, there are none.
    project : int
        Address of the block of the function that takes a new state to its constraints, or 0.
    events, e_index, e_t, e_y : arrays
        EVENTS records; which, when and where, with room for every event of one step.
    scratch : array, (2, n)

    Returns
    -------
    int
        RUNNING, FINISHED, FULL, EVENT, or a failure.
    """
    s, o = state[0], out[0]
    direction, t_end = s.direction, legs[len(legs) - 1, 1] if len(legs) > 0 else s.t_end
    last_leg = len(legs) - 1
    each = o.every_step != 0 or o.dense != 0 or len(events) > 0 or project != 0
    while n_steps > 0:
        if (
            (o.every_step != 0 and o.n_out == len(t_out))
            or o.n_dense == len(d_out)
            or o.n_events + len(events) > len(e_t)
        ):
            return FULL
        s.t_stop = t_eval[o.i_eval] if not each and o.i_eval < len(t_eval) else t_end
        before = s.n_accepted
        status = invoke(advance, (state, work, block, 1 if each else n_steps))
        n_steps -= s.n_accepted - before
        if status >= STEP_TOO_SMALL:
            return status
        if s.n_accepted == before:
            return status
        if project != 0 and not _project(project, s, work, block, last, scratch[0]):
            return RAISED_STATUS
        t_old, h = s.t_old, s.t - s.t_old
        over = status == FINISHED and len(legs) > 0
        t = s.t
        if over:
            t = legs[o.i_leg, 2]
        elif direction * (s.t - t_end) > 0.0:
            t = t_end
        t_from = t_old
        if o.i_leg > 0 and t_old == legs[o.i_leg, 0]:
            t_from = legs[o.i_leg - 1, 2]  # events between two legs belong to the second
        reached = over or t == s.t  # the state at t is in row Y
        due = o.i_eval < len(t_eval) and direction * (t_eval[o.i_eval] - t) <= 0.0
        d = d_out[o.n_dense]
        ready = o.dense != 0 or due or not reached
        if ready:
            _interpolate(enrich, last, s, work, block, d)
        if o.dense != 0:
            span_out[o.n_dense, 0], span_out[o.n_dense, 1] = t_old, h
            o.n_dense += 1
        if len(events) > 0:
            if reached:
                _copy(work[Y], scratch[0])
            else:
                polynomial(d, (t - t_old) / h, scratch[0])
            if not evaluate_all(events, t, scratch[0], scratch[1]):
                return RAISED_STATUS
            if find_active(events) > 0:
                if not ready:
                    _interpolate(enrich, last, s, work, block, d)
                final = locate(events, d, t_from, t, t_old, h, direction, scratch)
                first_found = o.n_events
                o.n_events = record(
                    events, final, d, t_old, h, direction, e_index, e_t, e_y, o.n_events
                )
                for i in range(first_found, o.n_events):
                    if not _project_row(project, e_t[i], e_y[i], scratch[1]):
                        return RAISED_STATUS
                if final >= 0:
                    status, t, reached = EVENT, events[final].root, False
        if o.every_step != 0:
            if o.dense != 0 and o.n_total > 1 and o.t_last == t:
                o.n_dense -= 1
            else:
                t_out[o.n_out] = o.t_last = t
                if reached:
                    _copy(work[Y], y_out[o.n_out])
                else:
                    polynomial(d, (t - t_old) / h, y_out[o.n_out])
                    if not _project_row(project, t, y_out[o.n_out], scratch[1]):
                        return RAISED_STATUS
                o.n_out += 1
                o.n_total += 1
        while o.i_eval < len(t_eval) and direction * (t_eval[o.i_eval] - t) <= 0.0:
            t_out[o.i_eval] = t_eval[o.i_eval]
            polynomial(d, (t_eval[o.i_eval] - t_old) / h, y_out[o.i_eval])
            if not _project_row(project, t_eval[o.i_eval], y_out[o.i_eval], scratch[1]):
                return RAISED_STATUS
            o.i_eval += 1
        if over and status == FINISHED and o.i_leg < last_leg:
            o.i_leg += 1
            gap = 0.5 * (legs[o.i_leg, 0] - s.t)  # crossed with the slopes of both sides
            _drift(work, last, gap)
            s.t, s.t_end = legs[o.i_leg, 0], legs[o.i_leg, 1]
            status = _derive(s, work, block, last)
            _drift(work, last, gap)
            if not leave_zero(events, s.t, work[Y], scratch[0]):
                return RAISED_STATUS
        if status != RUNNING:
            return status
    return RUNNING
