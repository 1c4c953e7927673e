"""Which of the times at which a function may switch matter, for the present parameters.

The rules, with their reasons, are those of `fastdyn/trace/switching/decided.py`.
"""

from typing import Any, NamedTuple

import numpy as np

from ..calls.user_function import by_pointer
from ..jit.options import INTERNAL, njit
from ..state.record import RUNNING

POINTS = 3  # on each side of a time, at which the function is evaluated
STATE = 2 * POINTS  # the row behind those of the points, a state that no number uses
KEPT = 1.0
SHARP = 2.0


class Limits(NamedTuple):
    """The numbers of `decided`, and the span of the times."""

    first: Any
    last: Any
    near: Any
    near_end: Any
    noise: Any
    chord: Any
    sharp: Any
    longest: Any  # longer intervals count as 1


@njit(**INTERNAL)
def _lengths(limits, t, i):
    """The lengths of the intervals before and behind a time."""
    left = t[i] - (t[i - 1] if i > 0 else limits.first)
    right = (t[i + 1] if i + 1 < len(t) else limits.last) - t[i]
    return 1.0 if left > limits.longest else left, 1.0 if right > limits.longest else right


@njit(**INTERNAL)
def _beside(block, limits, t, i, rows):
    """Evaluate the numbers before and behind a time."""
    left, right = _lengths(limits, t, i)
    for k in range(POINTS):
        by_pointer(t[i] - (POINTS - k) * limits.near * left, rows[STATE], block, rows[k])
        by_pointer(t[i] + (k + 1) * limits.near * right, rows[STATE], block, rows[POINTS + k])


@njit(**INTERNAL)
def _ranges(block, limits, t, rows, ranges):
    """The range of each number near all times."""
    for j in range(rows.shape[1]):
        ranges[0, j] = ranges[1, j] = np.nan
    for i in range(len(t)):
        _beside(block, limits, t, i, rows)
        for j in range(rows.shape[1]):
            for k in range(2 * POINTS):
                value = rows[k, j]
                if not ranges[0, j] <= value and value == value:
                    ranges[0, j] = value
                if not ranges[1, j] >= value and value == value:
                    ranges[1, j] = value


@njit(**INTERNAL)
def _change(limits, t, i, f, size):
    """The jump and the bend of one number at a time, as shares of a size."""
    left, right = _lengths(limits, t, i)
    before = 3.0 * (f[2] - f[1]) + f[0]
    behind = 3.0 * (f[3] - f[4]) + f[5]
    jump = abs(behind - before) / size
    slope = (5.0 * f[2] - 8.0 * f[1] + 3.0 * f[0]) / (2.0 * limits.near * left)
    other = (-5.0 * f[3] + 8.0 * f[4] - 3.0 * f[5]) / (2.0 * limits.near * right)
    bend = abs(other - slope) * min(left, right) / size
    if jump != jump:
        jump = 0.0
    if (f[2] != f[2]) != (f[3] != f[3]) or jump == np.inf:
        jump = 1.0
    if not bend < np.inf:
        bend = 0.0
    return jump, bend


@njit(**INTERNAL)
def decide(block, limits, t, weight, ends, rows, ranges, marks):
    """Mark the times that matter with KEPT or SHARP, then the `ends` where a number jumps.

    Parameters
    ----------
    block : ndarray of int64
        Of the function that computes the numbers which meet the state, by the time alone.
    t, weight : ndarray
        The times in rising order, and the weights of the knots among them.
    ends : ndarray
        Times that are ends of the span.
    rows, ranges : ndarray, shape (2 POINTS + 1, n), (2, n)
        Room.
    marks : ndarray, shape (len(t) + len(ends),)
    """
    if len(t) > 0:
        _ranges(block, limits, t, rows, ranges)
    total = 0.0
    sharp_total = 0.0
    share = np.sqrt(limits.chord / limits.sharp)
    for i in range(len(t)):
        _beside(block, limits, t, i, rows)
        jump = 0.0
        bend = 0.0
        for j in range(rows.shape[1]):
            f = (rows[0, j], rows[1, j], rows[2, j], rows[3, j], rows[4, j], rows[5, j])
            one, other = _change(limits, t, i, f, ranges[1, j] - ranges[0, j])
            jump = max(jump, one)
            bend = max(bend, other)
        own = np.sqrt((bend if bend > limits.noise else 0.0) / (8.0 * limits.chord))
        own = max(own, weight[i])
        before = total
        sharp_before = sharp_total
        total += own
        sharp_total += own * share
        marks[i] = 0.0
        if jump > limits.noise or np.floor(total) > np.floor(before):
            marks[i] = KEPT
        if jump > limits.sharp or np.floor(sharp_total) > np.floor(sharp_before):
            marks[i] = SHARP
    for i in range(len(ends)):
        inwards = limits.near_end * min(limits.last - limits.first, 1.0)
        if ends[i] != limits.first:
            inwards = -inwards
        for k in range(POINTS):
            by_pointer(ends[i] + k * inwards, rows[STATE], block, rows[k])
        marks[len(t) + i] = 0.0
        for j in range(rows.shape[1]):
            there = rows[0, j]
            limit = 2.0 * rows[1, j] - rows[2, j]
            if not abs(there - limit) <= limits.noise * max(abs(there), abs(limit)):
                marks[len(t) + i] = KEPT
    return RUNNING
