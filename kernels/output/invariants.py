"""The loop of a drift study: steps, invariants, and their statistics in constant memory."""

from typing import Any, NamedTuple

import numpy as np

from ..calls.calling_convention import invoke
from ..calls.user_function import evaluate
from ..jit.options import INTERNAL, njit
from ..state.record import FINISHED, RAISED, RUNNING, Y
from ..state.rows import copy_row, slot

# One record for each invariant: the address of its function, the statistics of
# (value - start) / scale.
INVARIANT = np.dtype(
    [
        ("block", "i8"),  # address of the function's block
        ("start", "f8"),
        ("scale", "f8"),
        ("max", "f8"),  # largest size so far
        ("sum", "f8"),
        ("sum_sq", "f8"),
        ("bin_sum", "f8"),
        ("bin_min", "f8"),
        ("bin_max", "f8"),
    ]
)

SURVEY = np.dtype(
    [
        ("every", "i8"),  # steps between two looks
        ("n", "i8"),  # looks so far
        ("bin_n", "i8"),  # looks in this bin
        ("i_bin", "i8"),
    ]
)


@njit(**INTERNAL)
def _clear(invariants):
    for i in range(len(invariants)):
        q = invariants[i]
        q.bin_sum = 0.0
        q.bin_min = np.inf
        q.bin_max = -np.inf


@njit(**INTERNAL)
def _evaluate(invariants, t, y, scratch):
    """Evaluate every invariant; False if a function raised."""
    for i in range(len(invariants)):
        q = invariants[i]
        if not evaluate(q.block, t, y, scratch):
            return False
        change = (scratch[0] - q.start) / q.scale
        size = abs(change)
        if not size <= q.max:  # true for NaN, too
            q.max = size
        q.sum += change
        q.sum_sq += change * change
        q.bin_sum += change
        q.bin_min, q.bin_max = min(q.bin_min, change), max(q.bin_max, change)
    return True


@njit(**INTERNAL)
def open_survey(invariants, t, y, scratch):
    """Evaluate the invariants at the start."""
    for i in range(len(invariants)):
        q = invariants[i]
        if not evaluate(q.block, t, y, scratch):
            return RAISED
        q.start = scratch[0]
        q.scale = abs(q.start) if q.start != 0.0 else 1.0
    _clear(invariants)
    return RUNNING


class Bins(NamedTuple):
    """The end of each bin, (n_bins,), and the results of each bin.

    Mean, minimum and maximum of the invariants, (n_invariants, 3, n_bins); time and state at the
    end of the bin, (n_bins,) and (n_bins, n).
    """

    edges: Any
    values: Any
    t: Any
    y: Any


@njit(**INTERNAL)
def survey(advance, solve, record, invariants, bins, scratch, n):
    """Take about `n` steps by the kernel at address `advance`; look at the invariants on the way.

    Parameters
    ----------
    advance : int
    solve : state.record.Solve
    record : array
        One of SURVEY.
    invariants : array
        INVARIANT records.
    bins : Bins
    scratch : array, shape (1,)

    Returns
    -------
    int
        RUNNING, FINISHED, or a failure of the steps or of a function.
    """
    s = solve.state[0]
    r = record[0]
    while n > 0:
        before = s.n_accepted
        status = invoke(advance, (solve.state, solve.work, solve.block, r.every))
        if status > FINISHED or s.n_accepted == before:
            return status
        n -= r.every
        y = slot(None, solve.work, Y)
        if not _evaluate(invariants, s.t, y, scratch):
            return RAISED
        r.n += 1
        r.bin_n += 1
        last = len(bins.edges) - 1
        if status == FINISHED or s.direction * (s.t - bins.edges[min(r.i_bin, last)]) >= 0.0:
            if r.i_bin <= last:
                _close_bin(r, invariants, bins, s.t, y)
        if status == FINISHED:
            return status
    return RUNNING


@njit(**INTERNAL)
def _close_bin(r, invariants, bins, t, y):
    for i in range(len(invariants)):
        q = invariants[i]
        bins.values[i, 0, r.i_bin] = q.bin_sum / r.bin_n
        bins.values[i, 1, r.i_bin], bins.values[i, 2, r.i_bin] = q.bin_min, q.bin_max
    bins.t[r.i_bin] = t
    copy_row(y, bins.y[r.i_bin])
    r.i_bin += 1
    r.bin_n = 0
    _clear(invariants)
