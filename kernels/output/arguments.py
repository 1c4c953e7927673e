"""The arguments of the kernels of a solve: requested output, memory for the output, start."""

from typing import Any, NamedTuple

import numpy as np

# The requested output, and how much of the output is stored.
OUTPUT = np.dtype(
    [
        ("every_step", "i8"),  # store each step, WHOLE ones or up to an event; else those of t_eval
        ("dense", "i8"),  # store each step's polynomial
        ("n_out", "i8"),  # points in this piece of the output
        ("n_total", "i8"),  # points in all pieces
        ("n_dense", "i8"),
        ("n_events", "i8"),  # occurrences in this piece
        ("i_eval", "i8"),  # next entry of t_eval
        ("i_segment", "i8"),  # present row of segments
        ("jumps", "i8"),  # points that a step stores behind its end, after changes of the state
        ("ends", "i8"),  # whether a time of t_eval at the end of a step takes the state of that end
        ("sampled", "i8"),  # whether the present state is stored, and schedules may act on it
        ("t_last", "f8"),  # last time stored
        ("i_change", "i8"),  # next entry of `changes`
        ("jumped", "i8"),  # number of the first change that a step jumped over, from 1; 0: none yet
        ("most_between", "i8"),  # most steps between two times of t_eval; 0: any number
        ("n_before", "i8"),  # steps before the last time of t_eval
        ("lost", "i8"),  # whether two crossings of an event were lost within a step
    ]
)

WHOLE = 2  # of `every_step`: a step that an event ends is stored up to its own end


class Kernels(NamedTuple):
    """The kernels of a method, by address.

    `advance` takes steps; ``dense_rows(t, h, work, block, d)`` adds the rows of the method's
    interpolant to the Hermite cubic and returns the number of evaluations of the derivative;
    `fsal_stage` is the stage that is the derivative at the end of a step; `project` is the block of
    the function that returns a new state to its constraints, or 0; `start` begins a solve, and
    continues a solve after a jump, with the `order` of the error estimate.

    `inside` is the block of the function that is positive in the domain of the equations, or 0;
    `keeps` has CLIPS, CHECKS and WITHIN, checks of each step; `past` and `n_past` are the first
    row and the number of rows of a method that looks back at more than one step, else 0.
    """

    advance: Any
    dense_rows: Any
    fsal_stage: Any
    project: Any
    start: Any
    order: Any
    inside: Any
    keeps: Any
    past: Any
    n_past: Any


# In `keeps`: `project` sets negative components to 0; the domain is checked at the end of a step;
# the domain is checked within a step.
CLIPS = 1
CHECKS = 2
WITHIN = 4


class Output(NamedTuple):
    """The requested output, and the arrays that receive the output.

    An OUTPUT record; times (room,), values (room, n), polynomials (room, rows, n), and t_old and h
    of the polynomials (room, 2), of which one place is always free; the times `t_eval`; and
    `segments`, (n_segments, 3): the start and the end of each part of a span with breakpoints, and
    the time under which the output stores this end.  `segments` has no rows for a span without
    breakpoints and without schedules.  `changes` has the times at which the equations change, if
    steps do not end there; `looks` has the times of a step at which the method evaluates the
    equations, in rising order, as shares of the step.  `told` receives the STATE of the
    solver at each time of `t_eval`, or has no room.

    `snapshots` is the table of `state/snapshot_table.py`; without rows, no snapshots are taken.
    """

    record: Any
    t: Any
    y: Any
    d: Any
    spans: Any
    t_eval: Any
    segments: Any
    snapshots: Any
    changes: Any
    looks: Any
    told: Any


MOST_TERMS = 34  # most coefficients of the series of an event
MOST_ROOTS = 256  # most roots of the series of one event in a step
PARTS = 8  # of a step, at whose borders an event function is evaluated
MOST_PHASES = 16  # of one event
MOST_INSIDE = MOST_ROOTS  # most occurrences of an event in a step, by its signs

# What tells an event function between the ends of a step: the interpolant; the slopes at both ends,
# rows K and K + fsal_stage; a series of any event.
INTERPOLATED, SLOPES, SERIES = range(3)

# What becomes of crossings of an event between the ends of a step: they are left alone; they count;
# the first two that do not count are noted, to be told.
KEEPS, COUNTS, TELLS = range(3)

# Of `parts`: the phases are read if the values come near zero; they are read, whatever the values.
WHOLE_STEP, ASKS, IN_PARTS = range(3)

TOLERANCE = 4 * 2.220446049250313e-16  # of a root, as in SciPy: of the unit of time, and relative
APART = 16  # least distance of two occurrences of one event, in uncertainties of the root

# One record for each event function.
EVENTS = np.dtype(
    [
        ("block", "i8"),  # address of the function's block
        ("jump", "i8"),  # address of the block of the function that changes the state, or 0
        ("series", "i8"),  # address of the kernel of its series, see all_roots.py, or 0
        ("phases", "i8"),  # address of the function of its phases, see phases.py, or 0
        ("n_periodic", "i8"),  # phases by kind
        ("n_transitions", "i8"),
        ("n_divisors", "i8"),
        ("parts", "i8"),  # whether this step is looked at in parts: WHOLE_STEP, ASKS or IN_PARTS
        (
            "find",
            "i8",
        ),  # in the first record: address of `find_all` or `find_inside`
        ("at_once", "i8"),  # in the first record: most occurrences of an event in a step
        ("inside", "i8"),  # KEEPS, COUNTS or TELLS
        ("within", "i8"),  # `inside` if the event may cross zero within this step, else KEEPS
        ("middle", "i8"),  # in the first record: INTERPOLATED, SLOPES or SERIES
        ("unit", "f8"),  # of the times of roots: the span, at most 1; 1 where the times are SciPy's
        ("bend", "f8"),  # the largest second difference in a step of late, see `may_turn`
        ("slope", "f8"),  # mean slope of the step before; NaN at the start
        ("length", "f8"),  # length of the step before
        ("fine", "f8"),  # length of the parts in which a function without phases turns; inf before
        ("lost", "f8"),  # the first crossing that was lost; NaN before
        ("lost_next", "f8"),  # the next crossing within the same step
        ("g", "f8"),  # value at the last step
        ("g_new", "f8"),
        ("size", "f8"),  # change of the event function in this step, or the sum of its series
        ("root", "f8"),  # time of the crossing in this step
        ("direction", "f8"),
        ("count", "i8"),
        ("limit", "i8"),  # occurrences that end the run; 0: none do
        ("wait", "f8"),  # time after an occurrence in which no other one counts
        ("last", "f8"),  # the last occurrence before the run; NaN without any
        ("t_last", "f8"),  # the last occurrence that counts; NaN before
        (
            "active",
            "i8",
        ),  # 1: crossed in this step; PENDING (events.py): acts after the jump that ends the step
        ("t_jump", "f8"),  # the last jump at which the event occurred or was pending; NaN before
        ("noise", "f8"),  # size up to which the value at t_jump could not be told from zero
        ("came", "f8"),  # the sign before the jump at t_jump
        ("rest", "f8"),  # size of the value behind the jump at t_jump
        ("begins", "i8"),  # value at the start of this step: PLAIN, LEAVES or TOUCHES, of events.py
        ("repeats", "i8"),  # occurrences at t_jump after the first
    ]
)


# One record for each schedule.
SCHEDULES = np.dtype(
    [
        ("jump", "i8"),  # address of the block of the function that changes the state, or 0
        ("times", "i8"),  # address of the times, or 0 for times at equal distances
        ("next", "i8"),  # index of the next time
        ("end", "i8"),  # index behind the last time
        ("way", "i8"),  # step of the index, 1 or -1
        ("start", "f8"),  # time of index 0
        ("period", "f8"),  # distance of the times
        ("t_next", "f8"),
        ("count", "i8"),
        ("limit", "i8"),  # occurrences that end the run; 0: none do
    ]
)


class Events(NamedTuple):
    """The EVENTS and the SCHEDULES records, and room for occurrences: index, time, state.

    The schedules have the indices behind the indices of the event functions.
    """

    table: Any
    schedules: Any
    index: Any
    t: Any
    y: Any


class Begin(NamedTuple):
    """The start of a solve.

    `fresh` is 0 for a solve that goes on.  `open` and `watch` are the addresses of the kernels
    `open_events` and `watch`.  `y0` is the initial state.  `before_events` names the computation
    before the first evaluation of the events: SLOPE, JACOBIAN or NOTHING.
    """

    fresh: Any
    open: Any
    watch: Any
    y0: Any
    before_events: Any


FRESH, Y0 = 0, 3  # words of `whole_solve`
SLOPE, JACOBIAN, NOTHING = 0, 1, 2  # values of `before_events`


class Launch(NamedTuple):
    """A solve that begins in a new memory.

    `kernel`, `words`, `memory` and `y0` are the addresses of the kernel `whole_solve`, of its
    arguments, of the memory and of the initial state.  `image` is the first content of the memory.
    `places`, (n, 2), has the words that name arrays of the memory, and the offset of each array in
    bytes.
    """

    kernel: Any
    words: Any
    memory: Any
    y0: Any
    image: Any
    places: Any


# Words of the history of a delay equation, see `state_before` of `dense_output.py`: addresses of
# the polynomials, of their (start, size), of the number of polynomials, and of the time that is
# reached, which is before the end of the last polynomial if an event ended the step; rows of a
# polynomial, and its components; the start of the solve; whether later times than the last step
# have the state at the start (PAST_BEGINS, while code is compared with its function before a
# solve); the Python object of the history while a solve runs, else 0; the addresses of the state at
# the start, of room for another, and of the blocks of the history and of its derivative.  Of
# `past/steps.py`: the address of its memory, which begins with the start, the size and the rows of
# a polynomial for times within the step; whether such times may be asked for (from `begin` on), and
# were; how steps are looked at (SHORT and so on); by how much, as a share of the time, a time may
# be later than that of the equations, as which it counts then; the addresses of two kernels of the
# method, its stage of the slope, its rows; whether the stages of the method are coupled with the
# polynomial; the address of the kernel that filters residuals, or 0.  From PAST_HINT on, the last
# polynomial of each place that reads the past.
PAST_D, PAST_SPANS, PAST_COUNT, PAST_NOW, PAST_ROWS, PAST_N, PAST_T0, PAST_BEGINS = range(8)
PAST_OBJECT, PAST_Y0, PAST_ROOM, PAST_HISTORY = range(8, 12)
PAST_TRIAL = PAST_HISTORY + 2
PAST_OPEN, PAST_ASKED, PAST_LOOKS, PAST_SLACK = range(PAST_TRIAL + 1, PAST_TRIAL + 5)
PAST_ADVANCE, PAST_DENSE_ROWS, PAST_FSAL, PAST_N_ROWS = range(PAST_TRIAL + 5, PAST_TRIAL + 9)
PAST_COUPLED = PAST_TRIAL + 9
PAST_FILTER = PAST_TRIAL + 10
PAST_HINT = PAST_TRIAL + 11
PAST_PLACES = 8  # places with a hint of their own
PAST_WORDS = PAST_HINT + PAST_PLACES
COUPLED = 1  # in PAST_COUPLED: the stages are coupled with the past within the step
STEPPING = 2  # a step is being taken: only then is the past within the step a part of the Jacobian
SHORT = 1  # in PAST_LOOKS: steps may contain their past
RESIDUALS = 2  # the residual of the interpolant is bounded
STAGES = 4  # the error of the interpolant between Radau's stages is bounded
GROWN = 8  # the residual of a step that is far longer than the last is bounded
