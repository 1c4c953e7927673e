"""The results of the trajectories of an ensemble, one row each."""

import math

import numpy as np

from fastdyn.kernels.ensemble.arguments import COUNTED
from fastdyn.kernels.state.record import INTERRUPTED


class Results:
    """Arrays that the workers fill, one row for each member.

    Parameters
    ----------
    n_members, n, n_times, n_events : int
    extrema : bool
        Find the largest and smallest values.
    keep_found : bool
        Keep every event, not only the time of the first.
    n_folds : int
    """

    ROWS = ("y_eval", "y_end", "t_end", "h_end", "status", "counts", "best", "t_first", "folded")

    def __init__(self, n_members, n, n_times, n_events, extrema, keep_found, n_folds=0):
        self.extrema = extrema
        self.keep_found = keep_found
        self.queue = np.array([0, n_members])
        self.y_eval = np.full((n_members, n_times, n), math.nan)
        self.y_end = np.full((n_members, n), math.nan)
        self.t_end = np.full(n_members, math.nan)
        self.status = np.full(n_members, INTERRUPTED)
        self.h_end = np.full(n_members, math.nan)
        self.counts = np.zeros(n_members, COUNTED)
        self.best = np.full((n_members if extrema else 0, 4, n), math.nan)
        self.t_first = np.full((n_members, n_events), math.nan)
        self.folded = np.full((n_members, n_folds), math.nan)
        self.found: list = []
        self.raised: dict[int, str] = {}  # exceptions of functions, in words, by member

    def put(self, start, part):
        """Take over the results of a block of members that begins with member `start`."""
        rows = slice(start, start + len(part.t_end))
        for name in self.ROWS:
            getattr(self, name)[rows] = getattr(part, name)
        self.raised |= {start + i: text for i, text in part.raised.items()}
        self.found += [(where + np.array([start, 0]), t, y) for where, t, y in part.found]

    def states(self, n):
        """The first n components at the times of output, shape (M, n, n_times)."""
        return self.y_eval[:, :, :n].transpose(0, 2, 1)

    def occurrences(self):
        """Pieces of ((member, event), time, state) of the events, one row each."""
        return self.found
