"""The noise of a series of values: residuals of unit variance, and their slopes.

The squares of the residuals of a series add up to its deviance, twice the logarithm of the
likelihood's distance from that of a perfect model; a fit minimises the sum of all.
"""

import numpy as np
from scipy.special import gammaln, xlogy

from .motion import Failed

POISSON = "poisson"
OWN = "own"
LOG_2PI = float(np.log(2.0 * np.pi))
LEAST_MEAN = 1e-12  # of a count: below, the logarithm is taken here
NEGATIVE = 1e-6  # of the largest mean: solves are in error by less, a mean below is a wrong model
NEAR = 1e-6  # relative distance of model and count, below which the root's slope is its limit


class Normal:
    """Normal noise of known standard deviations, one for each value that is there."""

    def __init__(self, deviation):
        self._scale = 1.0 / deviation

    def log_likelihood(self, r, data):
        """The logarithm of the density of the values with residuals r."""
        return float((np.log(self._scale) - 0.5 * (r**2 + LOG_2PI)).sum())

    def residuals(self, model, data):
        """(residuals, their slopes by the model, roots of Fisher's information) of the values."""
        return (model - data) * self._scale, self._scale, self._scale


class Unknown:
    """Normal noise of one unknown standard deviation, for the series of one `group`.

    `deviation` is the present estimate.
    """

    def __init__(self, group):
        self.group = group
        self.deviation = 1.0

    def residuals(self, model, data):
        """As of `Normal`; the slopes are one number."""
        scale = 1.0 / self.deviation
        return (model - data) * scale, scale, scale


class Poisson:
    """Counts, each with the model as its mean: residuals are signed roots of the deviance."""

    def log_likelihood(self, r, data):
        """As of `Normal`: that of a perfect model less half of the deviance."""
        return float((xlogy(data, data) - data - gammaln(data + 1.0) - 0.5 * r**2).sum())

    def residuals(self, model, data):
        """As of `Normal`; Failed where the mean of a count is negative."""
        if (model < -NEGATIVE * np.abs(model).max(initial=0.0)).any():
            raise Failed(
                f"the model of counts is negative, {model.min():.6g}, where a count has its mean"
            )
        mean = np.maximum(model, LEAST_MEAN)
        d = mean - data
        logarithm = data * np.log(np.maximum(data, LEAST_MEAN) / mean)
        root = np.sqrt(2.0 * np.maximum(d + logarithm, 0.0))
        found = np.sign(d) * root
        information = 1.0 / np.sqrt(mean)
        near = np.abs(d) <= NEAR * mean
        slope = np.where(near, information, d / (mean * np.where(near | (root == 0), 1.0, found)))
        return found, slope, information


def noise_of(noise, values, groups, record):
    """The noise of each series, from the argument `noise` of a Record.

    Parameters
    ----------
    noise : None, "own", number, "poisson", array_like, or a list of these, one for each series
    values : ndarray, shape (n_series, n_times)
    groups : list
        What names the group of each series whose noise is unknown.
    record : Record
        Names the groups of this record alone.
    """
    n_series = len(values)
    each = [noise] * n_series
    if isinstance(noise, list | tuple | np.ndarray) and (n_series > 1 or np.ndim(noise) != 1):
        if len(noise) != n_series:
            raise ValueError(
                f"`noise` must have one entry for each of the {n_series} series; got {len(noise)}."
            )
        each = list(noise)
    elif isinstance(noise, list | tuple) and len(noise) == 1:
        each = list(noise)
    given = zip(each, values, groups, strict=True)
    return [_of_series(one, row, group, i, record) for i, (one, row, group) in enumerate(given)]


def _of_series(noise, values, group, i, record):
    if noise is None:
        return Unknown(group)
    if isinstance(noise, str) and noise == OWN:
        return Unknown((*group, record))
    there = ~np.isnan(values)
    if isinstance(noise, str):
        if noise != POISSON:
            raise ValueError(
                f"`noise={noise!r}` is unknown; give standard deviations, 'poisson', 'own', or "
                "None."
            )
        wrong = values[there & ~((values >= 0) & (values == np.floor(values)))]
        if wrong.size:
            raise ValueError(
                f"Series {i} has the value {wrong[0]:g}, and `noise='poisson'` is for counts 0, 1, "
                "2, ...: give standard deviations for anything else."
            )
        return Poisson()
    try:
        deviation = np.asarray(noise, float)
        if deviation.ndim > 1 or isinstance(noise, bool):
            raise TypeError
        deviation = np.broadcast_to(deviation, values.shape)
    except (TypeError, ValueError):
        raise ValueError(
            f"`noise` of series {i} must be a standard deviation, or one for each of the "
            f"{len(values)} times; got {noise!r}."
        ) from None
    if not (np.isfinite(deviation[there]).all() and (deviation[there] > 0).all()):
        raise ValueError(f"`noise` of series {i} must be finite standard deviations above 0.")
    return Normal(deviation[there])
