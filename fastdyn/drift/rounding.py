"""The part of a drift that is rounding: how runs from neighbouring starts part."""

import math

import numpy as np

BINS = 96  # of each run
FEWEST, SHARE, MOST = (
    2000,
    20,
    10**6,
)  # steps of each run: at most a tenth of the work of a long study
APART = 1e-9  # relative distance of the states up to which the runs are those of neighbours
NO_TOLERANCE = 1e-14  # `rtol` below which the steps of an adaptive method err by rounding


def steps_compared(n_steps):
    """The number of first steps of a run that its neighbours take."""
    return min(n_steps, max(FEWEST, n_steps // SHARE), MOST)


def neighbour(y0):
    """The state one unit in the last place away."""
    eps = np.finfo(float).eps
    return y0 * (1.0 + eps) if np.any(y0) else y0 + eps


def of_rounding(t, states, changes, t_end, at_once):
    """
    The size of the rounding error of invariants at t_end, as a random walk.

    Two runs whose starts differ in the last place have the same error of the method and rounding
    errors that know nothing of one another.  The difference of two walks has twice the variance of
    one; what does not grow is the rounding of the invariant itself.  See `growth` for the mean
    square difference of values some bins apart.

    Parameters
    ----------
    t : ndarray, shape (n_bins,)
        Times since the start, equally spaced.
    states : pair of ndarray, shape (n_bins, n)
    changes : pair of ndarray, shape (n_bins, n_invariants)
        Means of the changes of the invariants in each bin.
    t_end : float
    at_once : bool
        False if the states of the two runs are not of the same times: their steps are adaptive.

    Returns
    -------
    ndarray, shape (n_invariants,)
        NaN where the runs part too soon to tell: the motion is chaotic.
    """
    one, other = states
    n = len(t)
    if at_once:
        size = np.abs(one).max(axis=1) + np.finfo(float).tiny
        parted = ~(np.abs(one - other).max(axis=1) <= APART * size)
        n = int(np.argmax(parted)) if parted.any() else n
    apart = changes[0][:n] - changes[1][:n]
    lag = n // 8
    if lag < 2:
        return np.full(apart.shape[1], math.nan)
    noise = np.mean((apart[1:] - apart[:-1]) ** 2, axis=0)
    walked = np.mean((apart[lag:] - apart[:-lag]) ** 2, axis=0)
    rate = np.maximum(walked - noise, 0.0) / ((lag - 1) * (t[1] - t[0]))
    return np.sqrt(0.5 * (rate * t_end + noise))
