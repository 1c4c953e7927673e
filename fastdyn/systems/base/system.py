"""The base class of systems: equations, parameters, invariants, exact solution, figure.

A new system is one file in the folder `systems`: a frozen dataclass that inherits from `System`,
whose fields are its parameters and initial conditions. No other file has to name the system:
`fastdyn list`, `fastdyn run`, `fastdyn tour` and the tests find the class. All systems have one
order: equations, state, parameters, start, right-hand side, energy and other functions of the
state, events, exact solution, derived answers, pictures.
"""

import dataclasses
import inspect
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np

from fastdyn.plot.displayed import picture
from fastdyn.problem.options.docstrings import filled
from fastdyn.solve.ivp import solve_ivp

from .consistent_start import start
from .declare import Declared, Derived, State, documented, of_instance
from .pictures import Pictures
from .result import SystemResult, asked
from .solve_arguments import completed, projection, span


@dataclasses.dataclass(frozen=True)
class System(Declared, Pictures):
    """
    One system of the course; subclasses fill in the class attributes and methods below.

    Functions of the state have one of the decorators `invariant`, `quantity`, `constraint` and
    `event`, which enter the functions into the dicts below. `derived` makes a method a property,
    and enters the property.

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
    explored : dict of str to float
        Values with which `fastdyn explore` begins, for fields whose defaults show little.
    rhs : callable
        Plain function ``rhs(t, y, *parameters)``; unpacks y, returns a list.
    invariants : dict of str to callable
        Functions of ``(t, y, *parameters)`` that the exact motion keeps constant. Compiled code
        calls the functions with one state, shape (n,), Python with all columns, (n, n_points).
    quantities : dict of str to callable
        Other functions of ``(t, y, *parameters)``: reactions, distances, angles.
    events : dict of str to callable
        Event functions by name, in SciPy's form with ``terminal`` and ``direction``.
    derived : dict of str to str
        Answers that follow from the parameters alone, properties of the class, and their units.
    constraints : dict of str to callable
        Residuals of the constraints, functions of ``(t, y, *parameters)``.
    choices : dict of str to dict
        For each field that is a function, the functions to choose from, by name.
    none_in : dict of str to tuple of str
        For a phase, the names of quantities that are zero in it, whatever their functions say.
    project : callable
        ``project(t, y, *parameters)`` moves a state to the nearest state on the constraints; only
        for systems with constraints.

    Notes
    -----
    Every function gets all parameters, in the order of the fields, so that a new value needs no
    other code. Fields declared by `initial` set the initial state and are not passed. Sections on
    parameters and source are appended to the docstring of a subclass.
    """

    title: ClassVar[str]
    source: ClassVar[str]
    states: ClassVar[tuple[State, ...]]
    t_end: ClassVar[float]
    explored: ClassVar[Mapping[str, float]] = {}
    rhs: ClassVar[Callable]
    invariants: ClassVar[Mapping[str, Callable]] = {}
    quantities: ClassVar[Mapping[str, Callable]] = {}
    events: ClassVar[Mapping[str, Callable]] = {}
    derived: ClassVar[Mapping[str, str]] = {}
    constraints: ClassVar[Mapping[str, Callable]] = {}
    choices: ClassVar[Mapping[str, Mapping[str, Any]]] = {}
    none_in: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    project: ClassVar[Callable]

    def __init_subclass__(cls, **options):
        super().__init_subclass__(**options)
        for name, member in list(vars(cls).items()):
            if isinstance(member, Derived):
                cls.derived = {**cls.derived, name: member.unit}
            elif inspect.isfunction(member) and (group := getattr(member, "group", None)):
                setattr(cls, group, {**getattr(cls, group), name: member})
                setattr(cls, name, staticmethod(member))
        if cls.__doc__ and hasattr(cls, "source") and "Raises\n" not in cls.__doc__:
            cls.__doc__ = documented(cls)

    def _repr_html_(self):
        return super()._repr_html_() + picture(self.at_start, width=20)

    def initial_state(self) -> tuple[float, ...]:
        """State at t = 0, from the fields."""
        raise NotImplementedError(f"{self.name} does not define its initial state.")

    @property
    def breakpoints(self):
        """Times at which steps must end, ndarray, or None."""
        return None

    def phases(self) -> dict[str, Any]:
        """The phases of the motion by name, `fastdyn.solve.phases.Phase`; empty for one motion."""
        return {}

    def mass_matrix(self) -> Callable | None:
        """``mass(t, y, *parameters)``, the m² numbers of the mass matrix; None for no such form."""
        return None

    @of_instance
    def export(self, file=None, language="c", jacobian=False, mass=False):
        """
        Write the right-hand side and the events as source, without any library but `math.h`.

        Parameters
        ----------
        file : path, optional
            By default the name of the system; C has a header of the same name, too.
        language : {"c", "js"}
            C, or a module of JavaScript.
        jacobian : bool
            Whether to write the Jacobian of the right-hand side.
        mass : bool
            Whether to write the mass matrix, which systems that `derive` makes have.

        Returns
        -------
        list of Path
            The files.

        Raises
        ------
        ValueError
            If a function has no form in the language; the message names the line.
        """
        from .export import code, write

        return write(code(self, jacobian, mass), file, language)

    def baumgarte(self) -> "System":
        """The system with Baumgarte's stabilisation of its constraints."""
        raise ValueError(f"The {self.name} has no Baumgarte stabilisation.")

    def exact(self, t) -> np.ndarray:
        """
        Exact solution from the initial state at t = 0.

        Parameters
        ----------
        t : float or array_like, shape (n_points,), times in seconds

        Returns
        -------
        ndarray, shape (n,) or (n, n_points)

        Raises
        ------
        ValueError
            If no exact solution is known for this system or these parameters.
        """
        raise ValueError(f"No exact solution of the {self.name} is known to fastdyn.")

    @of_instance
    @filled()
    def solve(
        self, t_span: Any = None, y0: Any = None, method: Any = "RK45", project=None, **options: Any
    ) -> SystemResult:
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
        project : bool or callable, optional
            True: the state is projected onto the constraints at the start and after each step.
            False: the accelerations alone hold the constraints, and a start that violates the
            constraints gives a warning. A function is used as by `fastdyn.solve_ivp`. For
            Baumgarte's stabilisation, solve `baumgarte()`.
        **options
            As for `fastdyn.solve_ivp`, with two differences: `events` may also name events of
            the system (``events="slack"``), and the default tolerances of the adaptive methods
            are rtol = {rtol of systems} and atol = {atol of systems}, because with SciPy's {rtol}
            and {atol} the course's satellite falls onto its planet; "ode45" and "ode23" have
            MATLAB's {rtol} and {atol}.

        Returns
        -------
        SystemResult
        """
        t_span = span(self, t_span)
        options = completed(self, method, options, t_span)
        if project_with := projection(self, project):
            options["project"] = project_with
        begin = start(self, t_span[0], y0, project)
        result = solve_ivp(self.rhs, t_span, begin, method=method, args=self.args, **options)
        own = self.as_started(t_span[0], y0, options.get("on_event"))
        return SystemResult(result, own, asked(result, t_span, y0, method, project, options))

    @of_instance
    def ensemble(self, t_span=None, y0=None, method="RK45", **given) -> Any:
        """
        Integrate many trajectories at once; `fastdyn.solve_ensemble` with the system filled in.

        Parameters
        ----------
        t_span, method
            As for `solve`.
        y0 : array_like, shape (M, n) or (n,), optional
            Initial states; by default, the parameters determine them.
        **given
            Parameters and initial conditions by name, each a number, or an array of M numbers, one
            for each trajectory; and options as for `fastdyn.solve_ensemble`, with the default
            tolerances of `solve`.

        Returns
        -------
        Trajectories
            With `system` set.
        """
        from .ensemble_arguments import ensemble

        return ensemble(self, t_span, y0, method, given)

    def along(self, function, t, y) -> np.ndarray:
        """Values of ``function(t, y, *parameters)`` at every column of y, shape (n_points,)."""
        t = np.atleast_1d(t).astype(float)
        y = self.columns(y)
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

    def exact_along(self, t) -> np.ndarray:
        """
        Exact solution along a run: see `exact`.

        Raises
        ------
        ValueError
            As `exact`, and if the run did not start from `initial_state()` at t = 0.
        """
        if getattr(self, "_started_elsewhere", False):
            raise ValueError(
                f"The exact solution of the {self.name} starts at t = 0 from its own initial "
                "state; solve without `y0` and `on_event`, and from t = 0, to compare with it."
            )
        return self.exact(np.asarray(t, float))

    def as_started(self, begin, y0, on_event=None):
        """The system, or a copy for a run with another start, for which `exact` does not hold."""
        own = y0 is None or np.array_equal(y0, self.initial_state())
        if begin == 0.0 and own and on_event is None:
            return self
        copy = dataclasses.replace(self)
        object.__setattr__(copy, "_started_elsewhere", True)
        return copy
