"""The result of a system's solve: the run, with invariants, errors and figures."""

from typing import Any

import numpy as np

from fastdyn.problem.options.table import refused_by
from fastdyn.run.result import NoField, OdeResult

WATCHING = {"t_eval", "dense_output", *refused_by("repetition")}
MANY = 200_000  # points, between which a curve needs no others


def asked(result, t_span, y0, method, project, options):
    """The arguments by which `System.solve` repeats a run up to its end, or None.

    Options of output, and events that only watch, are left out.
    """
    if len(result.t) < 2 or len(result.t) > MANY:
        return None
    again = {name: one for name, one in options.items() if name not in WATCHING}
    if again.get("on_event") is None:
        again.pop("events", None)
    span = float(t_span[0]), float(result.t[-1])
    return {"t_span": span, "y0": y0, "method": method, "project": project} | again


class SystemResult(OdeResult):
    """
    The OdeResult of a system, with SciPy's fields.

    Attributes
    ----------
    system : System
        The system that was solved.
    """

    system: Any
    _asked: Any

    def __init__(self, result, system, asked=None):
        super().__init__(result)
        object.__setattr__(self, "system", system)  # beside SciPy's fields, not among them
        object.__setattr__(self, "_asked", asked)

    def __missing__(self, name):
        """The component, or the quantity or invariant, of this name along the run, (n_points,).

        SciPy's fields come first: of a system with a coordinate ``y``, ``run["y"]`` has all states.
        """
        system: Any = self.__dict__.get("system")  # a copy is asked for names before it has one
        if system is None:
            return super().__missing__(name)
        names = [state.name for state in system.states]
        if name in names:
            return system.columns(self.y)[names.index(name)]
        functions = system.quantities | system.invariants
        if name in functions:
            return self._along({name: functions[name]})[name]
        raise NoField(name, (*names, *functions, *self))

    def _components(self):
        return list(map(tuple, self.system.states))

    def continuous(self):
        """
        The solution as a function of time, shape (n,) or (n, k): for curves between the steps.

        `sol` if the solve had a dense output; otherwise the problem is solved once more, with a
        dense output. None if the arguments of the solve are unknown.
        """
        if self.sol is None and isinstance(self._asked, dict):
            again = self.system.solve(**self._asked, dense_output=True)
            object.__setattr__(self, "_asked", again.sol)
        return self._asked if self.sol is None else self.sol

    def error(self) -> np.ndarray:
        """
        Computed minus exact state, shape (n, n_points).

        Raises
        ------
        ValueError
            If no exact solution is known, or the run has another start.
        """
        return self.system.columns(self.y) - self.system.exact_along(self.t)

    def invariants(self) -> dict[str, np.ndarray]:
        """Values of the invariants along the run, each of shape (n_points,), by name."""
        return self._along(self.system.invariants)

    def quantities(self) -> dict[str, np.ndarray]:
        """Reactions and other quantities along the run, each of shape (n_points,), by name."""
        return self._along(self.system.quantities)

    def residuals(self) -> dict[str, np.ndarray]:
        """Residuals of the constraints along the run, each of shape (n_points,), by name."""
        return self._along(self.system.constraints)

    def animate(self, path=None, **options):
        """Write the motion to a file, or show it; see `fastdyn.plot.animate.animate`."""
        from fastdyn.plot.animate import animate

        return animate(self, path, **options)

    def _along(self, functions):
        along = self.system.along
        return {name: along(function, self.t, self.y) for name, function in functions.items()}
