"""What a mechanical system is: equations, parameters, invariants, exact solution, figure.

A new system is one file in the folder `systems`: a frozen dataclass that inherits from `System`,
whose fields are its parameters and initial conditions. Nothing else has to be told about it;
`fastdyn list`, `fastdyn run`, `fastdyn tour` and the tests find it by what it defines.
"""

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar

import numpy as np

from fastdyn.problem.validate import method_named
from fastdyn.solve.ivp import solve_ivp

from .consistent_start import start_of
from .declare import State, checked


def _short(value):
    """A parameter as a few words; nothing for None."""
    if value is None:
        return ""
    if isinstance(value, np.ndarray):
        return f"array{value.shape}"
    return getattr(value, "__name__", None) or f"{value!r}"


@dataclasses.dataclass(frozen=True)
class System:
    """
    One system of the course; subclasses fill in the class attributes and methods below.

    Attributes
    ----------
    name, title : str
        The name under which the registry knows the system, and a heading.
    source : str
        Chapter of the course that gives the equations and the defaults.
    states : tuple of State
        The components of the state, in order.
    t_end : float
        Default end of the run, in seconds; runs start at t = 0.
    rhs : callable
        Plain function ``rhs(t, y, *parameters)``; unpacks y, returns a list.
    invariants : dict of str to callable
        Functions of ``(t, y, *parameters)`` that the exact motion keeps constant. They see one
        state of shape (n,) when compiled, or all columns at once, shape (n, n_points), in Python.
    quantities : dict of str to callable
        Other functions of the same form: reactions, distances, angles.
    events : dict of str to callable
        Event functions by name, in SciPy's form with ``terminal`` and ``direction``.
    derived : dict of str to str
        Answers that follow from the parameters alone, properties of the class, and their units.
    constraints : dict of str to callable
        Functions of the same form that are zero where the constraints hold: their residuals.
    project : callable
        ``project(t, y, *parameters)`` takes a state to the nearest one on its constraints; only
        where there are any.

    Notes
    -----
    All parameters, in the order of the fields, are passed to every one of these functions, so
    that changing a value never recompiles anything. Fields declared by `initial` set the initial
    state and are passed to none of them.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    source: ClassVar[str]
    states: ClassVar[tuple[State, ...]]
    t_end: ClassVar[float]
    rhs: ClassVar[Callable]
    invariants: ClassVar[Mapping[str, Callable]] = {}
    quantities: ClassVar[Mapping[str, Callable]] = {}
    events: ClassVar[Mapping[str, Callable]] = {}
    derived: ClassVar[Mapping[str, str]] = {}
    constraints: ClassVar[Mapping[str, Callable]] = {}
    project: ClassVar[Callable]

    def __new__(cls, *values, **named):
        allowed = [field.name for field in dataclasses.fields(cls)]
        unknown = [name for name in named if name not in allowed]
        if unknown:
            raise TypeError(
                f"{cls.name} has no parameter {', '.join(f'`{name}`' for name in unknown)}; "
                f"its parameters are {', '.join(allowed)}."
            )
        return super().__new__(cls)

    def __post_init__(self):
        for field in dataclasses.fields(self):
            value = checked(self.name, field, getattr(self, field.name))
            object.__setattr__(self, field.name, value)

    def __str__(self):
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        parts = [f"{name}={_short(value)}" for name, value in values.items()]
        return f"{self.name}({', '.join(part for part in parts if part[-1] != '=')})"

    @property
    def args(self) -> tuple:
        """Values of the parameters in the order in which the functions take them."""
        return tuple(getattr(self, field.name) for field in self.parameter_fields())

    @classmethod
    def parameter_fields(cls) -> list[dataclasses.Field]:
        """Fields that are arguments of the functions, in their order."""
        return [one for one in dataclasses.fields(cls) if "initial" not in one.metadata]

    @classmethod
    def initial_fields(cls) -> list[dataclasses.Field]:
        """Fields that set the initial state, and are no arguments."""
        return [one for one in dataclasses.fields(cls) if "initial" in one.metadata]

    def initial_state(self) -> tuple[float, ...]:
        """State at t = 0, from the fields."""
        raise NotImplementedError(f"{self.name} does not define its initial state.")

    @property
    def breakpoints(self):
        """Times at which steps must end, ndarray, or None."""
        return None

    def baumgarte(self) -> "System":
        """Itself with Baumgarte's stabilisation of the constraints switched on."""
        raise ValueError(f"The {self.name} has no Baumgarte stabilisation.")

    def exact(self, t) -> np.ndarray:
        """
        Exact solution from the initial state at t = 0.

        Parameters
        ----------
        t : float or array_like, shape (n_points,)
            Times in seconds.

        Returns
        -------
        ndarray, shape (n,) or (n, n_points)

        Raises
        ------
        ValueError
            Where no exact solution is known, for this system or for these parameters.
        """
        raise ValueError(f"No exact solution of the {self.name} is known to fastdyn.")

    def solve(self, t_span=None, y0=None, method="RK45", stabilise=None, **options):
        """
        Integrate the equations of motion; `fastdyn.solve_ivp` with the system filled in.

        Parameters
        ----------
        t_span : pair of float, optional
            Start and end in seconds, (0, `t_end`) unless given.
        y0 : array_like, shape (n,), optional
            Initial state, `initial_state()` unless given.
        method : str
            As for `fastdyn.solve_ivp`.
        stabilise : {None, "projection", "baumgarte"}
            How constraints are held: by the accelerations alone, by taking the state back to them
            at the start and after each step, or by Baumgarte's pull.  A start that violates them
            is warned of, unless it is projected.
        **options
            As for `fastdyn.solve_ivp`, with two differences: `events` may also name events of
            the system (``events="slack"``), and the default tolerances of the adaptive methods
            are rtol = 1e-6 and atol = 1e-9, because SciPy's 1e-3 and 1e-6 let the course's
            satellite fall onto its planet.

        Returns
        -------
        OdeResult
            With `system` set, so that ``plot()``, ``invariants()`` and ``error()`` work.
        """
        if "args" in options:
            raise TypeError(f"`args` of the {self.name} are its parameters; set them by name.")
        if "events" in options:
            options["events"] = self.event_functions(options["events"])
        ours = method_named(method)
        if ours is None or ours.error_order:
            options.setdefault("rtol", 1e-6)
            options.setdefault("atol", 1e-9)
            if self.breakpoints is not None and ours is not None:
                options.setdefault("breakpoints", self.breakpoints)
        if stabilise not in (None, "projection", "baumgarte"):
            raise ValueError(
                f"`stabilise={stabilise!r}` is unknown; choose projection, baumgarte or None."
            )
        if stabilise == "baumgarte":
            return self.baumgarte().solve(t_span, y0, method, **options)
        if stabilise == "projection":
            if not hasattr(self, "project"):
                raise ValueError(f"The {self.name} has no constraints to project onto.")
            options["project"] = self.project
        t_span = (0.0, self.t_end) if t_span is None else t_span
        start = self.initial_state() if y0 is None else self.full_state(y0)
        if y0 is not None and self.constraints:
            start = start_of(self, t_span[0], start, stabilise == "projection")
        result = solve_ivp(self.rhs, t_span, start, method=method, args=self.args, **options)
        result.system = self.as_started(t_span[0], y0)
        return result

    def ensemble(self, t_span=None, y0=None, method="RK45", **given) -> Any:
        """
        Integrate many trajectories at once; `fastdyn.solve_ensemble` with the system filled in.

        Parameters
        ----------
        t_span, method
            As for `solve`.
        y0 : array_like, shape (M, n) or (n,), optional
            Initial states, those that belong to the parameters unless given.
        **given
            Parameters and initial conditions by name, each a number or an array of M numbers, one
            a trajectory, and options as for `fastdyn.solve_ensemble`, with the default tolerances
            of `solve`.

        Returns
        -------
        Trajectories
            With `system` set.
        """
        from .ensemble_arguments import ensemble

        return ensemble(self, t_span, y0, method, given)

    def full_state(self, y0):
        """`y0`, refused if it is not of the length of the state."""
        if np.shape(y0) != (len(self.states),):
            names = ", ".join(state.name for state in self.states)
            raise ValueError(
                f"`y0` of the {self.name} must be {len(self.states)} numbers ({names}); its shape "
                f"is {np.shape(y0)}."
            )
        return y0

    def along(self, function, t, y) -> np.ndarray:
        """Values of ``function(t, y, *parameters)`` at every column of y, shape (n_points,)."""
        t, y = np.atleast_1d(t).astype(float), self.columns(y)
        try:
            values = np.asarray(function(t, y, *self.args), float)
            if values.shape == t.shape:
                return values
        except (TypeError, ValueError):
            pass  # a function with branches takes one state at a time
        columns = zip(t, y.T, strict=True)
        return np.array([function(time, state, *self.args) for time, state in columns], float)

    def columns(self, y) -> np.ndarray:
        """State as an array of shape (n, n_points); SciPy's empty output is a list."""
        return np.asarray(y, float).reshape(len(self.states), -1)

    def evaluate_invariants(self, t, y) -> dict[str, np.ndarray]:
        """Every invariant at every column of y, {name: array of shape (n_points,)}."""
        return {name: self.along(function, t, y) for name, function in self.invariants.items()}

    def evaluate_constraints(self, t, y) -> dict[str, np.ndarray]:
        """Residual of every constraint at every column of y, {name: array of (n_points,)}."""
        return {name: self.along(function, t, y) for name, function in self.constraints.items()}

    def exact_along(self, t) -> np.ndarray:
        """
        Exact solution of a run, as `exact`, refused for a run that started elsewhere.

        Raises
        ------
        ValueError
            Where `exact` does, and if the run did not start from `initial_state()` at t = 0.
        """
        if getattr(self, "_started_elsewhere", False):
            raise ValueError(
                f"The exact solution of the {self.name} starts at t = 0 from its own initial "
                "state; solve without `y0` and from t = 0 to compare with it."
            )
        return self.exact(np.asarray(t, float))

    def error(self, result) -> np.ndarray:
        """Computed minus exact state, shape (n, n_points); raises as `exact_along` does."""
        return self.columns(result.y) - self.exact_along(result.t)

    def figure(self, results, **options):
        """
        Draw one result, or several for comparison.

        Parameters
        ----------
        results : dict of str to OdeResult
            Results by the label that the legend shows.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from fastdyn import plot

        return plot.components(results, **options)

    def scene(self, t, w) -> Any:
        """What the system looks like in one state, for moving pictures: an `animate.Scene`."""
        raise ValueError(f"The {self.name} has no view to animate.")

    def event_functions(self, events):
        """Events as functions: those of the system by name, others as they are."""
        if isinstance(events, str) or callable(events):
            events = [events]
        if events is None or not isinstance(events, Iterable):
            return events
        return [self._event(event) for event in events]

    def _event(self, event):
        if not isinstance(event, str):
            return event
        if event not in self.events:
            known = ", ".join(self.events) or "none"
            raise ValueError(f"{self.name} has no event '{event}'; its events are: {known}.")
        return self.events[event]

    def as_started(self, begin, y0):
        """Itself, or a copy that knows that its run started where `exact` does not hold."""
        if begin == 0.0 and (y0 is None or np.array_equal(y0, self.initial_state())):
            return self
        copy = dataclasses.replace(self)
        object.__setattr__(copy, "_started_elsewhere", True)
        return copy
