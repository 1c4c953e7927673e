"""The functions of scipy.spatial.distance, for numbers and for long arrays."""

from typing import Any

import numpy as np

from ..symbols.arrays import Array
from ..symbols.symbolic import Batched, refuse

MEASURES: dict[str, Any] = {
    "euclidean": lambda d: np.sqrt(np.sum(d * d, axis=-1)),
    "sqeuclidean": lambda d: np.sum(d * d, axis=-1),
    "cityblock": lambda d: np.sum(np.abs(d), axis=-1),
    "chebyshev": lambda d: np.max(np.abs(d), axis=-1),
}


def _measure(metric, more):
    if more or not isinstance(metric, str) or metric not in MEASURES:
        refuse("distances of another kind")
    return MEASURES[metric]


def _points(values) -> Any:
    x: Any = values if isinstance(values, Batched) else Array.of(values)
    if x.ndim != 2:
        raise ValueError("points must be a 2-dimensional array.")
    return x


def cdist(XA, XB, metric="euclidean", **more):
    """The distance between each point of one set and each point of another, shape (n, m)."""
    measure, a, b = _measure(metric, more), _points(XA), _points(XB)
    return measure(a[:, None, :] - b[None, :, :])


def pdist(X, metric="euclidean", **more):
    """The distance between each two points of a set, shape (n (n - 1) / 2,)."""
    measure, x = _measure(metric, more), _points(X)
    i, j = np.triu_indices(len(x), 1)
    return measure(x[i] - x[j])


def squareform(X, force="no", checks=True):
    """The matrix of the distances that `pdist` gives."""
    x: Any = X if isinstance(X, Batched) else Array.of(X)
    n = int(np.ceil(np.sqrt(2 * x.size)))
    if x.ndim != 1 or force != "no" or n * (n - 1) != 2 * x.size or not n:
        refuse("squareform of this array")
    at = np.zeros((n, n), int)
    at[np.triu_indices(n, 1)] = np.arange(x.size)
    return np.where(np.eye(n, dtype=bool), 0.0, x[at + at.T])


DISTANCES = {"cdist": cdist, "pdist": pdist, "squareform": squareform}
