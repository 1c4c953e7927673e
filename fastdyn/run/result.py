"""What a solve returns: OdeResult, OdeSolution, and the sentences for each status."""

from typing import Any


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
    system : System or None
        The system that was solved, if one was.
    """

    system: Any = None

    def __getattr__(self, name):
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None

    def __setattr__(self, name, value):
        if name == "system":
            object.__setattr__(self, name, value)
        else:
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
        """Draw the solution: the system's figure, or the components against time."""
        from fastdyn.plot.solution import plot

        return plot(self, **options)

    def animate(self, path, **options):
        """Write the motion of the system to a .gif or .html file; see `plot.animate`."""
        from fastdyn.plot.animate import animate

        animate(self, path, **options)

    def invariants(self):
        """Invariants of the system along the solution, {name: array}."""
        return self._system().evaluate_invariants(self.t, self.y)

    def residuals(self):
        """Residuals of the system's constraints along the solution, {name: array}."""
        return self._system().evaluate_constraints(self.t, self.y)

    def error(self):
        """Difference from the exact solution, shape (n, n_points)."""
        return self._system().error(self)

    def _system(self):
        if self.system is None:
            raise ValueError("this result is not of a System; solve with `System.solve`.")
        return self.system
