"""Rows of pytest-benchmark for the kernels alone: a thousand steps of the satellite.

To compare two commits::

    python -m pytest bench/kernels.py --benchmark-save=before
    python -m pytest bench/kernels.py --benchmark-compare --benchmark-compare-fail=min:10%
"""

import numpy as np
import pytest
from numba import njit

from bench.problems import SATELLITE
from fastdyn import check
from fastdyn.adapt import bind
from fastdyn.drive import begin
from fastdyn.kernels import METHODS
from fastdyn.kernels.calls import resume
from fastdyn.specialise import pointer_kernel, specialised_kernel, start_kernel

STEPS, STEP, TOL = 1000, 0.01, 1e-6


@njit
def step(address, state, work, block):
    """Call a kernel, as the chunk loop does, from compiled code: it has no other entry."""
    return resume(address, state, work, block, STEPS)


@pytest.mark.parametrize("tier", ["pointer", "specialised"])
@pytest.mark.parametrize("name", METHODS)
def test_thousand_steps(benchmark, name, tier):
    """The stepping kernel of a method; the run never ends."""
    method, n = METHODS[name], len(SATELLITE.y0)
    mode = "acceleration" if method.second_order else "derivative"
    options = {"rtol": TOL, "atol": TOL} if method.error_order else {"step": STEP}
    problem = check.problem(
        SATELLITE.fun, 0.0, 1e12, np.array(SATELLITE.y0), method, np.empty(0), False, None,
        SATELLITE.args, mode, options,
    )  # fmt: skip
    bound = bind(SATELLITE.fun, SATELLITE.args, mode, n // 2 if method.second_order else n)
    state, work = begin(problem)
    start_kernel(name)(state, work, bound.block, float(method.error_order), method.last)
    if tier == "pointer":
        kernel = pointer_kernel(name)
    else:
        kernel = specialised_kernel(name, bound.function, n)
    benchmark.group = f"{STEPS} steps, {tier}"
    benchmark(step, kernel.address, state, work, bound.block)
    assert int(state["n_accepted"][0]) >= STEPS
