"""Trajectories, the result of solve_ensemble."""

import functools
from typing import Any

import numpy as np

from fastdyn.kernels.ensemble.arguments import COUNTED
from fastdyn.kernels.methods.method import ON_PAIRS
from fastdyn.plot.displayed import display
from fastdyn.problem.options.docstrings import filled
from fastdyn.problem.schedules import in_order
from fastdyn.run.result import FOLLOWING, Ended, following, made
from fastdyn.words.kinds import noted
from fastdyn.words.near import did_you_mean

from . import reductions
from .labels import argument_labels, component_labels, initial_labels
from .status import CODES, message

OF_STEPS = [name for name in Ended._fields if name in COUNTED.names]


class Trajectories:
    """Many solved trajectories; ``result[i]`` is trajectory i as an OdeResult.

    Attributes
    ----------
    t : ndarray, shape (n_times,) or (M,)
        The times of `t_eval`, or the end time of each trajectory.
    y : ndarray, shape (M, n, n_times) or (M, n)
        States at these times; NaN after the end of a trajectory.
    y_end, t_end : ndarray, shape (M, n), (M,)
        Last states, and their times.
    status : ndarray of int, shape (M,)
        0: the end was reached; 1: a terminal event; -1: failure; -2: interrupted; -3: the border
        of `domain`.
    success : ndarray of bool, shape (M,)
    nfev, n_accepted, n_rejected : ndarray of int, shape (M,)
    t_events, y_events : list of lists of ndarray, or None
        By event, then by trajectory.
    reduced : dict of str to ndarray
        The reductions, each of shape (M, n), (M, n_events) for "first_event", or (M,) for a Fold.
    width : int
        Trajectories in a vector; 1 if each trajectory ran alone.
    reason : str
        The reason why each trajectory ran alone, or why events and folds were evaluated for each
        trajectory alone.
    y0 : ndarray, shape (M, n) or (1, n)
        Initial states; one row if all trajectories share one initial state.
    t_start, method, first : float, str, tuple
        The start, the name of the method, and the arguments of the first trajectory.
    parameters : dict of int to ndarray
        The arguments that differ from one trajectory to the next, by position.
    initial_conditions : dict of str to ndarray
        The initial conditions of the system that differ, by name.
    system : System or None
        The system, if a system was solved.
    """

    system: Any = None

    def __init__(self, problem, members, results, width, reason, wanted=()):
        self._problem = problem
        self._members = members
        self._results = results
        self.width = width
        self.reason = reason
        self.reductions = wanted
        self.parameters = members.varying
        self.first = members.first
        self.initial_conditions: dict[str, np.ndarray] = {}
        self.method = problem.method.name.removesuffix(ON_PAIRS)
        self.t_start = problem.t0
        self.t_end = results.t_end
        self.t = self.t_end if problem.t_eval is None else problem.t_eval
        self._n = members.n // reductions.n_copies(wanted)  # components without the moments

    def __len__(self):
        return self._members.count

    @property
    def y0(self):
        return self._components(self._members.y0[:, : self._n])

    def _components(self, numbers):
        """Numbers in rows as components of states."""
        if not self._members.complex:
            return numbers
        return np.ascontiguousarray(numbers).view(complex)

    @property
    def y_end(self):
        return self._components(self._results.y_end[:, : self._n])

    @property
    def y(self):
        if self._problem.t_eval is None:
            return self.y_end
        if self._members.complex:
            return self._components(self._results.y_eval).transpose(0, 2, 1)
        return self._results.states(self._n)

    def following(self, names=FOLLOWING):
        """The fields that follow from counts and ends, arrays of shape (M,) by their names."""
        results = self._results
        counts = {name: results.counts[name] for name in OF_STEPS}
        ended = Ended(**counts, h=results.h_end)
        found = following(self._problem.method, ended, names)
        return {name: numbers for name, numbers in found.items() if numbers is not None}

    def __getattr__(self, name) -> Any:
        if name in FOLLOWING:
            found = self.following((name,))
            if name in found:
                return found[name]
        known = [each for each in (*dir(self), *FOLLOWING) if each[0] != "_"]
        said = "" if name.startswith("_") else did_you_mean(name, known)
        raise AttributeError(
            f"{type(self).__name__!r} has no attribute {name!r}{f'; {said}' if said else ''}"
        )

    @property
    def event_names(self):
        """Names of the event functions."""
        p = self._problem
        names = [event.name for event in p.events or ()]
        names = in_order(names, p.schedules, ["schedule"] * len(p.schedules))
        return [name or f"event {i}" for i, name in enumerate(names)]

    @property
    def status(self):
        status = np.full(len(self), -1)
        for code, ours in CODES.items():
            status[self._results.status == code] = ours
        return status

    def ends_with(self, code):
        """Which trajectories ended with this code of the kernels."""
        return self._results.status == code

    @property
    def success(self):
        return self.status >= 0

    @functools.cached_property
    def reduced(self):
        """The reductions, by name."""
        return {
            reductions.name_of(item): reductions.value(item, self._results, self)
            for item in self.reductions
        }

    @property
    def labels(self):
        """Name and unit of each component of the state."""
        return component_labels(self.system, self.y0.shape[1])

    @property
    def argument_labels(self):
        """Name and unit of each argument after t and y."""
        return argument_labels(self._problem.fun, self.first, self.system)

    def varied(self):
        """(label, values) of the arguments, fields and initial states that differ."""
        fields = [(self.argument_labels[j], c) for j, c in self.parameters.items()]
        for label in initial_labels(self.system):
            if label.name in self.initial_conditions:
                fields.append((label, self.initial_conditions[label.name]))
        differ = np.flatnonzero((self.y0 != self.y0[:1]).any(axis=0))
        starts = [label._replace(name=f"{label.name} at the start") for label in self.labels]
        return fields, [(starts[i], self.y0[:, i]) for i in differ]

    @staticmethod
    def is_time(name):
        """True if a reduction is a time."""
        return name in ("max_time", "min_time", "first_event")

    def to_pandas(self):
        """A pandas.DataFrame: a row for each trajectory, with `t_eval` for each of its times.

        Values that vary are columns, then components, or components at the end, and ``status``.
        The index is the trajectory, or trajectory and time.
        """
        from .to_pandas import frame

        return frame(self)

    def to_xarray(self):
        """An xarray.Dataset with dimensions trajectory, component and time.

        Values that vary are coordinates, named as in the function's signature, or as in the system,
        with units.  Arrays in a store are read when they are used.
        """
        from .to_xarray import dataset

        return dataset(self)

    @filled()
    def plot(self, of=None, over=None, components=None, **options):
        """Draw the ensemble.

        Parameters
        ----------
        of : str or list of str, optional
            "y": median and quantiles of the states against time; "y_end" or names in `reduced`: one
            value for each trajectory.  By default all reductions, otherwise "y", otherwise "y_end".
        over : str or list of str, optional
            Parameters to draw over: a line over one, a map over two, otherwise histograms.  By
            default the parameters that vary; ``over=[]`` draws histograms.
        components : name, int or list of them, optional
            Components of the state; by default the first eight.
        {figure}
        """
        from fastdyn.plot.ensemble import figure

        if self._members.complex:
            raise ValueError("complex states have no figure; draw `abs(result.y)`, for example.")
        return figure(self, of, over, components, **options)

    def _number(self, i):
        try:
            return range(len(self))[i]
        except IndexError as error:
            raise noted(error, f"The trajectories are 0 to {len(self) - 1}; got {i}.") from None

    def message(self, i):
        """The reason why trajectory i ended, in a sentence."""
        i = self._number(i)
        return message(self._members, self._problem, self._results, i)

    @functools.cached_property
    def _occurrences(self):
        """(t, y) of each event, arrays for each trajectory; y has all integrated components."""
        found = self._results.occurrences()
        n = self._members.n
        p = self._problem
        where = np.concatenate([w for w, _, _ in found] or [np.empty((0, 2), int)])
        t = np.concatenate([t for _, t, _ in found] or [np.empty(0)])
        y = np.concatenate([y for _, _, y in found] or [np.empty((0, n))])
        times = []
        states = []
        n_functions = len(p.events)
        behind = range(n_functions, n_functions + len(p.schedules))
        for k in in_order(range(n_functions), p.schedules, behind):
            mine = where[:, 1] == k
            order = np.argsort(where[mine, 0], kind="stable")
            ends = np.searchsorted(where[mine, 0][order], np.arange(1, len(self)))
            times.append(np.split(t[mine][order], ends))
            states.append(np.split(y[mine][order], ends))
        return times, states

    def _parts_at_events(self, part):
        """A part of the states at each event, a slice of their components."""
        if self._problem.events is None:
            return None
        return [[self._components(y[:, part]) for y in each] for each in self._occurrences[1]]

    @property
    def t_events(self):
        return None if self._problem.events is None else self._occurrences[0]

    @functools.cached_property
    def y_events(self):
        return self._parts_at_events(slice(self._n))

    def __getitem__(self, i):
        if isinstance(i, str):
            raise TypeError(f"trajectories are numbered: ensemble[0][{i!r}], or ensemble.y.")
        i = self._number(i)
        n = int(self._results.counts["n_times"][i])
        if self._problem.t_eval is None:
            t = self.t_end[i : i + 1]
            y = self.y_end[i][:, None]
        else:
            t = self.t[:n]
            y = self.y[i, :, :n]
        of_matrices = None if self._problem.method.n_matrices else 0
        counts = {name: int(self._results.counts[name][i]) for name in OF_STEPS}
        h = float(self._results.h_end[i])
        ended = Ended(**counts, h=h, n_jacobians=of_matrices, n_factorised=of_matrices)
        return made(
            self._problem.method, ended, t=t, y=y,
            t_events=self.t_events and [times[i] for times in self.t_events],
            y_events=self.y_events and [states[i] for states in self.y_events],
            status=int(self.status[i]), message=self.message(i),
        )  # fmt: skip

    def _repr_html_(self):
        return display(self)

    def __repr__(self):
        failed = int((~self.success).sum())
        lanes = f"{self.width} lanes" if self.width > 1 else f"one by one: {self.reason}"
        return (
            f"Trajectories({len(self)} of {self.y0.shape[1]} components, "
            f"{self.method}, {failed} failed, {lanes})"
        )
