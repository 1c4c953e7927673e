"""Copies trajectories into lanes and out of lanes."""

import numpy as np

from ..calls.user_function import words_at
from ..jit.options import INTERNAL, njit
from ..output.extrema import MAX, MIN
from ..output.series_roots.look import FADES
from ..state.lane_fields import (
    ACCEPTED,
    ERROR,
    EVALUATIONS,
    LIMIT,
    LIVE,
    N_FIELDS,
    REJECTED,
    T_END,
    T_OLD,
    T_STOP,
    TRIES,
    H,
    T,
)
from ..state.record import Y_OLD, K, Y

N_EXTREMA = 2  # rows behind the rows of the method: the largest and the smallest values so far


@njit(**INTERNAL)
def set_parameters(places, values, member, lane):
    """Write the parameters of a member to the words from which functions read them."""
    for j in range(len(places)):
        words_at(places[j, 0] + lane * places[j, 2])[0] = values[member, places[j, 1]]


@njit(**INTERNAL)
def next_stop(s, o, t_eval, each):
    """Time at which a lane has to return to the scheduler."""
    if each:
        return -s.direction * np.inf
    if o.i_eval < len(t_eval) and s.direction * (t_eval[o.i_eval] - s.t_end) < 0.0:
        return t_eval[o.i_eval]
    return s.t_end  # end of the segment


@njit(**INTERNAL)
def to_lane(w, lanes, single, folded, lane, stop):
    """Copy the state and the rows of one trajectory into a lane."""
    fields = lanes.fields
    s = lanes.states[lane]
    events = lanes.events[lane]
    width = fields.shape[1]
    row = N_FIELDS
    work = single.work
    if w.watches:
        for i in range(len(events)):
            fields[row + 2 * i, lane] = events[i].g
            fields[row + 2 * i + 1, lane] = events[i].bend
        row += 2 * len(events)
    if w.accumulates:
        for i in range(len(folded)):
            fields[row + i, lane] = folded[i]
    fields[T, lane], fields[T_OLD, lane], fields[H, lane] = s.t, s.t_old, s.h
    fields[T_END, lane], fields[T_STOP, lane], fields[LIMIT, lane] = s.t_end, stop, w.max_steps
    fields[ACCEPTED, lane], fields[REJECTED, lane] = s.n_accepted, s.n_rejected
    fields[TRIES, lane] = 0.0
    fields[LIVE, lane] = 1.0
    fields[EVALUATIONS, lane] = s.n_extra
    for j in range(work.shape[1]):
        lanes.work[Y, j * width + lane] = work[Y, j]
        for row in range(K, len(lanes.work) - N_EXTREMA):
            lanes.work[row, j * width + lane] = work[row, j]


@njit(**INTERNAL)
def from_lane(w, lanes, single, folded, lane):
    """Copy the state and the rows of the trajectory in a lane out of the lane."""
    fields = lanes.fields
    s = lanes.states[lane]
    work = single.work
    width = fields.shape[1]
    if w.watches:
        events = lanes.events[lane]
        for i in range(len(events)):  # `look` lets the value of the last step fade once more
            if events[i].inside != 0:
                events[i].bend = fields[N_FIELDS + 2 * i + 1, lane] / FADES
                events[i].slope = np.nan
    if w.accumulates:
        for i in range(len(folded)):
            folded[i] = fields[len(fields) - len(folded) + i, lane]
    s.t = fields[T, lane]
    s.t_old = fields[T_OLD, lane]
    s.h = fields[H, lane]
    s.error = fields[ERROR, lane]
    s.n_accepted, s.n_rejected = int(fields[ACCEPTED, lane]), int(fields[REJECTED, lane])
    s.n_extra = int(fields[EVALUATIONS, lane])
    for j in range(work.shape[1]):
        work[Y, j], work[Y_OLD, j] = (
            lanes.work[Y, j * width + lane],
            lanes.work[Y_OLD, j * width + lane],
        )
        for row in range(K, len(lanes.work) - N_EXTREMA):
            work[row, j] = lanes.work[row, j * width + lane]


@njit(**INTERNAL)
def extrema_to_lane(work, best, lane, width):
    """Tell the stepping kernel the maximum and the minimum of each component so far."""
    for j in range(best.shape[1]):
        work[len(work) - 2, j * width + lane] = best[MAX, j]
        work[len(work) - 1, j * width + lane] = best[MIN, j]
