"""OdeResult, the result of a solve."""

from typing import Any

import numpy as np


class OdeResult(dict):
    """A dict with attribute access: SciPy's fields and a few more.

    Attributes
    ----------
    t : ndarray, shape (n_points,)
        Times, in the unit of `t_span`.
    y : ndarray, shape (n, n_points)
        States at these times.
    sol : OdeSolution or None
        The continuous solution, with ``dense_output=True``.
    t_events, y_events : list of ndarray or None
        For each event, its times (k,) and the states there (k, n).
    nfev, njev, nlu : int
        Numbers of evaluations of `fun`, of Jacobians, of factorisations.
    status : int
        0: the end was reached; 1: a terminal event; -1: failure; -2: interrupted.
    message : str
        The reason of the end, in a sentence.
    success : bool
        True if `status` is 0 or 1.
    n_accepted, n_rejected : int
        Numbers of steps (compiled methods only).
    """

    t: np.ndarray
    y: np.ndarray
    sol: Any
    t_events: Any
    y_events: Any
    nfev: int
    njev: int
    nlu: int
    status: int
    message: str
    success: bool
    n_accepted: int
    n_rejected: int

    def __getattr__(self, name) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None

    __setattr__: Any = dict.__setitem__
    __delattr__: Any = dict.__delitem__

    def __dir__(self):
        return [*super().__dir__(), *self]

    def __repr__(self):
        width = max(map(len, self), default=0)
        lines = []
        for name, value in self.items():
            text = repr(value).replace("\n", "\n" + " " * (width + 2))
            lines.append(f"{name:>{width}}: {text}")
        return "\n".join(lines)

    def plot(self, **options) -> Any:
        """Draw the components over time; the result of a system draws the figure of the system.

        Parameters
        ----------
        **options
            Options of `fastdyn.plot.solution.plot`, or of the figure of the system.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from fastdyn.plot.solution import plot

        return plot(self, **options)
