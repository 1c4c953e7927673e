"""Snapshots: states at the ends of accepted steps, the shortest among them.

Code is compared with its function at these states, see `fastdyn/run/functions/compared.py`.  Steps
are short where things happen; a pulse between two times of output is nowhere else to be seen.

The steps are divided into intervals of `stride` steps, and the end of the shortest step of each
interval is kept.  If the table is full, two intervals become one.  In an interval, a step is
noticed only if it is SHORTER than the shortest so far: the kernel of the steps returns after such a
step, which costs 50 ns, and at most some ten times in an interval, also where each step is a little
shorter than the step before.
"""

import numpy as np

from ..jit.options import INTERNAL, njit
from .snapshot_table import LEFT, PLACE, SIZE, STATE, STRIDE, TIME

SHORTER = 0.8


@njit(**INTERNAL)
def until_next(s, snapshots, budget):
    """Set `h_short`; return the number of steps, at most `budget`, up to the next snapshot."""
    s.h_short = 0.0
    if len(snapshots) == 0:
        return budget
    counts = snapshots[0]
    if counts[LEFT] <= 0.0:
        if counts[PLACE] + 1.0 >= len(snapshots):
            _halve(snapshots)
        counts[PLACE] += 1.0
        counts[LEFT] = counts[STRIDE]
        snapshots[int(counts[PLACE]), SIZE] = np.inf
    shortest = snapshots[int(counts[PLACE]), SIZE]
    if shortest == np.inf:
        return min(budget, 1)
    s.h_short = SHORTER * shortest
    return min(budget, int(counts[LEFT]))


@njit(**INTERNAL)
def take_snapshot(s, state, snapshots, n_steps):
    """Keep the state after `n_steps` steps, of which only the last may be short."""
    if len(snapshots) == 0:
        return
    counts = snapshots[0]
    h = abs(s.t - s.t_old)
    counts[LEFT] -= n_steps
    row = snapshots[int(counts[PLACE])]
    if 0.0 < h and (h < s.h_short or row[SIZE] == np.inf):  # 0: behind a jump
        row[SIZE], row[TIME] = h, s.t
        for i in range(len(state)):
            row[STATE + i] = state[i]


@njit(**INTERNAL)
def _halve(snapshots):
    """Keep the shorter step of each two intervals, which become one interval."""
    half = (len(snapshots) - 1) // 2
    for i in range(1, half + 1):
        j = 2 * i - 1 if snapshots[2 * i - 1, SIZE] <= snapshots[2 * i, SIZE] else 2 * i
        for k in range(snapshots.shape[1]):
            snapshots[i, k] = snapshots[j, k]
    snapshots[0, PLACE], snapshots[0, STRIDE] = half, 2.0 * snapshots[0, STRIDE]
