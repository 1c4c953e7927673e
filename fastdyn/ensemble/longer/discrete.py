"""Ensembles with `discrete`: the longer states of all trajectories, and the parts of the result."""

import functools

import numpy as np

from fastdyn.problem.discrete import joined_rows, longer
from fastdyn.problem.validate import initial_state

from ..trajectories import Trajectories


def with_discrete(asked):
    """The Arguments of an ensemble with longer states, and the number m of discrete states.

    `asked` has all initial states as `y0`, unchecked.

    Raises
    ------
    ValueError, TypeError
    """
    try:
        states = np.asarray(asked.y0)
        numbers = np.asarray(asked.discrete)
    except ValueError:
        raise ValueError("`y0` and `discrete` must have rows of one length.") from None
    of_one = [each[0] if each.ndim == 2 and len(each) else each for each in (states, numbers)]
    if np.issubdtype(of_one[0].dtype, np.floating):
        of_one[0] = np.where(np.isfinite(of_one[0]), of_one[0], 0.0)  # this trajectory fails alone
    of_one[0] = initial_state(of_one[0])
    extended, n = longer(asked._replace(y0=of_one[0], discrete=of_one[1]))
    m = len(extended.y0) - n
    return extended._replace(y0=joined_rows(states, numbers, n, m)), m


class HybridTrajectories(Trajectories):
    """Trajectories with `discrete` states.

    Attributes
    ----------
    discrete : ndarray, shape (M, m, n_times) or (M, m)
        Discrete states at the times of `t`.
    discrete_end : ndarray, shape (M, m)
        The last discrete states.
    discrete_events : list of lists of ndarray
        By event, then by trajectory.
    """

    def __init__(self, n_discrete, *given):
        super().__init__(*given)
        self._n -= n_discrete

    @property
    def discrete_end(self):
        return self._results.y_end[:, self._n :]

    @property
    def discrete(self):
        if self._problem.t_eval is None:
            return self.discrete_end
        return self._results.states(self._members.n)[:, self._n :]

    @functools.cached_property
    def discrete_events(self):
        return self._parts_at_events(slice(self._n, None))

    def __getitem__(self, i):
        found = super().__getitem__(i)
        i = range(len(self))[i]
        numbers = self.discrete[i]
        found.discrete = numbers[:, None] if numbers.ndim == 1 else numbers[:, : len(found.t)]
        found.discrete_events = [each[i] for each in self.discrete_events or ()]
        return found

    def to_xarray(self):
        """The Dataset of `Trajectories.to_xarray`, with the discrete states."""
        axes = ("trajectory", "number", "time")[: self.discrete.ndim]
        values = {"discrete": (axes, self.discrete), "discrete_end": (axes[:2], self.discrete_end)}
        return super().to_xarray().assign(values)
