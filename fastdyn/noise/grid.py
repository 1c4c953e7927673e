"""The grid of steps of a stochastic solve, and the steps at which there is output."""

import math
from typing import NamedTuple

import numpy as np

from fastdyn.kernels.noise.arguments import MOST_LEVELS
from fastdyn.words.kinds import shown

MOST_STEPS = 2**53
SPACINGS = 4  # between numbers at the end, of the shortest step: times of steps differ
ON_GRID = 1e-6  # share of a step by which a time of output may miss the end of a step


class Grid(NamedTuple):
    """Step i goes from t0 + i h to t0 + (i + 1) h; 2^refine steps are an interval of the noise."""

    t0: float
    tf: float
    h: float
    interval: float
    refine: int
    n_steps: int


def grid(t0, tf, step, refine):
    """The Grid of equal steps, of at most `step` / 2^refine.

    Raises
    ------
    ValueError
    """
    if not t0 < tf < math.inf:
        raise ValueError(f"`t_span` must be finite and ascend; got ({t0}, {tf}).")
    if not 0.0 < step < math.inf:
        raise ValueError(f"`step` must be a positive number; got {shown(step)}.")
    if not 0 <= refine <= MOST_LEVELS - 1:
        raise ValueError(f"`refine` must be 0 to {MOST_LEVELS - 1}; got {refine}.")
    n = max(1, math.ceil((tf - t0) / step * (1.0 - 1e-12)))
    if n << refine > MOST_STEPS:
        raise ValueError(f"{n} steps, halved {refine} times, are more than 2**53.")
    interval = (tf - t0) / n
    least = math.ulp(max(abs(t0), abs(tf)))
    if interval * 0.5**refine < SPACINGS * least:
        raise ValueError(
            f"steps of {interval * 0.5**refine:.3g} are too short at t = {max(t0, tf, key=abs)}, "
            f"where numbers are {least:.3g} apart."
        )
    return Grid(t0, tf, interval * 0.5**refine, interval, refine, n << refine)


def outputs(grid, t_eval):
    """The numbers of steps done at each of the times of output.

    Raises
    ------
    ValueError
        If a time is not in the span, not in order, or not the end of a step: between two steps,
        a path is not known.
    """
    t_eval = np.asarray(t_eval, float)
    if t_eval.ndim != 1 or not np.isfinite(t_eval).all():
        raise ValueError("`t_eval` must be a 1-D array of finite times.")
    if (np.diff(t_eval) <= 0).any():
        raise ValueError("`t_eval` must ascend.")
    if len(t_eval) and not (grid.t0 <= t_eval[0] and t_eval[-1] <= grid.tf):
        raise ValueError(f"`t_eval` must lie within `t_span`, ({grid.t0}, {grid.tf}).")
    done = np.rint((t_eval - grid.t0) / grid.h)
    missed = np.abs(grid.t0 + done * grid.h - t_eval) > ON_GRID * grid.h
    if missed.any():
        raise ValueError(
            f"`t_eval` must be ends of steps, {grid.t0} + i {grid.h:.10g}; {t_eval[missed][0]} is "
            "none. Choose a `step` that divides the distances of `t_eval`."
        )
    return done.astype(np.int64)
