"""The arguments of the scheduler, as named tuples and records."""

from typing import Any, NamedTuple

import numpy as np

# Indices into `addresses`.  From BLOCKS on lie the blocks of the functions of one trajectory.
# SCALAR is the kernel for one trajectory.  A lane leaves to this kernel the steps that the vector
# kernel cannot take.
ADVANCE, START, WATCH, DENSE_ROWS, ALREADY, OPEN, SCALAR, BLOCKS = range(8)


NEXT, COUNT = range(2)  # indices into `queue`


IDLE = -1  # number of the member in a lane without a trajectory
GIVEN_UP = -2  # GIVEN_UP - i stands in `members` for a member i whose end is out of reach


class Task(NamedTuple):
    """The data that all workers share, and the starts of the M trajectories.

    Parameters
    ----------
    addresses : array
        Addresses of kernels and blocks.
    queue : array
        The next member and the number of members, common to all workers.
    worker : record
        A WORKER record.
    state, record : record
        The STATE and the OUTPUT with which every trajectory begins.
    values : array, (M, n_values)
        Parameters, as words.
    y0 : array, (M or 1, n)
        Initial states.
    schedules : array, (M or 1, n_schedules)
        The schedules with which a trajectory begins.
    rows : array, (M + 1,) or (2,)
        The first row of each trajectory's segments, and the number of all rows.
    """

    addresses: Any
    queue: Any
    worker: Any
    state: Any
    record: Any
    values: Any
    y0: Any
    schedules: Any
    rows: Any


class Lanes(NamedTuple):
    """The arguments of `lanes.adaptive`, and the trajectory and its records of each lane.

    `places` has (address, column of the values, bytes from lane to lane) of each parameter;
    `members` has the number of the member in each lane.
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
    """The rows and the block of one trajectory, the places of its parameters, and scratch."""

    work: Any
    block: Any
    places: Any
    scratch: Any
    extended: Any


class Room(NamedTuple):
    """The arrays that `watch` fills for a trajectory; see `output.arguments`.

    `segments` has the segments of all trajectories, or those that they share.
    """

    t: Any
    d: Any
    spans: Any
    t_eval: Any
    segments: Any
    e_index: Any
    e_t: Any
    e_y: Any


class Results(NamedTuple):
    """The results of the ensemble, one row for each of the M members.

    Parameters
    ----------
    y_eval : array, (M, n_times, n)
    y_end : array, (M, n)
    t_end, h_end, status : array, (M,)
        The time, and the size of the next step.
    counts : array, (M,)
        Records COUNTED.
    best : array, (M or 0, 4, n)
        The extrema of each component and their times; see `output/extrema.py`.
    t_first : array, (M, n_events)
        The time of the first event of each kind; NaN without such an event.
    folded : array, (M, n_folds)
        The values of the FOLDs.
    """

    y_eval: Any
    y_end: Any
    t_end: Any
    h_end: Any
    status: Any
    counts: Any
    best: Any
    t_first: Any
    folded: Any


# What is counted along a trajectory; all but the times of output reached are fields of STATE.
COUNTED = np.dtype(
    [(name, "i8") for name in ("n_accepted", "n_rejected", "n_extra", "n_times", "n_standing")]
)


class Found(NamedTuple):
    """Occurrences of events: (member, event) in `where`, time and state."""

    where: Any
    t: Any
    y: Any


# The facts that hold for all trajectories of a worker.
WORKER = np.dtype(
    [
        ("vector", "i8"),  # whether the stepping kernel takes vectors
        ("order", "f8"),  # order of the error estimate, for the first step
        ("fsal_stage", "i8"),  # stage at the end of a step, for the first step
        ("project", "i8"),  # address of a block, or 0
        ("inside", "i8"),  # address of a block, or 0; see `output.arguments.Kernels`
        ("keeps", "i8"),
        ("past", "i8"),
        ("n_past", "i8"),
        ("max_steps", "f8"),
        ("t_final", "f8"),
        ("each", "i8"),  # whether lanes return to the scheduler after every step
        ("watches", "i8"),  # whether the stepping kernel watches the events
        ("accumulates", "i8"),  # whether the stepping kernel updates the folds
        ("extrema", "i8"),  # whether the results include extrema
        ("keep_found", "i8"),  # whether the results include all events, not only the first ones
        ("n_found", "i8"),  # number of events in this piece of the output
        ("n_done", "i8"),  # number of finished trajectories
    ]
)


# A number that is accumulated along a trajectory, by number <- function(t, [number, state]).
FOLD = np.dtype([("block", "i8"), ("start", "f8")])
