"""Record: what was measured in one experiment, and how the experiment began."""

import numpy as np

from fastdyn.problem.validate import initial_state
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .free import Free, has_free
from .noise import noise_of
from .observation import Function, Linear


class Record:
    """One experiment: measured values, the initial state, the arguments.

    Parameters
    ----------
    t : array_like, shape (n_times,)
        Times of the values, in any order.
    values : array_like, shape (n_series, n_times) or (n_times,)
        NaN, or masked, where a value is missing.
    y0 : array_like of numbers and Free, shape (n,); or Free of shape (n,)
        The state at `t0`.
    args : tuple
        Arguments of the function: numbers, Free, lists and arrays of numbers and Free, which the
        function gets as arrays of floats, and whatever else the function takes.
    noise : None, number, "poisson", array_like, or list
        Standard deviation of the normal noise, or one for each time; "poisson" for counts with the
        model as their mean. None: normal and unknown, estimated by the fit. With more than one
        series, a list has one of these for each. Unknown noise is one number for each observed
        quantity, common to all records.
    observed : int, list of int, array, or callable
        What the values are values of: components of the state, by number; or the rows of a matrix
        (n_series, n) times the state; or ``observed(t, y, *args)``, a number or n_series numbers,
        with the arguments of the function. By default the whole state.
    t0 : float, optional
        Time of `y0`, not after the first value; by default the time of the first value.

    Raises
    ------
    ValueError, TypeError
        For shapes that do not fit, and values that make no sense.
    """

    @shown_when_wrong()
    def __init__(self, t, values, y0, args=(), noise=None, observed=None, t0=None):
        self.t = _floats(t, "t")
        if self.t.ndim != 1 or not self.t.size or not np.isfinite(self.t).all():
            raise ValueError(f"`t` must be finite times, shape (n_times,); got {t!r}.")
        self.values = np.atleast_2d(_floats(values, "values"))
        if self.values.ndim != 2 or self.values.shape[1] != len(self.t):
            raise ValueError(
                f"`values` must have shape (n_series, {len(self.t)}), a column for each time; got "
                f"{np.shape(values)}."
            )
        self.there = ~np.isnan(self.values)
        if np.isinf(self.values).any():
            raise ValueError("`values` must be finite, or nan where a value is missing.")
        if not self.there.any():
            raise ValueError("A Record needs values: all of `values` are nan.")
        self.data = [row[there] for row, there in zip(self.values, self.there, strict=True)]
        ends = np.cumsum([0, *map(len, self.data)])
        self.series = list(map(slice, ends[:-1], ends[1:]))
        self.y0, self.args = _state(y0), args if isinstance(args, tuple) else _tuple(args)
        self.t0 = self.t.min() if t0 is None else _time(t0)
        if self.t0 > self.t.min():
            raise ValueError(f"`t0` = {self.t0:g} is after the first time, {self.t.min():g}.")
        if self.t0 == self.t.max():
            raise ValueError("A Record needs a time after `t0`: the state at `t0` is `y0`.")
        self.times, order = np.unique(self.t, return_inverse=True)
        rows, columns = np.nonzero(self.there)
        self.places = rows, order[columns]
        self.observation = self._observation(observed)
        groups = self.observation.groups(len(self.values))
        self.noise = noise_of(noise, self.values, groups)

    def residuals(self, model):
        """(residuals, slopes by the model, roots of Fisher's information) of the values there.

        `model` has what is observed at the increasing `times`, shape (n_series, n_times).
        """
        here, found = model[self.places], np.empty((3, len(self.places[0])))
        for noise, data, series in zip(self.noise, self.data, self.series, strict=True):
            own = noise.residuals(here[series], data)
            found[0, series], found[1, series], found[2, series] = own
        return found

    def _observation(self, observed):
        n = len(self.y0.start if isinstance(self.y0, Free) else self.y0)
        if callable(observed):
            return Function(observed, len(self.values), n)
        found = Linear(observed, n)
        if len(found.matrix) != len(self.values):
            said = "the state has" if observed is None else "`observed` names"
            raise ValueError(
                f"`values` has {len(self.values)} series, and {said} {len(found.matrix)}: "
                "`observed` tells which components were measured."
            )
        return found


def _state(y0):
    """A state of floats, or one with Free in it."""
    if has_free(y0):
        if isinstance(y0, Free) and y0.start.ndim != 1:
            raise ValueError("`y0` must have shape (n,): give a list, such as [Free(1.0)].")
        return y0
    found = initial_state(y0)
    if found.dtype.kind == "c" or not found.size:
        raise TypeError(f"`y0` must be real numbers, shape (n,); got {y0!r}.")
    return found


def _floats(value, name):
    try:
        if isinstance(value, np.ma.MaskedArray):  # a masked value is a missing one
            value = np.ma.filled(value.astype(float), np.nan)
        found = np.array(value)
        if found.dtype.kind not in "fiu":
            found = np.array(value, float) if found.dtype.kind == "O" else np.array(None)
    except (TypeError, ValueError):
        found = np.array(None)
    if found.dtype.kind not in "fiu":
        kinds.refuse(name, "real numbers", value)
    return found.astype(float)


def _time(t0):
    found = _floats(t0, "t0")
    if found.ndim or not np.isfinite(found):
        raise ValueError(f"`t0` must be a finite number; got {t0!r}.")
    return float(found)


def _tuple(args):
    if isinstance(args, str | dict | set):
        kinds.refuse("args", f"a tuple, args=({args!r},)", args)
    try:
        return tuple(args)
    except TypeError:
        raise TypeError(f"`args` must be a tuple, such as (x,); got {args!r}.") from None
