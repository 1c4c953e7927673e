"""Record: what was measured in one experiment, and how the experiment began."""

import dataclasses
from typing import Any

import numpy as np

from fastdyn.problem.validate import initial_state
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .free import Free, has_free
from .noise import noise_of
from .observation import Linear, ObservingFunction

MOVED = 1.001  # factor of a parameter, to see whether the start of a system depends on it


class Record:
    """One experiment: measured values, the initial state, the arguments.

    Parameters
    ----------
    t : array_like, shape (n_times,)
        Times of the values, in any order.
    values : array_like, shape (n_series, n_times) or (n_times,)
        NaN, or masked, where a value is missing.
    y0 : array_like of numbers and Free, shape (n,); or Free of shape (n,)
        The state at `t0`. By default that of a system.
    args : tuple, or dict with a system
        Arguments of the function: numbers, Free, lists and arrays of numbers and Free, which the
        function gets as arrays of floats; dicts, NamedTuples and dataclasses with Free, which the
        function gets as they are; and whatever else the function takes. With a system, parameters
        by name; the others are those of the system.
    noise : None, "own", number, "poisson", array_like, or list
        Standard deviation of the normal noise, or one for each time; "poisson" for counts with the
        model as their mean. None: normal and unknown, estimated by the fit, one number for each
        observed quantity, common to all records; "own": one number of this record alone. With more
        than one series, a list has one of these for each.
    observed : int, list of int, array, or callable
        What the values are values of: components of the state, by number, or by name with a system;
        or the rows of a matrix (n_series, n) times the state; or ``observed(t, y, *args)``, a
        number or n_series numbers, with the arguments of the function. By default the whole state.
    t0 : float or Free, optional
        Time of `y0`, not after the first value; by default the time of the first value.
    name : str, optional
        In pictures and tables.

    Raises
    ------
    ValueError, TypeError
        For shapes that do not fit, and values that make no sense.
    """

    @shown_when_wrong()
    def __init__(
        self, t, values, y0=None, args=(), noise=None, observed=None, t0=None, name=None
    ):  # fmt: skip
        self._given = t, values, y0, args, noise, observed, t0, name
        self.t = _floats(t, "t")
        if self.t.ndim != 1 or not self.t.size or not np.isfinite(self.t).all():
            raise ValueError(f"`t` must be finite times, shape (n_times,); got {t!r}.")
        self.values = np.atleast_2d(_floats(values, "values"))
        if self.values.ndim != 2 or self.values.shape[1] != len(self.t):
            turned = self.values.ndim == 2 and len(self.values) == len(self.t)
            raise ValueError(
                f"`values` must have shape (n_series, {len(self.t)}), a column for each time; got "
                f"{np.shape(values)}{': give values.T.' if turned else '.'}"
            )
        self.there = ~np.isnan(self.values)
        if np.isinf(self.values).any():
            raise ValueError("`values` must be finite, or nan where a value is missing.")
        if not self.there.any():
            raise ValueError("A Record needs values: all of `values` are nan.")
        self.data = [row[there] for row, there in zip(self.values, self.there, strict=True)]
        ends = np.cumsum([0, *map(len, self.data)])
        self.series = list(map(slice, ends[:-1], ends[1:]))
        self.args: Any = args if isinstance(args, tuple | dict) else _tuple(args)
        first = float(self.t.min())
        self.t0 = first if t0 is None else t0 if _is_number_free(t0) else _time(t0)
        self.began = t0 is not None
        begin = float(self.t0.start) if isinstance(self.t0, Free) else self.t0
        if begin > first:
            raise ValueError(f"`t0` = {begin:g} is after the first time, {first:g}.")
        if begin == self.t.max():
            raise ValueError("A Record needs a time after `t0`: the state at `t0` is `y0`.")
        if name is not None and not isinstance(name, str):
            raise TypeError(f"`name` of a Record must be text; got {name!r}.")
        self.name = name
        self.times, order = np.unique(self.t, return_inverse=True)
        rows, columns = np.nonzero(self.there)
        self.places = rows, order[columns]
        self.y0: Any = None if y0 is None else _state(y0)
        if self.y0 is not None:
            self.observation = self._observation(observed)
            groups = self.observation.groups(len(self.values))
            self.noise = noise_of(noise, self.values, groups, self)

    def of(self, system):
        """The Record with the start and the parameters of a system where it has none of its own."""
        t, values, y0, args, noise, observed, t0, name = self._given
        fields = [field.name for field in system.parameter_fields()]
        if isinstance(args, dict):
            for key in args:
                if key not in fields:
                    raise ValueError(
                        f"The {system.name} has no parameter {key!r}; choose from {fields}."
                    )
            args = tuple([args.get(f, own) for f, own in zip(fields, system.args, strict=True)])
        if y0 is None:
            y0 = _start_of(system, fields, args)
        states = [s.name for s in system.states]
        if isinstance(observed, str) or (
            isinstance(observed, list | tuple) and any(isinstance(o, str) for o in observed)
        ):
            named = [observed] if isinstance(observed, str) else observed
            unknown = [one for one in named if one not in states]
            if unknown:
                raise ValueError(
                    f"The {system.name} has no component {unknown[0]!r}; choose from {states}."
                )
            observed = [states.index(one) for one in named]
        return Record(t, values, y0, args or system.args, noise, observed, t0, name)

    def __repr__(self):
        n, m = self.values.shape
        missing = int((~self.there).sum())
        held = [f"{n} series of {m} values from t = {self.t.min():g} to {self.t.max():g}"]
        held += [f"{missing} missing"] if missing else []
        held += ["y0 of the system" if self.y0 is None else f"y0 at t0 = {_shown(self.t0)}"]
        return f"Record({f'{self.name!r}: ' if self.name else ''}{', '.join(held)})"

    def residuals(self, model):
        """(residuals, slopes by the model, roots of Fisher's information) of the values there.

        `model` has what is observed at the increasing `times`, shape (n_series, n_times).
        """
        here = model[self.places]
        found = np.empty((3, len(self.places[0])))
        for noise, data, series in zip(self.noise, self.data, self.series, strict=True):
            own = noise.residuals(here[series], data)
            found[0, series], found[1, series], found[2, series] = own
        return found

    def _observation(self, observed):
        n = len(self.y0.start if isinstance(self.y0, Free) else self.y0)
        if callable(observed):
            return ObservingFunction(observed, len(self.values), n)
        found = Linear(observed, n)
        if len(found.matrix) != len(self.values):
            said = "the state has" if observed is None else "`observed` names"
            raise ValueError(
                f"`values` has {len(self.values)} series, and {said} {len(found.matrix)}: "
                "`observed` tells which components were measured."
            )
        return found


def _start_of(system, fields, args):
    """The initial state of a system; ValueError if it moves with a parameter that is sought."""
    y0 = system.initial_state()
    for field, value in zip(fields, args, strict=False):
        if not isinstance(value, Free) or value.start.ndim:
            continue
        own = getattr(system, field)
        moved = dataclasses.replace(system, **{field: own * MOVED if own else MOVED})
        if not np.array_equal(moved.initial_state(), y0):
            raise ValueError(
                f"The start of the {system.name} depends on `{field}`, which is sought: give `y0`."
            )
    return y0


def _is_number_free(value):
    return isinstance(value, Free) and not value.start.ndim


def _shown(t0):
    return repr(t0) if isinstance(t0, Free) else f"{t0:g}"


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
    if isinstance(args, str | set):
        kinds.refuse("args", f"a tuple, args=({args!r},)", args)
    try:
        return tuple(args)
    except TypeError:
        raise TypeError(f"`args` must be a tuple, such as (x,); got {args!r}.") from None
