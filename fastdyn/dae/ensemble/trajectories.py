"""The result of an ensemble of DAEs: y and y' of each trajectory."""

import dataclasses
import functools
from typing import Any

from fastdyn.ensemble.labels import Label, argument_names
from fastdyn.ensemble.trajectories import Trajectories
from fastdyn.kernels.state.record import BAD_STATE

from ..result import SENTENCES


@dataclasses.dataclass(frozen=True)
class KnownOfEnsemble:
    """Facts about an ensemble of DAEs that are known before the solve.

    `failed` has the sentences of the trajectories without a consistent start, by number.
    """

    F: Any
    index: int
    failed: dict


class DaeTrajectories(Trajectories):
    """Trajectories of F(t, y, y') = 0; ``result[i]`` is that of `solve_dae`, without steps.

    Attributes
    ----------
    index : int
        The index of the equations, at the first trajectory with a consistent start.
    yp : ndarray, shape (M, n, n_times) or (M, n)
        Derivatives at the times of `t`; nan where the equations have none.
    yp_end : ndarray, shape (M, n)
        Derivatives at the last states.
    y0 : ndarray, shape (M, n) or (1, n)
        Consistent starts; nan for a trajectory without one.
    """

    yp: Any
    yp_end: Any

    def __init__(self, facts, *given):
        super().__init__(*given)
        self._facts = facts
        self.index = facts.index

    @property
    def argument_labels(self):
        facts = self._facts
        first = self.first
        names = [label.name for label in argument_names(facts.F, first)][1:]  # behind yp
        names += [f"args[{j}]" for j in range(len(names), len(first))]
        return [Label(name) for name in names[: len(first)]]

    def message(self, i):
        """The reason why trajectory i ended, in a sentence."""
        i = range(len(self))[i]
        status = int(self._results.status[i])
        if status == BAD_STATE and i in self._facts.failed:
            return f"Trajectory {i} has no start: {self._facts.failed[i]}."
        if status in SENTENCES:
            return SENTENCES[status].format(t=self.t_end[i])
        return super().message(i)

    def __getitem__(self, i):
        found = super().__getitem__(i)
        i = range(len(self))[i]
        rates = self.yp[i]
        found["yp"] = rates[:, None] if rates.ndim == 1 else rates[:, : len(found.t)]
        found["index"] = self.index
        return found

    def to_xarray(self):
        """The Dataset of `Trajectories.to_xarray`, with the derivatives."""
        axes = ("trajectory", "component", "time")[: self.yp.ndim]
        values = {"yp": (axes, self.yp), "yp_end": (axes[:2], self.yp_end)}
        return super().to_xarray().assign(values).assign_attrs(index=self.index)


class OfResiduals(DaeTrajectories):
    """Trajectories whose integrated state is [y, y'].

    Attributes
    ----------
    yp_events : list of lists of ndarray, or None
        By event, then by trajectory.
    """

    def __init__(self, *given):
        super().__init__(*given)
        self.method = "BDF"
        self._n //= 2

    @property
    def yp_end(self):
        return self._results.y_end[:, self._n :]

    @property
    def yp(self):
        if self._problem.t_eval is None:
            return self.yp_end
        return self._results.states(2 * self._n)[:, self._n :]

    @functools.cached_property
    def yp_events(self):
        return self._parts_at_events(slice(self._n, None))

    def __getitem__(self, i):
        found = super().__getitem__(i)
        i = range(len(self))[i]
        found["yp_events"] = self.yp_events and [each[i] for each in self.yp_events]
        return found
