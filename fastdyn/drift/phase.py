"""The phase: the time by which a computed motion is ahead of the exact motion."""

import math

import numpy as np

GRID = 64  # places on the orbit that are tried first
REFINEMENTS = 20  # Newton steps: six double the digits from a 64th of a period to rounding


def phase(exact, rhs, t, y, period):
    """The time by which y at t is ahead: the time of the nearest exact state, less t.

    Parameters
    ----------
    exact : callable
        ``exact(t)``, shape (n, n_times).
    rhs : callable
        ``rhs(t, w)``, the derivative.
    t, y : ndarray, shapes (n_times,), (n, n_times)
        Times in equal steps.
    period : float or None
        Period of the exact motion, if it has one.  A phase of more than half a period is found by
        continuity: from one time to the next, the phase changes by less than half a period.

    Returns
    -------
    ndarray, shape (n_times,)
    """
    if period is None or not math.isfinite(period):
        return _refined(exact, rhs, t, y, np.zeros(len(t)), math.inf)
    offsets = (np.arange(GRID) / GRID - 0.5) * period
    distance = [np.sum((exact(t + offset) - y) ** 2, axis=0) for offset in offsets]
    nearest = offsets[np.argmin(distance, axis=0)]
    found = _refined(exact, rhs, t, y, nearest, period / GRID)
    step = before = 0.0
    for i, value in enumerate(found):
        turns = round((before + step - value) / period)
        found[i] = value + turns * period
        step = found[i] - before if i else 0.0
        before = found[i]
    return found


def _refined(exact, rhs, t, y, ahead, longest):
    """Newton's method for the place at which the difference is at right angles to the motion."""
    ahead = np.array(ahead, float)
    for _ in range(REFINEMENTS):
        state = exact(t + ahead)
        rate = np.array([rhs(*given) for given in zip(t + ahead, state.T, strict=True)]).T
        change = ((y - state) * rate).sum(axis=0) / (rate * rate).sum(axis=0)
        ahead += np.clip(change, -longest, longest)
        if not np.abs(change).max() > 1e-12 * np.abs(t).max():
            break
    return ahead
