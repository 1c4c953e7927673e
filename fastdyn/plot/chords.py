"""The times at which a curve is drawn: enough that no eye sees a chord."""

import numpy as np

LEAST, MOST = 500, 5000  # points of a curve; the last halving may double MOST
HALVINGS = 6  # most halvings of an interval
OFF = 1e-3  # largest distance of a chord from its curve, as a share of the height of a picture


def times(sol, steps):
    """
    Times between which straight lines look like the curves of all components.

    Parameters
    ----------
    sol : callable
        State of a run at times, shape (n, n_times).
    steps : ndarray
        Times of the steps of the run, in order.

    Returns
    -------
    ndarray
        The times, denser where a component bends.
    """
    t = np.linspace(steps[0], steps[-1], LEAST)
    if len(steps) < MOST // 2:
        t = np.union1d(t, steps)  # a kink is at the end of a step
    y = sol(t)
    between = np.arange(len(t) - 1)  # intervals that may be too long
    for _ in range(HALVINGS):  # at a jump, halving would never end
        if not len(between) or len(t) >= MOST:
            break
        middle = 0.5 * (t[between] + t[between + 1])
        found = sol(middle)
        sizes = np.maximum(np.ptp(y, axis=1), 1e-300)[:, None]
        bends = np.abs(found - 0.5 * (y[:, between] + y[:, between + 1])) > OFF * sizes
        bent = np.flatnonzero(bends.any(axis=0))
        after = between[bent] + 1
        t = np.insert(t, after, middle[bent])
        y = np.insert(y, after, found[:, bent], axis=1)
        first = after - 1 + np.arange(len(bent))  # where the left halves are now
        between = np.sort(np.concatenate([first, first + 1]))
    return t
