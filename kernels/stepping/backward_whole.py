"""The backward sweep over a plain solve, from the times and states of its steps as they lie there.

A plain solve has no breakpoints, and no events that act; all its states are kept.  The kernel does
what `fastdyn/solve/adjoint/` does for other solves before and behind a sweep, in Python.
"""

import numpy as np

from ..jit.options import INTERNAL, njit
from ..state.record import NON_FINITE, RUNNING
from .backward import LAM, MU, SCALE, sweep

FEW = 8  # states that tell the sizes of components


@njit(**INTERNAL)
def _begin(table, steps, states, seeds, memory, given):
    """Fill all arrays but those of the solve: steps, seeds, the scale, and zeros."""
    work = memory.work
    single = 4 * len(table.c)
    n_steps = len(states) - 1
    n = states.shape[1]
    for j in range(n_steps):
        steps.h[j] = steps.end[j] - steps.t[j]
        steps.fresh[j] = 0
    steps.fresh[0] = 1
    for c in range(n):
        size = 0.0
        for i in range(0, n_steps + 1, 1 + (n_steps + 1) // FEW):
            size = max(size, abs(states[i, c]))
        work[single + SCALE, c] = given.atol + given.rtol * size
        work[single + LAM, c] = work[single + MU, c] = 0.0
        for k in range(len(seeds.t)):
            seeds.g[k, c] = given.g[c, k]
    for i in range(len(memory.out)):
        memory.out[i] = 0.0
    for i in range(len(memory.gauge)):
        memory.gauge[i] = 0.0
    seeds.left[0] = len(seeds.t)


@njit(**INTERNAL)
def sweep_whole(table, steps, states, seeds, block, own, memory, given):
    """Go back over all steps: NON_FINITE if a derivative is not finite.

    The parameters are those of `backward.sweep`, of which `steps.t`, `steps.end`, `states`,
    `seeds.t` and `seeds.ends` are given, and others have room; `given` is an Outside.  The
    derivatives by the initial state are left in the row of lam, those by the parameters in
    `memory.out`.
    """
    _begin(table, steps, states, seeds, memory, given)
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
