"""Profile likelihood: intervals where the sum of squares is no parabola, and a test whether it is.

An interval holds the values of a parameter at which the sum of squares, minimised over the other
parameters, rises by at most the square of a quantile.  D. M. Bates, D. G. Watts, "Nonlinear
Regression Analysis and Its Applications", Wiley 1988, section 6.1.
"""

import functools
from typing import Any

import numpy as np
from scipy.optimize import brentq

from .descent import descend
from .motion import Failed

WIDEST = 12  # times that a search for the end of an interval goes on outwards
OUTWARDS = 1.6  # by this factor
ENDS_TO = 1e-3  # of the linearised error: accuracy of the ends
FINE = 1e-6  # relative change of the sum of squares at which the others are fitted
FARTHEST = 1e3  # rise of a trial whose motion fails, as a multiple of the rise sought
SHORTEST = 0.1  # part of a step that must lie within the bounds for a comparison


def departure(model, x, steps, q):
    """The largest ratio, up or down, of the true rise of the sum of squares to the linearised.

    Parameters
    ----------
    steps : ndarray, shape (k, n_parameters)
        Steps that raise the linearised sum of squares by 1.  Trials are q of them away, both ways,
        or as far as the bounds allow.
    """
    p = model.parameters
    worst = 1.0
    least = model.chi2(x)
    for step in (*(q * steps), *(-q * steps)):
        with np.errstate(divide="ignore", invalid="ignore"):
            room = np.where(step > 0, p.highest - x, p.lowest - x) / step
        part = min(1.0, np.nanmin(room, initial=1.0))
        if part < SHORTEST:
            continue
        rise = (model.chi2(x + part * step) - least) / (q * part) ** 2
        worst = max(worst, rise, 1.0 / max(rise, 1.0 / FARTHEST))
    return worst


def interval(model, x, i, error, chi2, rise):
    """(low, high) of parameter i; a bound, or infinity, where the sum does not rise enough.

    Parameters
    ----------
    x : ndarray
        The best values, where the sum of squares is chi2.
    error : float
        The linearised standard error, the length of the first trial.
    """
    p = model.parameters
    low, high = (_end(model, x, i, sign, error, chi2, rise) for sign in (-1.0, 1.0))
    return max(low, float(p.lowest[i])), min(high, float(p.highest[i]))


def _end(model, x, i, sign, error, chi2, rise):
    p = model.parameters
    rest = np.arange(len(x)) != i
    near = x[rest].copy()

    @functools.cache  # brentq asks for the ends again, where the search from elsewhere may differ
    def excess(value):
        if value == x[i]:
            return -rise
        found, at = _least(model, x, i, value, near, rest)
        if np.isfinite(found):
            near[:] = at
        return min(found - chi2, FARTHEST * rise) - rise

    bound = p.highest[i] if sign > 0 else p.lowest[i]
    inside = x[i]
    reach = np.sqrt(rise) * (error if np.isfinite(error) else abs(x[i]) or 1.0)
    for _ in range(WIDEST):
        trial = x[i] + sign * reach
        if sign * (trial - bound) >= 0:
            trial = bound
        if trial == inside:
            return float(bound)
        if excess(trial) > 0:
            root: Any = brentq(excess, inside, trial, xtol=ENDS_TO * abs(trial - x[i]))
            return float(root)
        if trial == bound:
            return float(bound)
        inside = trial
        reach = OUTWARDS * reach
    return float(sign * np.inf)


def _least(model, x, i, value, near, rest):
    """(least sum of squares with parameter i at a value, the other parameters there)."""
    p = model.parameters
    trial = x.copy()
    trial[i] = value
    if not rest.any():
        return model.chi2(trial), near

    def evaluate(others):
        trial[rest] = others
        found = model.residuals(trial)
        return found.r, found.jac[:, rest]

    try:
        found = descend(
            evaluate, near, p.lowest[rest], p.highest[rest], None, p.longest[rest], ftol=FINE
        )
    except Failed:
        return np.inf, near
    return 2.0 * found.cost, found.x
