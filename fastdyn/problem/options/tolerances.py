"""Tolerances of a state that is followed by components that count in no error of a step."""

import math

import numpy as np


def longer_tolerances(method, rtol, atol, n, m):
    """`rtol` and `atol` of n components and m behind them; the steps are those of the n alone.

    The m components have an infinite `atol`.  They lower a norm that is a mean by
    sqrt(n / (n + m)): tolerances of the n components are lower by this factor.

    Parameters
    ----------
    method : Facts or None
        None for a method that is chosen later, whose norm is taken for a mean.
    rtol, atol : float or array_like
        With other shapes than () and (n,), the results have wrong shapes, too, and are refused.

    Returns
    -------
    rtol : float or ndarray, shape (n + m,)
    atol : ndarray, shape (n + m,)
    """
    largest = method is not None and method.largest_as_norm
    share = 1.0 if largest else math.sqrt(n / (n + m))
    rtol = share * np.asarray(rtol, float)
    atol = share * np.asarray(atol, float)
    if atol.shape in ((), (n,)):
        atol = np.r_[np.broadcast_to(atol, n), np.full(m, math.inf)]
    if not rtol.ndim:
        return float(rtol), atol
    return np.r_[rtol, np.full(m, rtol.max(initial=0.0))], atol
