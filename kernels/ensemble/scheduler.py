"""The loop above the lanes of an ensemble: assigns trajectories to lanes and stores results.

One compiled loop serves every method and function, because the loop calls the stepping kernel, the
start kernel and `watch` by their addresses.  `watch` handles output, events, breakpoints and
projections, after the vector kernel has taken the step.  Without vectors there is one lane, and
`watch` also takes the steps.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ..calls.block import RAISED_WORD
from ..calls.calling_convention import invoke
from ..calls.user_function import words_at
from ..jit.options import INTERNAL, njit
from ..output.dense_output import polynomial
from ..output.extrema import note_state, note_step
from ..state.elementwise import data_of
from ..state.lane_fields import LEFT, LIVE, NOTHING, STATUS
from ..state.record import (
    BAD_STATE,
    EVENT,
    FINISHED,
    FULL,
    RAISED,
    RUNNING,
    STEP_LIMIT,
    STEP_TOO_SMALL,
    Y_OLD,
    K,
    Y,
)
from ..state.rows import copy_row, slot
from .arguments import (
    ADVANCE,
    ALREADY,
    BLOCKS,
    COUNT,
    GIVEN_UP,
    IDLE,
    NEXT,
    OPEN,
    SCALAR,
    START,
)
from .collect import accumulate, keep_events, stop_at_event
from .lane_transfer import extrema_to_lane, from_lane, next_stop, set_parameters, to_lane
from .watched import act_at_start, segments_of, watch_lane


@intrinsic
def _take(typingctx, queue, i):
    """Increment queue[i] atomically and return its former value, different for each thread.

    LLVM, because Numba has no atomic operation on the processor.
    """

    def codegen(context, builder, signature, args):
        data = data_of(context, builder, queue, args[0])
        pointer = builder.gep(data, [args[1]])
        return builder.atomic_rmw("add", pointer, ir.IntType(64)(1), "monotonic")

    return types.int64(queue, types.intp), codegen


@njit(**INTERNAL)
def serve(task, lanes, single, room, results, found, folds, n_steps):
    """Take about `n_steps` steps in each lane.

    Parameters
    ----------
    task, lanes, single, room, results, found : named tuples
    folds : array, (n_folds,)
        FOLD records.

    Returns
    -------
    int
        RUNNING, FULL (`found` has no room for the events of a step), or FINISHED.
    """
    w = task.worker[0]
    width = len(lanes.members)
    for lane in range(width):
        if lanes.members[lane] <= GIVEN_UP:
            _give_up(task, lanes, single, results, lane)
    while n_steps > 0:
        if w.n_found + width * len(room.e_t) > len(found.t):
            return FULL
        n_live = 0
        for lane in range(width):
            _fill(task, lanes, single, room, results, found, folds, lane)
            n_live += lanes.members[lane] != IDLE
        if n_live == 0:
            return FINISHED if task.queue[NEXT] >= task.queue[COUNT] else FULL
        budget = n_steps
        if w.vector:
            given = task.state, lanes.fields, lanes.work, lanes.block, n_steps
            n_steps -= invoke(task.addresses[ADVANCE], given)
        for lane in range(width):
            if w.vector and lanes.fields[STATUS, lane] == NOTHING:
                continue
            taken = _attend(task, lanes, single, room, results, found, folds, lane, budget)
            if not w.vector:
                n_steps -= taken
    return RUNNING


@njit(**INTERNAL)
def _fill(task, lanes, single, room, results, found, folds, lane):
    """Give an idle lane the next trajectory, if a trajectory is left."""
    w = task.worker[0]
    queue = task.queue
    members = lanes.members
    while members[lane] == IDLE and queue[NEXT] < queue[COUNT]:
        if w.n_found + len(room.e_t) > len(found.t):
            break
        member = _take(queue, NEXT)
        if member >= queue[COUNT]:
            break
        members[lane] = member
        for i in range(len(folds)):
            results.folded[member, i] = folds[i].start
        status = _begin(task, lanes, single, room, results.best, lane)
        if status == RUNNING and w.vector and len(lanes.schedules[lane]) > 0:
            status = act_at_start(task, lanes, single, room, results, found, lane)
        if status != RUNNING:
            _end(task, lanes, single, results, lane, status)
        elif w.vector:
            set_parameters(lanes.places, task.values, member, lane)
            _resume(task, lanes, single, room, results, lane)


@njit(**INTERNAL)
def _resume(task, lanes, single, room, results, lane):
    """Set the next stop of a lane, which continues with its trajectory."""
    w = task.worker[0]
    member = lanes.members[lane]
    stop = next_stop(lanes.states[lane], lanes.records[lane], room.t_eval, w.each != 0)
    to_lane(w, lanes, single, results.folded[member], lane, stop)
    if w.extrema:
        extrema_to_lane(lanes.work, results.best[member], lane, len(lanes.members))


@njit(**INTERNAL)
def _attend(task, lanes, single, room, results, found, folds, lane, budget):
    """Sample the steps of one trajectory, and end or resume the trajectory.

    Returns the number of steps taken.
    """
    w = task.worker[0]
    s = lanes.states[lane]
    o = lanes.records[lane]
    member = lanes.members[lane]
    work = single.work
    before = s.n_accepted
    kernel = task.addresses[ADVANCE]
    status = RUNNING
    if w.vector:
        from_lane(w, lanes, single, results.folded[member], lane)
        set_parameters(single.places, task.values, member, 0)
        kernel = task.addresses[ALREADY]
        status = int(lanes.fields[STATUS, lane])
        budget = 1
        if status == LEFT:
            kernel = task.addresses[SCALAR]
            status = RUNNING
            s.order = 0  # the rows may hold the matrix of another trajectory
        elif status <= FINISHED:
            s.n_accepted -= 1
    if w.extrema or len(folds) > 0:
        budget = 1  # after each step, `watch` leaves the interpolant in d for the extrema
    before = s.n_accepted
    left = w.max_steps - s.n_accepted
    if status <= FINISHED:
        steps = budget if budget < left else int(left)
        status = watch_lane(task, lanes, single, room, results.y_eval[member], kernel, lane, steps)
    taken = s.n_accepted - before
    n_events = keep_events(w, o, room, found, results.t_first[member], member)
    if status == FULL:  # the array of events was full, and is empty now
        status = RUNNING
    if status == RUNNING and s.n_accepted >= w.max_steps:
        status = STEP_LIMIT
    x_end = 1.0
    if status == EVENT:
        stop_at_event(s, work, n_events, room)
        x_end = (s.t - s.t_old) / (room.spans[0, 1] if w.extrema else 1.0)
    elif status == FINISHED:
        if s.t != s.t_end:
            x_end = (w.t_final - s.t_old) / (s.t - s.t_old)
            polynomial(room.d[0], x_end, work[Y])
        s.t = w.t_final
    if w.extrema and taken > 0:
        note_step(results.best[member], room.d[0], room.spans[0, 0], room.spans[0, 1], x_end)
        note_state(results.best[member], s.t, work)
        o.n_dense = 0
    if taken > 0 and not accumulate(folds, results.folded[member], s.t, work, single.extended):
        status = RAISED
    if status != RUNNING:
        _end(task, lanes, single, results, lane, status)
        if w.vector:
            lanes.fields[LIVE, lane] = 0.0
    elif w.vector:
        _resume(task, lanes, single, room, results, lane)
    return taken


@njit(**INTERNAL)
def _begin(task, lanes, single, room, best, lane):
    """Prepare the state and the rows of one trajectory; return RUNNING or the failure."""
    w = task.worker[0]
    work = single.work
    states = lanes.states
    events = lanes.events[lane]
    member = lanes.members[lane]
    states[lane], lanes.records[lane] = task.state[0], task.record[0]
    segments = segments_of(task, room, member)
    s = states[lane]
    if len(segments) > 0:
        s.t = s.t_old = segments[0, 0]
        s.t_end = s.t_stop = segments[0, 1]
    for i in range(len(lanes.schedules[lane])):
        own = task.schedules[member if len(task.schedules) > 1 else 0]
        lanes.schedules[lane, i] = own[i]
    set_parameters(single.places, task.values, member, 0)
    start = task.y0[member if len(task.y0) > 1 else 0]
    finite = True
    for j in range(work.shape[1]):
        work[Y, j] = work[Y_OLD, j] = start[j]
        for row in range(K, work.shape[0]):
            work[row, j] = 0.0
        finite = finite and np.isfinite(start[j])
    if not finite:
        return BAD_STATE
    if w.extrema:
        best[member, :, :] = np.nan
        note_state(best[member], states[lane].t, work)
    given = states[lane : lane + 1], work, single.block, w.order, w.fsal_stage
    status = invoke(task.addresses[START], given)
    if status == RUNNING and len(events) > 0:
        given = events, states[lane].t, slot(None, work, Y), single.scratch[1]
        status = invoke(task.addresses[OPEN], given)
    return status


@njit(**INTERNAL)
def _give_up(task, lanes, single, results, lane):
    """End a trajectory whose end is out of reach."""
    lanes.members[lane] = member = GIVEN_UP - lanes.members[lane]
    if task.worker[0].vector:
        from_lane(task.worker[0], lanes, single, results.folded[member], lane)
        lanes.fields[LIVE, lane] = 0.0
    _end(task, lanes, single, results, lane, STEP_TOO_SMALL)


@njit(**INTERNAL)
def _end(task, lanes, single, results, lane, status):
    """Store the result of a trajectory, and free its lane."""
    s = lanes.states[lane]
    member = lanes.members[lane]
    work = single.work
    results.t_end[member] = s.t
    results.h_end[member] = s.h
    results.status[member] = status
    copy_row(work[Y], results.y_end[member])
    if task.worker[0].extrema:
        note_state(results.best[member], s.t, work)
    counts = results.counts[member]
    counts.n_accepted = s.n_accepted
    counts.n_rejected = s.n_rejected
    counts.n_extra = s.n_extra
    counts.n_times = lanes.records[lane].i_eval
    counts.n_standing = s.n_standing
    if status == RAISED:
        for address in task.addresses[BLOCKS:]:
            words_at(address)[RAISED_WORD] = 0
    lanes.members[lane] = IDLE
    task.worker[0].n_done += 1
