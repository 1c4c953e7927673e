"""The loop above the lanes of an ensemble: it gives them trajectories and takes the results.

One compiled loop serves every method and function: it calls the stepping kernel, the start and
`watch` through their addresses.  Output, events, breakpoints and projections are those of `watch`,
which is told that the step has been taken.  Without vectors there is one lane, and `watch` steps.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numba.np import arrayobj

from ..calls.user_function import RAISED, call, word
from ..calls.words import invoke
from ..jit_options import BARE, njit
from ..output.dense_output import polynomial
from ..output.extrema import MAX, MIN, note_state, note_step
from ..state.elementwise import slot
from ..state.record import EVENT, FINISHED, FULL, RUNNING, STEP_LIMIT, Y_OLD, K, Y
from ..state.record import RAISED as RAISED_STATUS
from .lanes import (
    ACCEPTED,
    ERROR,
    LIMIT,
    LIVE,
    N_FIELDS,
    NOTHING,
    REJECTED,
    STATUS,
    T_END,
    T_OLD,
    T_STOP,
    TRIES,
    H,
    T,
)

# In `addresses`; from BLOCKS on, the blocks of one trajectory's functions.
ADVANCE, START, WATCH, ENRICH, ALREADY, OPEN, BLOCKS = range(7)
NEXT, COUNT = range(2)  # in `queue`
IDLE = -1  # member of a lane that has none

# What a worker knows of all its trajectories.
WORKER = np.dtype(
    [
        ("vector", "i8"),  # whether the stepping kernel takes vectors
        ("order", "f8"),  # of the error estimate, and the last stage: for the start
        ("last", "i8"),
        ("project", "i8"),  # address of a block, or 0
        ("max_steps", "f8"),
        ("t_final", "f8"),
        ("each", "i8"),  # whether every step has to be looked at
        ("watches", "i8"),  # whether the stepping kernel looks out for events
        ("gathers", "i8"),  # whether it takes the states into the folds
        ("extrema", "i8"),  # whether they are wanted
        ("keep_found", "i8"),  # whether every event is, not the first of each kind alone
        ("n_found", "i8"),  # events in this piece
        ("n_done", "i8"),  # trajectories
    ]
)

# A value that is gathered along a trajectory, number <- function(t, [number, state]).
FOLD = np.dtype([("block", "i8"), ("start", "f8")])


@intrinsic
def _take(typingctx, queue, i):
    """queue[i], which goes up by one: no two threads get the same."""

    def codegen(context, builder, signature, args):
        data = arrayobj.make_array(queue)(context, builder, args[0]).data
        pointer = builder.gep(data, [args[1]])
        return builder.atomic_rmw("add", pointer, ir.IntType(64)(1), "monotonic")

    return types.int64(queue, types.intp), codegen


@intrinsic
def _write(typingctx, address, value):
    def codegen(context, builder, signature, args):
        pointer = builder.inttoptr(args[0], ir.IntType(64).as_pointer())
        builder.store(args[1], pointer)
        return context.get_dummy_value()

    return types.none(types.int64, types.int64), codegen


@njit(**BARE)
def set_parameters(places, values, member, lane):
    """Write the parameters of a member to where functions read them."""
    for j in range(len(places)):
        _write(places[j, 0] + lane * places[j, 2], values[member, places[j, 1]])


@njit(**BARE)
def already(state, work, block, n_steps):
    """In place of a stepping kernel, for a step that has been taken."""
    s = state[0]
    s.n_accepted += 1
    return FINISHED if s.direction * (s.t - s.t_end) >= 0.0 else RUNNING


@njit(**BARE)
def _next_stop(s, o, t_eval, each):
    """Time at which a lane has to be looked at."""
    if each:
        return -s.direction * np.inf
    if o.i_eval < len(t_eval) and s.direction * (t_eval[o.i_eval] - s.t_end) < 0.0:
        return t_eval[o.i_eval]
    return s.t_end  # of the leg


@njit(**BARE)
def _to_lane(w, s, lanes, many, work, lane, stop, events, folded):
    """Let a lane go on from the state and the rows of one trajectory."""
    width, row = lanes.shape[1], N_FIELDS
    if w.watches:
        for i in range(len(events)):
            lanes[row + i, lane] = events[i].g
        row += len(events)
    if w.gathers:
        for i in range(len(folded)):
            lanes[row + i, lane] = folded[i]
    lanes[T, lane], lanes[T_OLD, lane], lanes[H, lane] = s.t, s.t_old, s.h
    lanes[T_END, lane], lanes[T_STOP, lane], lanes[LIMIT, lane] = s.t_end, stop, w.max_steps
    lanes[ACCEPTED, lane], lanes[REJECTED, lane] = s.n_accepted, s.n_rejected
    lanes[TRIES, lane], lanes[LIVE, lane] = 0.0, 1.0
    for j in range(work.shape[1]):
        many[Y, j * width + lane] = work[Y, j]
        for row in range(K, work.shape[0]):
            many[row, j * width + lane] = work[row, j]


@njit(**BARE)
def _from_lane(w, s, lanes, many, work, lane, folded):
    """The state and the rows of the trajectory in a lane."""
    width = lanes.shape[1]
    if w.gathers:
        for i in range(len(folded)):
            folded[i] = lanes[len(lanes) - len(folded) + i, lane]
    s.t, s.t_old, s.h, s.error = (
        lanes[T, lane],
        lanes[T_OLD, lane],
        lanes[H, lane],
        lanes[ERROR, lane],
    )
    s.n_accepted, s.n_rejected = int(lanes[ACCEPTED, lane]), int(lanes[REJECTED, lane])
    for j in range(work.shape[1]):
        work[Y, j], work[Y_OLD, j] = many[Y, j * width + lane], many[Y_OLD, j * width + lane]
        for row in range(K, work.shape[0]):
            work[row, j] = many[row, j * width + lane]


@njit(**BARE)
def serve(
    addresses, queue, worker, common, blank, lanes, many, many_block, many_places,
    members, states, outs, events, work, block, places, values, y0,
    t_eval, legs, scratch, t_out, d, spans, e_index, e_t, e_y,
    y_eval, y_end, t_end, status_end, counts, best, t_first, folded, f_where, f_t, f_y, folds,
    extended, n_steps,
):  # fmt: skip
    """Take about `n_steps` steps in each lane.

    Parameters
    ----------
    addresses, queue, worker : arrays
        Kernels by address; the next member and the number of them, shared by all workers; WORKER.
    common, blank : arrays
        One STATE and one OUTPUT record: how every trajectory begins.
    lanes, many, many_block, many_places : arrays
        See `lanes.advance`; where in the block the parameters of a lane are, as `places`.
    members, states, outs, events : arrays, (width,) and (width, n_events)
        Which trajectory is in each lane, and its records.
    work, block, places : arrays
        One trajectory; (address, column of `values`, bytes from lane to lane) of its parameters.
    values, y0 : arrays, (M, n_values), (M or 1, n)
        Parameters, as words, and initial states.
    t_eval, legs, scratch, t_out, d, spans, e_index, e_t, e_y : arrays
        As for `watch`.
    y_eval, y_end, t_end, status_end, counts : arrays, (M, n_times, n), (M, n), (M,), (M,), (M, 4)
        Results: counts are of steps accepted, rejected, evaluations outside them, times reached.
    best, t_first, folded : arrays, (M, 4, n) or (0, 4, n), (M, n_events), (M, n_folds)
        See `extrema`; time of the first event of each kind, NaN until it happens; FOLD's numbers.
    f_where, f_t, f_y : arrays
        Occurrences of events: (member, event), time and state.
    folds, extended : arrays, (n_folds,), (2, n + 1)
        FOLD records, and scratch.

    Returns
    -------
    int
        RUNNING, FULL (`f_t` has no room for the events of a step), or FINISHED.
    """
    w = worker[0]
    width, each = len(members), w.each != 0
    while n_steps > 0:
        if w.n_found + width * len(e_t) > len(f_t):
            return FULL
        n_live = 0
        for lane in range(width):
            while members[lane] == IDLE and queue[NEXT] < queue[COUNT]:
                member = _take(queue, NEXT)
                if member >= queue[COUNT]:
                    break
                members[lane] = member
                for i in range(len(folds)):
                    folded[member, i] = folds[i].start
                status = _begin(
                    addresses, w, common, blank, lane, member, states, outs, events, work, block,
                    places, values, y0, scratch, best,
                )  # fmt: skip
                if status != RUNNING:
                    _end(
                        addresses, w, lane, status, members, states, outs, work, y_end, t_end,
                        status_end, counts, best,
                    )  # fmt: skip
                elif w.vector:
                    set_parameters(many_places, values, member, lane)
                    s = states[lane]
                    stop = _next_stop(s, outs[lane], t_eval, each)
                    _to_lane(w, s, lanes, many, work, lane, stop, events[lane], folded[member])
                    if w.extrema:
                        _raise_bar(many, best[member], lane, width)
            n_live += members[lane] != IDLE
        if n_live == 0:
            return FINISHED
        budget = n_steps
        if w.vector:
            n_steps -= invoke(addresses[ADVANCE], (common, lanes, many, many_block, n_steps))
        for lane in range(width):
            if w.vector and lanes[STATUS, lane] == NOTHING:
                continue
            s, o, member = states[lane], outs[lane], members[lane]
            kernel, status = addresses[ADVANCE], RUNNING
            if w.vector:
                _from_lane(w, s, lanes, many, work, lane, folded[member])
                set_parameters(places, values, member, 0)
                kernel, status, budget = addresses[ALREADY], int(lanes[STATUS, lane]), 1
                if status <= FINISHED:
                    s.n_accepted -= 1
            if w.extrema or len(folds) > 0:
                budget = 1  # and `watch` leaves the interpolant in d for the extrema
            before, left = s.n_accepted, w.max_steps - s.n_accepted
            if status <= FINISHED:
                status = invoke(
                    addresses[WATCH],
                    (
                        addresses[ENRICH], w.last, kernel, states[lane : lane + 1], work, block,
                        outs[lane : lane + 1], t_out, y_eval[member], d, spans, t_eval, legs,
                        w.project, events[lane], e_index, e_t, e_y, scratch,
                        budget if budget < left else int(left),
                    ),
                )  # fmt: skip
            if not w.vector:
                n_steps -= s.n_accepted - before
            _note_first(t_first[member], o.n_events, e_index, e_t)
            for i in range(o.n_events if w.keep_found else 0):
                f_where[w.n_found, 0], f_where[w.n_found, 1] = member, e_index[i]
                f_t[w.n_found] = e_t[i]
                for j in range(work.shape[1]):
                    f_y[w.n_found, j] = e_y[i, j]
                w.n_found += 1
            n_events, o.n_events = o.n_events, 0
            if status == FULL:  # of events; they have been taken out
                status = RUNNING
            if status == RUNNING and s.n_accepted >= w.max_steps:
                status = STEP_LIMIT
            x_end = 1.0
            if status == EVENT:
                _stop_at_event(s, work, n_events, e_t, e_y)
                x_end = (s.t - s.t_old) / (spans[0, 1] if w.extrema else 1.0)
            elif status == FINISHED:
                if s.t != s.t_end:
                    x_end = (w.t_final - s.t_old) / (s.t - s.t_old)
                    polynomial(d[0], x_end, work[Y])
                s.t = w.t_final
            if w.extrema and s.n_accepted > before:
                note_step(best[member], d[0], spans[0, 0], spans[0, 1], x_end)
                note_state(best[member], s.t, work)
                o.n_dense = 0
            if s.n_accepted > before and not _gather(folds, folded[member], s.t, work, extended):
                status = RAISED_STATUS
            if status != RUNNING:
                _end(
                    addresses, w, lane, status, members, states, outs, work, y_end, t_end,
                    status_end, counts, best,
                )  # fmt: skip
                if w.vector:
                    lanes[LIVE, lane] = 0.0
            elif w.vector:
                stop = _next_stop(s, o, t_eval, each)
                _to_lane(w, s, lanes, many, work, lane, stop, events[lane], folded[member])
                if w.extrema:
                    _raise_bar(many, best[member], lane, width)
    return RUNNING


@njit(**BARE)
def _begin(
    addresses, w, common, blank, lane, member, states, outs, events, work, block, places, values,
    y0, scratch, best,
):  # fmt: skip
    """Prepare the state and the rows of one trajectory; RUNNING, or why it cannot begin."""
    states[lane], outs[lane] = common[0], blank[0]
    set_parameters(places, values, member, 0)
    start = y0[member if len(y0) > 1 else 0]
    for j in range(work.shape[1]):
        work[Y, j] = work[Y_OLD, j] = start[j]
        for row in range(K, work.shape[0]):
            work[row, j] = 0.0
    if w.extrema:
        best[member, :, :] = np.nan
        note_state(best[member], states[lane].t, work)
    status = invoke(addresses[START], (states[lane : lane + 1], work, block, w.order, w.last))
    if status == RUNNING and events.shape[1] > 0:
        for i in range(events.shape[1]):
            events[lane, i].count = 0
        t = states[lane].t
        status = invoke(addresses[OPEN], (events[lane], t, slot(None, work, Y), scratch[1]))
    return status


@njit(**BARE)
def _gather(folds, folded, t, work, extended):
    """Take the state into the folds; False if one raised."""
    for i in range(len(folds)):
        extended[0, 0] = folded[i]
        for j in range(work.shape[1]):
            extended[0, 1 + j] = work[Y, j]
        call(folds[i].block, t, extended[0], extended[1])
        if word(folds[i].block, RAISED) != 0:
            return False
        folded[i] = extended[1, 0]
    return True


@njit(**BARE)
def _raise_bar(many, best, lane, width):
    """Tell the stepping kernel what a component has to exceed, or to fall below."""
    for j in range(best.shape[1]):
        many[len(many) - 2, j * width + lane] = best[MAX, j]
        many[len(many) - 1, j * width + lane] = best[MIN, j]


@njit(**BARE)
def _note_first(t_first, n_events, e_index, e_t):
    for i in range(n_events):
        if np.isnan(t_first[e_index[i]]):
            t_first[e_index[i]] = e_t[i]


@njit(**BARE)
def _stop_at_event(s, work, n_events, e_t, e_y):
    """The state at the event that ended the run: the last one of the step."""
    last = 0
    for i in range(n_events):
        if s.direction * (e_t[i] - e_t[last]) >= 0.0:
            last = i
    s.t = e_t[last]
    for j in range(work.shape[1]):
        work[Y, j] = e_y[last, j]


@njit(**BARE)
def _end(
    addresses, w, lane, status, members, states, outs, work, y_end, t_end, status_end, counts, best
):
    """Note the result of a trajectory; its lane is free."""
    s, member = states[lane], members[lane]
    t_end[member], status_end[member] = s.t, status
    for j in range(work.shape[1]):
        y_end[member, j] = work[Y, j]
    if w.extrema:
        note_state(best[member], s.t, work)
    counts[member, 0], counts[member, 1] = s.n_accepted, s.n_rejected
    counts[member, 2], counts[member, 3] = s.n_extra, outs[lane].i_eval
    if status == RAISED_STATUS:
        for address in addresses[BLOCKS:]:
            _write(address + 8 * RAISED, 0)
    members[lane] = IDLE
    w.n_done += 1
