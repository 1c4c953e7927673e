"""Collects the results of a trajectory from its steps: events, folds, the state at the end."""

import numpy as np

from ..calls.user_function import evaluate
from ..jit.options import INTERNAL, njit
from ..state.record import Y
from ..state.rows import copy_row


@njit(**INTERNAL)
def accumulate(folds, folded, t, work, extended):
    """Update the folds with the state; False if the function of a fold raised."""
    for i in range(len(folds)):
        extended[0, 0] = folded[i]
        copy_row(work[Y], extended[0, 1:])
        if not evaluate(folds[i].block, t, extended[0], extended[1]):
            return False
        folded[i] = extended[1, 0]
    return True


@njit(**INTERNAL)
def keep_events(w, o, room, found, t_first, member):
    """Move the events of a trajectory from `room` to the results; return their number."""
    n_events = o.n_events
    o.n_events = 0
    for i in range(n_events):
        if np.isnan(t_first[room.e_index[i]]):
            t_first[room.e_index[i]] = room.e_t[i]
        if w.keep_found:
            found.where[w.n_found, 0], found.where[w.n_found, 1] = member, room.e_index[i]
            found.t[w.n_found] = room.e_t[i]
            for j in range(found.y.shape[1]):
                found.y[w.n_found, j] = room.e_y[i, j]
            w.n_found += 1
    return n_events


@njit(**INTERNAL)
def stop_at_event(s, work, n_events, room):
    """The state at the event that ended the run: the last event of the step."""
    last = 0
    for i in range(n_events):
        if s.direction * (room.e_t[i] - room.e_t[last]) >= 0.0:
            last = i
    s.t = room.e_t[last]
    copy_row(room.e_y[last], work[Y])
