"""Sensitivities behind an event that acts, or a time of a schedule, for F(t, y, y') = 0.

The differential components behind are R(t, y), whose sensitivities follow from the derivatives of R
and of the event's time: see `compile/derivatives/sensitivities.py`.  The equations determine the
others.
"""

import numpy as np

from fastdyn.compile.derivatives.event_times import slopes, time_derivatives
from fastdyn.compile.mode import JUMP
from fastdyn.compile.python_callback import derivative
from fastdyn.compile.traced.make import Near

UNKNOWN = (
    "`sensitivity` needs a function of `on_event`, and an event, that can be traced and "
    "differentiated."
)


class Acting:
    """The function of [y, S, y', S'] for the user's function of y.

    Parameters
    ----------
    tangent : residual.Tangent
    problem : Problem
        Of [y, y'].
    event : callable or None
        Of [y, y']; None for a schedule.
    act : callable
    """

    def __init__(self, tangent, problem, event, act):
        self._tangent = tangent
        self._problem = problem
        self._event = event
        self._act = act

    def __call__(self, t, z, *args):
        tangent = self._tangent
        n = self._tangent.equations.n
        both, columns = tangent.equations.parts(z)
        new = derivative(self._act(t, both[:n].copy(), *args), n, JUMP)
        later = self._later(t, both, columns, args)
        if not (np.isfinite(new).all() and np.isfinite(later).all()):
            return np.full(len(z), np.nan)  # the run ends and says why
        columns = self._behind(t, both, columns[:n] + np.outer(both[n:], later), later, args)
        start = self._problem._replace(t0=t, y0=np.concatenate([new, both[n:]]))
        both = tangent.consistent(t, start)
        columns = columns - np.outer(both[n:], later)
        return tangent.behind(t, both, np.concatenate([columns, np.zeros_like(columns)]))

    def _later(self, t, both, columns, args):
        """The derivatives of the time, (m,)."""
        if self._event is None:
            return np.zeros(columns.shape[1])
        n = self._tangent.equations.n
        directions = self._tangent.equations.directions
        at = np.array([t]), both[:n, None], both[n:, None], columns[:n, :, None]
        found = time_derivatives(self._event, args, self._near(both[:n]), directions, at)
        if found is None:
            raise ValueError(UNKNOWN)
        return found[:, 0]

    def _behind(self, t, both, columns, later, args):
        """The derivatives of R along the directions, by the derivatives `columns` of the state."""
        y = both[: len(columns)]
        directions = self._tangent.equations.directions
        at = np.array([t]), y[:, None]
        rows = slopes(self._act, args, JUMP, self._near(y), directions, *at)
        if rows is None:
            raise ValueError(UNKNOWN)
        found = np.zeros_like(columns)
        for i, row in enumerate(rows):
            for name, slope in row.items():
                if name == "t":
                    found[i] += slope[0] * later
                elif name[0] == "y":
                    found[i] += slope[0] * columns[name[1]]
                else:
                    found[i, name[1]] += slope[0]
        return found

    def _near(self, y):
        return Near(self._problem.t0, self._problem.tf, y)
