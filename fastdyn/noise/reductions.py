"""Numbers gathered from all paths at the times of output, in place of the paths."""

from typing import Any

import numpy as np

from fastdyn.words.kinds import shown
from fastdyn.words.near import did_you_mean


class Quantiles:
    """Quantiles of each component over the paths.

    Parameters
    ----------
    shares : array_like, shape (k,)
        Shares from 0 to 1, as `numpy.quantile` takes them.
    """

    name = "quantiles"

    def __init__(self, shares=(0.05, 0.25, 0.5, 0.75, 0.95)):
        self.shares = np.asarray(shares, float)
        if self.shares.ndim != 1 or not ((self.shares >= 0.0) & (self.shares <= 1.0)).all():
            raise ValueError(f"the shares of quantiles lie from 0 to 1; got {shown(shares)}.")

    def __call__(self, t, y):
        """The quantiles at time t of the states y, shape (M, n); shape (k, n)."""
        return np.quantile(y, self.shares, axis=0)


class Histogram:
    """The number of paths in each bin, for each component.

    Parameters
    ----------
    edges : array_like, shape (k + 1,)
        The edges of the bins, in order, as `numpy.histogram` takes them.
    """

    name = "histogram"

    def __init__(self, edges):
        self.edges = np.asarray(edges, float)
        if self.edges.ndim != 1 or len(self.edges) < 2 or not (np.diff(self.edges) > 0).all():
            raise ValueError(f"the edges of a histogram ascend; got {shown(edges)}.")

    def __call__(self, t, y):
        """The numbers of paths at time t of the states y, shape (M, n); shape (k, n)."""
        return np.stack([np.histogram(part, self.edges)[0] for part in y.T], axis=-1)


def _mean(t, y):
    return y.mean(axis=0)


def _variance(t, y):
    return y.var(axis=0, ddof=1) if len(y) > 1 else np.full(y.shape[1], np.nan)


def _standard_error(t, y):
    return np.sqrt(_variance(t, y) / len(y))


def _median(t, y):
    return np.median(y, axis=0)


NAMED = {
    "mean": _mean, "variance": _variance, "standard_error": _standard_error, "median": _median,
    "quantiles": Quantiles(),
}  # fmt: skip


def wanted(reduce):
    """{name: function of (t, y)} of the argument `reduce`."""
    if reduce is None:
        return {}
    if isinstance(reduce, dict):
        items = list(reduce.items())
    else:
        several = isinstance(reduce, list | tuple)
        listed: Any = reduce if several else [reduce]
        items = [(None, item) for item in listed]
    found = {}
    for name, item in items:
        if isinstance(item, str):
            if item not in NAMED:
                names = f"choose from {', '.join(NAMED)}, Quantiles, Histogram, or a function."
                meant = did_you_mean(item, NAMED, form='"{}"') or names
                raise ValueError(f"`reduce={item!r}` is unknown; {meant}")
            own = item
            item = NAMED[item]
        elif callable(item):
            own = getattr(item, "name", None) or getattr(item, "__name__", type(item).__name__)
        else:
            raise TypeError(f"`reduce` takes names and functions of (t, y); got {shown(item)}.")
        name = name or own
        if name in found:
            raise ValueError(f"`reduce` has two items named {name!r}: give a dict, {{name: item}}.")
        found[name] = item
    return found


def stacked(name, parts):
    """The numbers of one item at all times, with the times as the last axis."""
    shapes = {part.shape for part in parts}
    if len(shapes) > 1:
        raise ValueError(f"the item {name!r} of `reduce` returned several shapes: {shapes}.")
    return np.stack(parts, axis=-1)
