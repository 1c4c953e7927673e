"""The result of an ensemble of equations whose index is reduced: y and y' from reduced states."""

import functools
from typing import Any, NamedTuple

import numpy as np

from fastdyn.kernels.state.record import SINGULAR
from fastdyn.run.result import OdeResult

from ..reduced.compare import check_with_function
from ..reduced.solve import solve_reduced
from ..reduced.trajectory import MANY, components
from .trajectories import DaeTrajectories

FEW = 4  # trajectories that are compared with F


class Solved(NamedTuple):
    """A solved ensemble of reduced equations.

    Attributes
    ----------
    asked : problem.DaeArguments
        Of a trajectory.
    method : str
    guesses : Guesses
    reduction : Reduction
    values : ndarray, shape (n_slots, M)
        The parameters of the reduction, by slot.
    starts : ndarray, shape (M or 1, ...)
        All orders of all components at the starts.
    guarded : bool
        Whether the last component of a state is the mark of a `Guard`.
    """

    asked: Any
    method: str
    guesses: Any
    reduction: Any
    values: np.ndarray
    starts: np.ndarray
    guarded: bool


class OfReduced(DaeTrajectories):
    """Trajectories whose integrated states are reduced.

    Attributes
    ----------
    differentiated : ndarray of int
        How often each equation was differentiated.
    """

    def __init__(self, solved, *given):
        super().__init__(*given)
        self._solved = solved
        self.differentiated = solved.reduction.differentiated
        self.parameters = solved.guesses.varying
        self.first = solved.guesses.first
        self._alone: dict[int, OdeResult] = {}  # trajectories that pass a singularity

    @property
    def y0(self):
        s = self._solved
        n = s.asked.n
        given = s.reduction.system.given
        at = [given.place(k) for k in range(n)]
        return s.starts[:, [order * n + column for column, order in at]]

    def settle(self):
        """Solve the trajectories alone that may pass a singularity; compare others with F."""
        s = self._solved
        r = self._results
        if s.guarded:
            for i in np.flatnonzero(r.y_end[:, -1] > 0.0).tolist():
                self._settle(i)
        good = np.flatnonzero(self.success)
        chosen = np.unique(np.linspace(0, len(good) - 1, FEW).astype(int)) if len(good) else []
        for i in good[chosen].tolist() if len(good) else ():
            check_with_function(s.asked.F, s.guesses.args(i), self[i])

    def _settle(self, i):
        s = self._solved
        r = self._results
        y0, yp0 = np.split(s.guesses.state(i), 2)
        asked = s.asked._replace(y0=y0, yp0=yp0, args=s.guesses.args(i), t_eval=None)
        found = solve_reduced(asked, s.method)
        if found.success:
            return
        self._alone[i], end = found, float(found.t[-1])
        r.status[i] = SINGULAR
        r.t_end[i] = end
        if self._problem.t_eval is not None:
            sign = 1.0 if asked.tf >= asked.t0 else -1.0
            n_times = int(np.sum(sign * self._problem.t_eval <= sign * end))
            r.counts["n_times"][i] = n_times
            r.y_eval[i, n_times:] = np.nan

    def message(self, i):
        i = range(len(self))[i]
        return self._alone[i].message if i in self._alone else super().message(i)

    def _at(self, members, t, x, rates):
        """Components of y, (k, n), or their derivatives, at k states x of some members."""
        system = self._solved.reduction.system
        n = len(self._solved.reduction.system.states)
        found = np.full((len(t), self._solved.asked.n), np.nan)
        there = np.flatnonzero(np.isfinite(x).all(axis=1))
        for k in range(0, len(there), MANY):
            part = there[k : k + MANY]
            values = self._solved.values[:, members[part]]
            own = system.with_values(values)
            found[part] = components(own, t[part], x[part, :n].T, True, rates).T
        return found

    def _end(self, rates):
        found = self._at(np.arange(len(self)), self.t_end, self._results.y_end, rates)
        for i, alone in self._alone.items():
            found[i] = alone["yp" if rates else "y"][:, -1]
        return found

    def _all(self, rates):
        x = self._results.y_eval
        m, n_times = x.shape[:2]
        members = np.repeat(np.arange(m), n_times)
        t = np.tile(self._problem.t_eval, m)
        found = self._at(members, t, x.reshape(m * n_times, -1), rates)
        return found.reshape(m, n_times, -1).transpose(0, 2, 1)

    @functools.cached_property
    def _ends(self):
        return self._end(False), self._end(True)

    @functools.cached_property
    def _outputs(self):
        return self._ends if self._problem.t_eval is None else (self._all(False), self._all(True))

    @property
    def y_end(self):
        return self._ends[0]

    @property
    def yp_end(self):
        return self._ends[1]

    @property
    def y(self):
        return self._outputs[0]

    @property
    def yp(self):
        return self._outputs[1]

    @functools.cached_property
    def y_events(self):
        if self._problem.events is None:
            return None
        found = []
        for times, states in zip(*self._occurrences, strict=True):
            counts = [len(each) for each in times]
            members = np.repeat(np.arange(len(self)), counts)
            y = self._at(members, np.concatenate(times), np.concatenate(states), False)
            found.append(np.split(y, np.cumsum(counts)[:-1]))
        return found

    def __getitem__(self, i):
        found = super().__getitem__(i)
        found["differentiated"] = self.differentiated
        return found
