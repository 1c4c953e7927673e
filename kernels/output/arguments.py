"""What kernels of a solve take: what is wanted, room for it, and how it begins."""

from typing import Any, NamedTuple

import numpy as np

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
        ("i_segment", "i8"),  # present row of segments
        ("jumps", "i8"),  # whether events change the state: a step may store a second point
        ("ends", "i8"),  # whether a time of t_eval that ends a step takes its state as it is
        ("t_last", "f8"),  # last time stored
    ]
)


class Kernels(NamedTuple):
    """What a step consists of, by address.

    `advance` steps; ``dense_rows(t, h, work, block, d)`` adds the rows of the method's interpolant
    to the Hermite cubic and returns how often it evaluated the derivative; `fsal_stage` is the
    stage that is the derivative at the end of a step; `project` is the block of the function that
    takes a new state to its constraints, or 0; `start` is what begins a solve, and goes on after a
    jump, with the `order` of the error estimate.
    """

    advance: Any
    dense_rows: Any
    fsal_stage: Any
    project: Any
    start: Any
    order: Any


class Output(NamedTuple):
    """What is wanted, and room for it.

    An OUTPUT record; times (room,), values (room, n), polynomials (room, rows, n), and their
    t_old and h (room, 2), of which one place is always free; the times `t_eval`; and `segments`,
    (n_segments, 3), where the parts of a span with breakpoints begin and end, and the time that
    their end is called in the output: without rows, there are none.
    """

    record: Any
    t: Any
    y: Any
    d: Any
    spans: Any
    t_eval: Any
    segments: Any


MOST_TERMS = 34  # coefficients of a series
MOST_ROOTS = 256  # that one event has in a step, by its series

# One per event function.
EVENTS = np.dtype(
    [
        ("block", "i8"),  # address of the function's block
        ("jump", "i8"),  # address of the block of the function that changes the state, or 0
        ("series", "i8"),  # address of the kernel of its series, see all_roots.py, or 0
        ("find", "i8"),  # of the first event: address of `find_all` if any has a series, or 0
        ("g", "f8"),  # value at the last step
        ("g_new", "f8"),
        ("size", "f8"),  # what it changes by in this step, or the sum of its series
        ("root", "f8"),  # where it crossed in this step
        ("direction", "f8"),
        ("count", "i8"),
        ("limit", "i8"),  # stop at this many; 0 means never
        ("active", "i8"),  # crossed in this step; PENDING, of events.py, behind the jump at its end
        ("t_jump", "f8"),  # the last jump at which it occurred, or was pending; NaN before
        ("noise", "f8"),  # what of its value could not be told from zero there
        ("begins", "i8"),  # how it begins this step: PLAIN, LEAVES or TOUCHES, of events.py
        ("repeats", "i8"),  # how often it has occurred at t_jump, but for the first time
    ]
)


class Events(NamedTuple):
    """The EVENTS records, and room for what is found: which, when, and the state there."""

    table: Any
    index: Any
    t: Any
    y: Any


class Begin(NamedTuple):
    """How a solve begins.

    `fresh` is 0 for one that goes on; then kernels by address: `open_events` and `watch`; and the
    initial state.
    """

    fresh: Any
    open: Any
    watch: Any
    y0: Any


FRESH, Y0 = 0, 3  # words of `whole_solve`


class Launch(NamedTuple):
    """A solve that is to begin in a new memory.

    The kernel `whole_solve` by its address, and its words by theirs; where the memory and the
    initial state lie; what the memory begins with; and, (n, 2), the words that name arrays of the
    memory, and the bytes at which those lie in it.
    """

    kernel: Any
    words: Any
    memory: Any
    y0: Any
    image: Any
    places: Any


NEXT, COUNT, BEGUN = range(3)  # in `queue`: the solve that is on, all of them, whether it has begun


class Many(NamedTuple):
    """What the solves have in common, what tells them apart, and room for what they leave.

    `queue`; the records and the first piece of the output in the memory; initial states, (m, n),
    or (1, n) for all; values of what varies, as words, (m, k); and where these go, (address,
    column) each.  Then ends, (m,); states, (m, places, n); and counts, (m, 4): status, accepted,
    rejected and extra evaluations.  The word of `whole_solve` that is its number of steps, and
    the most steps of a solve.
    """

    queue: Any
    state: Any
    record: Any
    t: Any
    y: Any
    y0: Any
    values: Any
    places: Any
    t_end: Any
    y_end: Any
    counts: Any
    n_steps: Any
    max_steps: Any
