"""The backward sweep over a plain solve, from the times and states of its steps as they lie there.

A plain solve has no events that act, and all its states are kept.  The kernel does what
`fastdyn/solve/adjoint/` does for other solves before and behind a sweep, in Python.
"""

import numpy as np

from ..jit.options import INTERNAL, njit
from ..state.record import NON_FINITE, RUNNING
from .backward import LAM, MU, SCALE, sweep

FEW = 8  # states that tell the sizes of components


@njit(**INTERNAL)
def steps_between(t, segments, steps):
    """Fill the Steps whose ends the output has at the times t, in a span of these segments.

    The first time is that of the start of a solve, or of an action, behind which steps begin as by
    `begin` in `output/jumps.py`.
    """
    n_segments = len(segments)
    begin = t[0]
    i = 0
    if n_segments > 0:
        way = 1.0 if segments[n_segments - 1, 1] >= segments[0, 0] else -1.0
        while i < n_segments and way * (segments[i, 1] - begin) <= 0.0:
            i += 1
        if i < n_segments and way * (segments[i, 0] - begin) > 0.0:
            begin = segments[i, 0]
    fresh = 1
    for j in range(len(t) - 1):
        end = t[j + 1]
        following = end
        steps.t[j] = begin
        steps.fresh[j] = fresh
        fresh = 0
        if i < n_segments and end == segments[i, 2]:
            end = segments[i, 1]
            i += 1
            if i < n_segments:
                following = segments[i, 0]
                fresh = 1
        steps.end[j] = end
        steps.h[j] = end - begin
        begin = following
    return RUNNING


@njit(**INTERNAL)
def _begin(table, steps, segments, states, seeds, memory, given):
    """Fill all arrays but those of the solve: steps, seeds, the scale, and zeros."""
    work = memory.work
    single = 4 * len(table.c)
    n_steps = len(states) - 1
    n = states.shape[1]
    steps_between(seeds.ends, segments, steps)
    for c in range(n):
        size = 0.0
        for i in range(0, n_steps + 1, 1 + (n_steps + 1) // FEW):
            size = max(size, abs(states[i, c]))
        scale = given.atol[c] + given.rtol * size
        work[single + SCALE, c] = scale if np.isfinite(scale) else 0.0
        work[single + LAM, c] = work[single + MU, c] = 0.0
        for k in range(len(seeds.t)):
            seeds.g[k, c] = given.g[c, k]
    for i in range(len(memory.out)):
        memory.out[i] = 0.0
    for i in range(len(memory.gauge)):
        memory.gauge[i] = 0.0
    seeds.left[0] = len(seeds.t)


@njit(**INTERNAL)
def sweep_whole(table, steps, segments, states, seeds, block, own, memory, given):
    """Go back over all steps: NON_FINITE if a derivative is not finite.

    The parameters are those of `backward.sweep`, of which `states`, `seeds.t` and `seeds.ends` are
    given, and others have room; `segments` are those of the solve, `given` is an Outside.  The
    derivatives by the initial state are left in the row of lam, those by the parameters in
    `memory.out`.
    """
    _begin(table, steps, segments, states, seeds, memory, given)
    sweep(table, steps, 0, states, seeds, block, own, memory)
    n = states.shape[1]
    lam = 4 * len(table.c) + LAM
    for c in range(n):
        if not np.isfinite(memory.work[lam, c]):
            return NON_FINITE
    for i in range(n, len(memory.out)):
        if not np.isfinite(memory.out[i]):
            return NON_FINITE
    return RUNNING
