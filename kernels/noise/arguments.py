"""The arguments of the loop over paths, as records and rows; this file imports no compiler."""

from typing import Any, NamedTuple

import numpy as np

# The facts of a run.  Step i goes from t0 + i h to t0 + (i + 1) h; 2^refine steps are an interval
# of the grid of the noise.
RUN = np.dtype(
    [
        ("key", "i8"),
        ("t0", "f8"),
        ("h", "f8"),
        ("interval", "f8"),  # length of an interval of the grid
        ("refine", "i8"),
        ("begin", "i8"),  # the first step, and the step behind the last
        ("end", "i8"),
        ("first", "i8"),  # the first path, and the path behind the last
        ("last", "i8"),
        ("held", "i8"),  # see `brownian.draw`
    ]
)

# Rows of `noise`, each with a vector for each source: W and H of the step; the numbers of the next
# interval of the grid; two rows for a step; from STACK on, W and H of the second halves, by level.
W, H, W_NEXT, H_NEXT, MEAN, SHARE, STACK = range(7)

# Rows of `work`: a column of G; the state; rows for a step; what the friction leaves of a velocity,
# and the factor of its noise, which are given.
G, Y, OUT, SLOPE, OTHER_SLOPE, STAGE, PRODUCT, UP, DOWN, KEEPS, KICK = range(11)
N_ROWS = 11

# Rows of `scratch` for each event: g and its variance at the start of the next step, and its change
# by one deviation of a single source; whether the last step has a passage, and may have one; then g
# at its start and at its end, its change, normal numbers for the time of the passage, its share of
# the step, and what moves the state there.
BEFORE, VARIANCE, CHANGE, HIT, WANTED, START, AFTER, CHANGED, FIRST, SECOND, THIRD, AT, FACTOR = (
    range(13)
)
N_SCRATCH = 13

# What a number serves, in the upper bits of the word of the source; from HALF on, the level of
# halves.
OF_W, OF_H, HALF = range(3)
MOST_LEVELS = 64  # of halves; the uses of numbers behind serve passages
SOURCE_BITS = 20


class Places(NamedTuple):
    """Where passages are noted.

    Parameters
    ----------
    alive : array, (M,)
        1, or 0 for a path that a terminal event has ended.
    times : array, (n_events, M)
        The time of the first passage; NaN without one.
    scratch : array, (n_events N_SCRATCH, width)
    directions : array, (n_events,)
        1 for passages from below, -1 for passages from above, 0 for both.
    units : array, (m, m width)
        Row j has the noise of one step's deviation for source j, and zeros for the others.
    """

    alive: Any
    times: Any
    scratch: Any
    directions: Any
    units: Any


def rows_of_noise(refine):
    """The number of rows of `noise`."""
    return STACK + 2 * refine
