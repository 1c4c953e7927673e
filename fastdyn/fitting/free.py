"""Parameters to be fitted, and their places in initial states and arguments."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

LONGEST = 4.6  # step of a logarithm: a factor of 100, beyond which slopes say nothing
FIXED = -1  # the parameter of a number that is not fitted


class Free:
    """A number that is fitted, in place of a fixed one in `y0` or `args` of a `Record`.

    One Free in several places, of one record or of several, is one parameter.

    Parameters
    ----------
    start : float or array_like
        Where the fit starts. An array is fitted as a whole, and takes the place of an array.
    low, high : float or array_like
        Bounds of the value; by default none.
    name : str, optional
        By default the name of the argument, or the place, such as ``y0[1]``.
    prior : tuple of two numbers, optional
        Mean and standard deviation of what is known beforehand, a normal distribution.
    log : bool
        Search and linearise in the logarithm: for positive values of unknown size. Intervals are
        then positive; a prior is still one of the value.
    """

    @shown_when_wrong(log=kinds.flag)
    def __init__(self, start, low=-np.inf, high=np.inf, name=None, prior=None, log=False):
        self.start = _numbers(start, "start")
        if not np.isfinite(self.start).all() or not self.start.size:
            raise ValueError(f"`start` of a Free must be finite numbers; got {start!r}.")
        self.low, self.high = self._like_start(low, "low"), self._like_start(high, "high")
        if not (self.low < self.high).all():
            raise ValueError(f"A Free needs low < high; got low={low!r}, high={high!r}.")
        if not ((self.low <= self.start) & (self.start <= self.high)).all():
            raise ValueError(
                f"The start {start!r} of a Free is outside of its bounds {low!r} and {high!r}."
            )
        if name is not None and not isinstance(name, str):
            raise TypeError(f"`name` of a Free must be text; got {name!r}.")
        self.name, self.prior = name, None if prior is None else self._known(prior)
        self.log = bool(log)
        if self.log:
            self.low = np.maximum(self.low, 0.0)
            if not (self.start > 0).all():
                raise ValueError(f"A Free with `log=True` starts above 0; got {start!r}.")

    def _like_start(self, value, name):
        found = _numbers(value, name)
        if np.isnan(found).any():
            raise ValueError(f"`{name}` of a Free is nan.")
        try:
            return np.broadcast_to(found, self.start.shape)
        except ValueError:
            raise ValueError(
                f"`{name}` of a Free must have the shape of its start, {self.start.shape}; got "
                f"{found.shape}."
            ) from None

    def _known(self, prior):
        try:
            mean, deviation = prior
        except (TypeError, ValueError):
            raise ValueError(
                f"`prior` of a Free is (mean, standard deviation); got {prior!r}."
            ) from None
        mean = self._like_start(mean, "prior")
        deviation = self._like_start(deviation, "prior")
        if not (np.isfinite(mean).all() and np.isfinite(deviation).all() and (deviation > 0).all()):
            raise ValueError(
                "`prior` of a Free needs a finite mean, and a finite standard deviation above 0; "
                f"got {prior!r}."
            )
        return mean, deviation

    def no_prior(self):
        """The mean and the deviation of a prior that says nothing."""
        return np.zeros(self.start.shape), np.full(self.start.shape, np.inf)

    def __repr__(self):
        of_start = {"low": self.low, "high": self.high}
        shown = [f"{k}={v.flat[0]:g}" for k, v in of_start.items() if np.isfinite(v).any()]
        shown += [] if self.name is None else [f"name={self.name!r}"]
        if self.prior is not None:
            shown.append("prior=({:g}, {:g})".format(*[each.flat[0] for each in self.prior]))
        shown += ["log=True"] if self.log else []
        start = self.start.item() if not self.start.ndim else f"array of {self.start.shape}"
        return f"Free({', '.join([str(start), *shown])})"


def _numbers(value, name):
    """A new array of floats; TypeError for what is no real number."""
    try:
        found = np.array(None if np.ma.is_masked(value) else value)
    except ValueError:
        found = np.array(None)
    if found.dtype.kind not in "fiu":
        raise TypeError(f"`{name}` of a Free must be real numbers; got {value!r}.")
    return found.astype(float)


class Template:
    """An initial state or an argument some of whose numbers are parameters.

    Attributes
    ----------
    fixed : ndarray
        The numbers; 0 where a parameter stands.
    index : ndarray of int
        The parameter of each number, or FIXED.
    whole : slice or None
        The parameters, if they are all numbers, in order.
    """

    def __init__(self, fixed, index):
        self.fixed = fixed
        self.index = index
        self.free = index != FIXED
        first = int(index.flat[0]) if index.size else FIXED
        ahead = np.arange(first, first + index.size).reshape(index.shape)
        in_order = first != FIXED and np.array_equal(index, ahead)
        self.whole = slice(first, first + index.size) if in_order else None

    def at(self, x):
        """The array at the parameters x; a float if it has no dimensions."""
        if not self.index.ndim:
            return float(x[self.index])
        found = self.fixed.copy()
        found[self.free] = x[self.index[self.free]]
        return found

    def add(self, by_value, slopes):
        """Add derivatives by each number, (n, *shape, n_times), to those by the parameters."""
        if self.whole is not None:
            slopes[:, self.whole] += by_value.reshape(len(by_value), -1, by_value.shape[-1])
            return
        flat = by_value.reshape(len(by_value), -1, by_value.shape[-1])
        index = self.index.ravel()
        for j in np.flatnonzero(index != FIXED):  # a parameter may stand in two places
            slopes[:, index[j]] += flat[:, j]


class FreePlaces(NamedTuple):
    """The parameters in one record.

    `y0`, each of `args`, and `t0` are a Template, or a fixed value; `args` are the leaves of
    `apart`.
    """

    y0: Any
    args: tuple
    t0: Any
    apart: Any

    def at(self, x):
        """(y0, args) at the parameters x."""
        y0 = self.y0.at(x) if isinstance(self.y0, Template) else self.y0.copy()
        return y0, tuple([a.at(x) if isinstance(a, Template) else a for a in self.args])

    def begin(self, x):
        """The time of the initial state at the parameters x."""
        return self.t0.at(x) if isinstance(self.t0, Template) else self.t0

    def asked(self):
        """The Template of each direction of the sensitivities, by its name."""
        found = {"y0": self.y0, **{f"args[{j}]": a for j, a in enumerate(self.args)}, "t0": self.t0}
        return {name: each for name, each in found.items() if isinstance(each, Template)}


class Parameters:
    """All parameters of a fit, in the order in which they are first met.

    Attributes
    ----------
    names : list of str
    start, low, high, mean, deviation : ndarray, shape (n_parameters,)
        `deviation` is infinite without a prior.
    log : ndarray of bool, shape (n_parameters,)
        Whose logarithm is the coordinate of the search.
    lowest, highest, longest : ndarray, shape (n_parameters,)
        The bounds, and the longest step, in coordinates.
    """

    def __init__(self):
        self.frees: list[Free] = []
        self._first = {}
        self._labels = []
        self._latest = {}
        self._size = 0

    def places(self, y0, apart, t0, labels, mark, first):
        """The FreePlaces of a record, `first` its first time; `labels` name y0 and the leaves."""
        given = zip((y0, *apart.leaves), labels, strict=True)
        found = [self._template(v, label, mark) for v, label in given]
        begin = self._template(t0, "t0", mark)
        if isinstance(begin, Template):
            latest = self._latest.setdefault(int(begin.index), first)
            self._latest[int(begin.index)] = min(latest, first)
        return FreePlaces(found[0], tuple(found[1:]), begin, apart)

    def _template(self, value, label, mark):
        held = value if isinstance(value, Free) else _with_free(value, label)
        if held is None:
            return value
        if isinstance(held, Free):
            first = self._index(held, label, mark)
            index = first + np.arange(held.start.size).reshape(held.start.shape)
            return Template(np.zeros(held.start.shape), index)
        fixed = np.zeros(held.shape)
        index = np.full(held.shape, FIXED)
        for at in np.ndindex(held.shape):
            place = f"{label}[{', '.join(map(str, at))}]"
            if not isinstance(held[at], Free):
                fixed[at] = _number_beside(held[at], place)
            elif held[at].start.ndim:
                raise ValueError(f"{place} is a Free of an array: within a list, give numbers.")
            else:
                index[at] = self._index(held[at], place, mark)
        return Template(fixed, index)

    def _index(self, free, label, mark):
        """The place of a Free among the parameters."""
        if id(free) not in self._first:
            self._first[id(free)] = self._size
            self.frees.append(free)
            self._labels.append((free.name or label, "" if free.name else mark))
            self._size += free.start.size
        return self._first[id(free)]

    def close(self):
        """Name the parameters, after all records; refuse two of one name."""
        labels = [label for label, _ in self._labels]
        self.names = []
        for free, (label, mark) in zip(self.frees, self._labels, strict=True):
            one = label + (mark if labels.count(label) > 1 else "")
            at = [list(i) for i in np.ndindex(free.start.shape)] if free.start.ndim else [""]
            self.names += [f"{one}{i}" for i in at]
        twice = {name for name in self.names if self.names.count(name) > 1}
        if twice:
            raise ValueError(
                f"Two parameters are called {twice.pop()!r}: give each Free a `name` of its own, "
                "or the same Free if they are one parameter."
            )
        if not self.names:
            raise ValueError(
                "There is nothing to fit: put `Free(start)` in place of a number in `y0` or `args` "
                "of a Record."
            )
        self.start, self.low, self.high = (
            np.concatenate([getattr(free, name).ravel() for free in self.frees])
            for name in ("start", "low", "high")
        )
        for i, latest in self._latest.items():  # y0 is not after the first value
            self.high[i] = min(self.high[i], latest)
        self.log = np.concatenate([np.full(free.start.size, free.log) for free in self.frees])
        self.lowest, self.highest = self.coordinates(self.low), self.coordinates(self.high)
        self.longest = np.where(self.log, LONGEST, np.inf)
        known = [free.prior or free.no_prior() for free in self.frees]
        self.mean, self.deviation = (
            np.concatenate([each.ravel() for each in of_all]) for of_all in zip(*known, strict=True)
        )

    def coordinates(self, x):
        """Values, shape (..., n_parameters), as coordinates of the search."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.log, np.log(x), x)

    def values(self, z):
        """Coordinates of the search as values."""
        with np.errstate(over="ignore"):
            return np.where(self.log, np.clip(np.exp(z), self.low, self.high), z)

    def slopes(self, x):
        """The derivatives of values by coordinates."""
        return np.where(self.log, x, 1.0)


def _with_free(value, label) -> Any:
    """A list, tuple or array as an array of objects if a Free is in it, else None."""
    if not isinstance(value, list | tuple | np.ndarray) or not _holds_free(value):
        return None
    try:
        held = np.array(value, dtype=object)
    except ValueError:
        held = np.array(None)
    if not held.ndim or any(isinstance(v, list | tuple | np.ndarray) for v in held.flat):
        raise ValueError(f"{label} holds a Free among lists of unequal lengths.")
    return held


def has_free(value):
    """Whether a value is a Free, or a list or array with one."""
    return isinstance(value, Free) or (
        isinstance(value, list | tuple | np.ndarray) and _holds_free(value)
    )


def _holds_free(value):
    if isinstance(value, np.ndarray) and value.dtype != object:
        return False
    return any(map(has_free, value.flat if isinstance(value, np.ndarray) else value))


def _number_beside(value, place):
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise TypeError(f"{place} stands beside a Free and must be a number; got {value!r}.")
    if not np.isreal(value):
        raise TypeError(f"{place} stands beside a Free and must be real; got {value!r}.")
    return float(value.real)
