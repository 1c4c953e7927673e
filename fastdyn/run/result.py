"""What a solve returns: OdeResult, OdeSolution, and the sentences for each status."""

from typing import Any

import numpy as np


class OdeResult(dict):
    """A dict with attribute access, with SciPy's fields and a few more.

    Attributes
    ----------
    t : ndarray, shape (n_points,)
    y : ndarray, shape (n, n_points)
    sol : OdeSolution or None
    t_events, y_events : list of ndarray or None
    nfev, njev, nlu : int
    status : int
        0 the end was reached, 1 a terminal event, -1 failure, -2 interrupted.
    message : str
    success : bool
    n_accepted, n_rejected : int
        Steps (of our methods).
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

    def __setattr__(self, name, value):
        self[name] = value

    def __delattr__(self, name):
        del self[name]

    def __dir__(self):
        return [*super().__dir__(), *self]

    def __repr__(self):
        width = max(map(len, self), default=0)
        lines = []
        for name, value in self.items():
            text = repr(value).replace("\n", "\n" + " " * (width + 2))
            lines.append(f"{name:>{width}}: {text}")
        return "\n".join(lines)

    def plot(self, **options):
        """Draw the components against time; of a system, its figure."""
        from fastdyn.plot.solution import plot

        return plot(self, **options)
