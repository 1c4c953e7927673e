"""The continuous solution of a delay equation, with its history."""

import numpy as np

from fastdyn.run.dense_output import PiecewisePolynomial


class DelaySolution(PiecewisePolynomial):
    """The continuous solution of a delay equation; before its start, the history.

    Parameters
    ----------
    sol : PiecewisePolynomial
    history : History
    """

    def __init__(self, sol, history):
        super().__init__(sol.ts, sol.polynomials, sol.spans, sol.floors)
        self._history = history

    def _values(self, times, segments):
        return self._with_history(super()._values(times, segments), times, self._history.before)

    def derivative(self, t):
        """The derivative by t, in the shape of ``sol(t)``; before the start that of the history."""
        times = np.atleast_1d(np.asarray(t, dtype=float))
        found = self._with_history(super().derivative(times), times, self._history.slope)
        return found[:, 0] if np.ndim(t) == 0 else found

    def _with_history(self, found, times, before):
        for k in np.flatnonzero(times < self.t_min):
            found[:, k] = before(float(times[k]))
        return found
