"""The way down from a start: `least_squares` with exact Jacobians, around trials that fail."""

from typing import Any

import numpy as np
from scipy.optimize import least_squares

from .motion import Failed

INSIDE = 1e-8  # how far a start is moved from its bound, as share of its size


def descend(evaluate, start, low, high, failed=None, **options) -> Any:
    """The result of `least_squares` from a start, which is moved a little inside of its bounds.

    Parameters
    ----------
    evaluate : callable
        ``evaluate(x)`` returns residuals and their Jacobian, or raises Failed.
    failed : callable, optional
        Called with each Failed of a later trial; the search then takes a shorter step.

    Raises
    ------
    Failed
        If the first trial fails.
    """
    margin = INSIDE * np.minimum(np.maximum(np.abs(start), 1.0), high - low)
    start = np.clip(start, low + margin, high - margin)
    last = [start, *evaluate(start)]
    n_rows = len(last[1])

    def residuals(x):
        if np.array_equal(x, last[0]):
            return last[1]
        try:
            last[:] = x.copy(), *evaluate(x)
        except Failed as reason:
            if failed is not None:
                failed(reason)
            return np.full(n_rows, np.nan)
        return last[1]

    def jacobian(x):
        return last[2] if np.array_equal(x, last[0]) else evaluate(x)[1]

    jac: Any = jacobian
    return least_squares(residuals, start, jac, (low, high), "trf", x_scale="jac", **options)
