"""The way down from a start: `least_squares` with exact Jacobians, around trials that fail."""

from typing import Any

import numpy as np
from scipy.optimize import least_squares

from .motion import Failed

INSIDE = 1e-8  # how far a start is moved from its bound, as share of its size
# Ends of a search, in standard errors of the start: its directions have slopes of length 1, so that
# units of the parameters do not decide. SciPy's 1e-8 of the norm of x would pass over a parameter
# beside one that is known to nine digits; 1e-8 of the gradient would end at a noise of 1e-8.
XTOL = 1e-12
LEAST = 1e-6  # standard errors in the size of a parameter; SciPy's distance from bounds is 1e-10
GTOL = 1e-12


def descend(evaluate, start, low, high, failed=None, longest=np.inf, **options) -> Any:
    """The result of `least_squares` from a start, which is moved a little inside of its bounds.

    Parameters
    ----------
    evaluate : callable
        ``evaluate(x)`` returns residuals and their Jacobian, or raises Failed.
    failed : callable, optional
        Called with each Failed of a later trial; the search then takes a shorter step.
    longest : float or ndarray
        The longest step from one trial to the next.

    Raises
    ------
    Failed
        If the first trial fails.
    """
    size = np.where(start == 0, 1.0, np.abs(start))
    margin = INSIDE * np.minimum(size, high - low)
    start = np.clip(start, low + margin, high - margin)
    last = [start, *evaluate(start)]
    n_rows = len(last[1])
    lengths = np.maximum(scaled(last[2])[1], LEAST / size)

    def values(z):
        return start if np.array_equal(z, start * lengths) else np.clip(z / lengths, low, high)

    def residuals(z):
        x = values(z)
        if np.array_equal(x, last[0]):
            return last[1]
        if (np.abs(x - last[0]) > longest).any():
            return np.full(n_rows, np.nan)
        try:
            last[:] = x, *evaluate(x)
        except Failed as reason:
            if failed is not None:
                failed(reason)
            return np.full(n_rows, np.nan)
        return last[1]

    def jacobian(z):
        x = values(z)
        return (last[2] if np.array_equal(x, last[0]) else evaluate(x)[1]) / lengths

    jac: Any = jacobian
    bounds = low * lengths, high * lengths
    given = {"x_scale": "jac", "xtol": XTOL, "gtol": GTOL, **options}
    found = least_squares(residuals, start * lengths, jac, bounds, "trf", **given)
    found.x = values(found.x)
    return found


def scaled(jac):
    """The Jacobian with columns of length 1 (zeros stay), and their lengths."""
    lengths = np.linalg.norm(jac, axis=0)
    lengths[lengths == 0] = 1.0
    return jac / lengths, lengths
