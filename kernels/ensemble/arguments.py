"""What the scheduler works on, as named tuples and records."""

from typing import Any, NamedTuple

import numpy as np

# In `addresses`; from BLOCKS on, the blocks of one trajectory's functions.
# SCALAR steps a trajectory that its lane has left to it.
ADVANCE, START, WATCH, DENSE_ROWS, ALREADY, OPEN, SCALAR, BLOCKS = range(8)


NEXT, COUNT = range(2)  # in `queue`


IDLE = -1  # member of a lane that has none


class Task(NamedTuple):
    """What all workers share, and where each trajectory comes from.

    Kernels by address; the next member and the number of them, in a `queue` for all workers; a
    WORKER record; one STATE and one OUTPUT record, as every trajectory begins; parameters, as
    words, (M, n_values); initial states, (M or 1, n); and schedules, (M or 1, n_schedules), as they
    begin.
    """

    addresses: Any
    queue: Any
    worker: Any
    state: Any
    record: Any
    values: Any
    y0: Any
    schedules: Any


class Lanes(NamedTuple):
    """The vectors: see `lanes.adaptive`; which trajectory is in each lane, and its records.

    `places` has (address, column of the values, bytes from lane to lane) of each parameter.
    """

    fields: Any
    work: Any
    block: Any
    places: Any
    members: Any
    states: Any
    records: Any
    events: Any
    schedules: Any


class Single(NamedTuple):
    """The rows and the block of one trajectory, where its parameters go, and scratch."""

    work: Any
    block: Any
    places: Any
    scratch: Any
    extended: Any


class Room(NamedTuple):
    """What `watch` fills for a trajectory; see `output.arguments.Output` and `events.Events`."""

    t: Any
    d: Any
    spans: Any
    t_eval: Any
    segments: Any
    e_index: Any
    e_t: Any
    e_y: Any


class Results(NamedTuple):
    """One row a member: (M, n_times, n), (M, n), (M,), (M,), (M, 4), (M or 0, 4, n), (M, n_events),
    (M, n_folds).

    Counts are of steps accepted, rejected, evaluations outside them, times reached; `best` is of
    `extrema`; `t_first` has the time of the first event of each kind, NaN until it happens;
    `folded` the values of the FOLDs.
    """

    y_eval: Any
    y_end: Any
    t_end: Any
    status: Any
    counts: Any
    best: Any
    t_first: Any
    folded: Any


class Found(NamedTuple):
    """Occurrences of events: (member, event), time and state."""

    where: Any
    t: Any
    y: Any


# What a worker knows of all its trajectories.
WORKER = np.dtype(
    [
        ("vector", "i8"),  # whether the stepping kernel takes vectors
        ("order", "f8"),  # of the error estimate, and the stage at the end of a step: for the start
        ("fsal_stage", "i8"),
        ("project", "i8"),  # address of a block, or 0
        ("inside", "i8"),  # the same; see `output.arguments.Kernels`, and for the next three
        ("keeps", "i8"),
        ("past", "i8"),
        ("n_past", "i8"),
        ("max_steps", "f8"),
        ("t_final", "f8"),
        ("each", "i8"),  # whether lanes return to the scheduler after every step
        ("watches", "i8"),  # whether the stepping kernel watches the events
        ("accumulates", "i8"),  # whether it takes the states into the folds
        ("extrema", "i8"),  # whether they are wanted
        ("keep_found", "i8"),  # whether every event is, not the first of each kind alone
        ("n_found", "i8"),  # events in this piece
        ("n_done", "i8"),  # trajectories
    ]
)


# A value that is accumulated along a trajectory, number <- function(t, [number, state]).
FOLD = np.dtype([("block", "i8"), ("start", "f8")])
