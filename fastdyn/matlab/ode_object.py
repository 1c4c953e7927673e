"""MATLAB's object ode of R2023b, on the functions of `solvers`.

Names and meanings: MathWorks, reference pages of ode, odeEvent, solve, solutionFcn and ODEResults.
"""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong, takes
from fastdyn.words.near import did_you_mean

from .ode_events import (
    AS_OPTIONS,
    OLDER,
    EventDefinition,
    Properties,
    one_of,
    see_to_first_step,
    with_parameters,
)
from .options import odeset
from .solution import AtTimes, Joined
from .solve import solve, times_of
from .solvers import SOLVERS

CHOICES = {"auto": "ode45", "nonstiff": "ode45", "stiff": "ode15s"}
OF_PROBLEM = {
    "ODEFcn": None, "InitialTime": 0.0, "InitialValue": None, "Parameters": None,
    **dict.fromkeys(AS_OPTIONS), "EventDefinition": None, "Solver": "auto", "SolverOptions": None,
}  # fmt: skip
APART = {"Events", "OutputFcn", "Refine"}  # have no place in SolverOptions
PARAMETER = "A function of (t, y, p) needs Parameters=p."


class ODEResults(NamedTuple):
    """
    The result of `solve`, with MATLAB's names.

    Attributes
    ----------
    Time : ndarray, shape (m,)
    Solution : ndarray, shape (n, m)
        One column for each time.
    EventTime, EventSolution, EventIndex : ndarray, shapes (k,), (n, k), (k,)
        Events in the order of `Time`; indices count from 0.
    """

    Time: Any
    Solution: Any
    EventTime: Any
    EventSolution: Any
    EventIndex: Any

    def __getattr__(self, name):
        meant = did_you_mean(name, self._fields, OLDER)
        raise AttributeError(f"ODEResults has no `{name}`; {meant or ', '.join(self._fields)}")


class InitialValueProblem(Properties):
    """What `ode` returns: a problem and its solver, with the arguments of `ode` as attributes."""

    _called = "ode"
    _known = OF_PROBLEM

    def __init__(self, **given):
        super().__init__(**{"SolverOptions": {}, **given})

    def _checked(self, name, value):
        if name in AS_OPTIONS:
            try:
                return odeset(**{AS_OPTIONS[name]: value}).get(AS_OPTIONS[name])
            except (TypeError, ValueError) as error:
                raise type(error)(f"`{name}`: {error}") from None
        if name == "Solver":
            return one_of(name, value, (*CHOICES, *SOLVERS))
        if name == "ODEFcn":
            kinds.function(name, value)
        elif name == "InitialTime":
            kinds.number(name, value)
        elif name == "InitialValue":
            kinds.numbers(name, value)
        elif name == "SolverOptions":
            return odeset(value)
        elif name == "EventDefinition" and not isinstance(value, EventDefinition):
            kinds.refuse(name, "what `odeEvent(...)` returns", value)
        return value

    @property
    def SelectedSolver(self) -> str:
        """The solver of "auto", "stiff" or "nonstiff", or the one that is named."""
        implicit = self.MassMatrix is not None or self.Jacobian is not None
        if self.Solver == "auto" and implicit:
            return CHOICES["stiff"]
        return CHOICES.get(self.Solver, self.Solver)

    @shown_when_wrong(t0=kinds.times, tf=kinds.number, Refine=kinds.number)
    def solve(self, t0, tf=None, *, Refine=None) -> ODEResults:
        """
        Solve over an interval, or at times.

        Parameters
        ----------
        t0, tf : float
            The interval of the result, in either direction. The solution begins at InitialTime,
            which may lie before, within or behind the interval.
        t0 : array_like, shape (m,)
            Without `tf`: two or more times in order, the times of the result.
        Refine : int, optional
            Points of output for each step, as in `odeset`.

        Returns
        -------
        ODEResults
            Without the times that lie behind an event that ended the run.
        """
        times = times_of(t0 if tf is None else [t0, tf])
        low, high = sorted((float(times[0]), float(times[-1])))
        parts = []
        for run in self._runs(low, high, Refine):
            if tf is None:
                part = _at(run, np.sort(times) if run.x[-1] > run.x[0] else -np.sort(-times))
            else:
                part = _between(run, low, high)
            events = _events_between(run, low, high)
            turn = slice(None) if run.x[-1] > run.x[0] else slice(None, None, -1)
            parts.append([each[..., turn] for each in (*part, *events)])
        if len(parts) == 2 and np.array_equal(parts[0][0][-1:], parts[1][0][:1]):
            parts[0][:2] = [each[..., :-1] for each in parts[0][:2]]
        turn = slice(None) if times[-1] > times[0] else slice(None, None, -1)
        return ODEResults(
            *(np.concatenate(each, axis=-1)[..., turn] for each in zip(*parts, strict=True))
        )

    @shown_when_wrong(t0=kinds.number, tf=kinds.number, OutputVariables=kinds.array)
    def solutionFcn(self, t0, tf, *, OutputVariables=None) -> Any:
        """
        The solution over an interval, as a function.

        Parameters
        ----------
        t0, tf : float
            As in `solve`.
        OutputVariables : int or list of int, optional
            The components to return, counted from 0; by default all.

        Returns
        -------
        callable
            ``fh(t)`` has shape (n,) for a time, (n, m) for m times; it raises ValueError for times
            outside the interval, or behind an event that ended the run.
        """
        low, high = sorted(times_of([t0, tf]).tolist())
        runs = self._runs(low, high, None)
        ends = np.concatenate([run.x[[0, -1]] for run in runs])
        low, high = max(low, ends.min()), min(high, ends.max())
        known = runs[0].interpolant
        if len(runs) == 2:
            known = Joined(known, runs[1].interpolant, runs[1].x[0])
        chosen = slice(None) if OutputVariables is None else OutputVariables

        def fh(t):
            kinds.times("t", t)
            if not ((low <= np.asarray(t)) & (np.asarray(t) <= high)).all():
                raise ValueError(f"the solution is known from {low:g} to {high:g}; got {t!r}.")
            return known(np.asarray(t, float))[chosen]

        return fh

    def _runs(self, low, high, refine):
        """The Solutions from InitialTime to the ends of an interval, the earlier end first."""
        kinds.function("ODEFcn", self.ODEFcn)
        known = with_parameters(self.ODEFcn, self.Parameters) is not self.ODEFcn
        takes("ODEFcn", self.ODEFcn, "t, y, p" if known else "t, y", PARAMETER)
        if self.InitialValue is None:
            raise ValueError("`ode` needs InitialValue, the state at InitialTime.")
        start = float(self.InitialTime)
        ends = [end for end, there in ((low, low < start), (high, high > start)) if there]
        return [self._run(end, refine) for end in ends]

    def _run(self, end, refine):
        """The Solution from InitialTime to `end`, through the callbacks of events."""
        definition = self.EventDefinition
        solver = SOLVERS[self.SelectedSolver]
        t = float(self.InitialTime)
        y = np.ravel(self.InitialValue)
        p = self.Parameters
        whole: Any = None
        while True:
            options = self._options(p, refine)
            responses: Any = ()
            if definition is not None:
                options["Events"], responses = definition.events(t, y, p)
            piece = solve(solver, with_parameters(self.ODEFcn, p), [t, end], y, options)
            if definition is not None:
                see_to_first_step(piece, responses, whole is not None)
            whole = piece if whole is None else whole.joined(piece)
            if definition is None or piece.result.status != 1:
                return whole
            t = float(piece.x[-1])
            stop, y, p = definition.called_back(piece, responses, p)
            if stop or t == end:
                return whole

    def _options(self, p, refine):
        options = odeset(self.SolverOptions)
        if APART & options.keys():
            raise ValueError(
                f"SolverOptions have no {', '.join(sorted(APART & options.keys()))}: there are "
                "EventDefinition and solve(..., Refine=)."
            )
        for name, old in AS_OPTIONS.items():
            if getattr(self, name) is not None:
                options[old] = with_parameters(getattr(self, name), p)
        return odeset(options, Refine=refine)


def _at(run, times):
    """Times and states, in columns, at the times that a run reaches."""
    reached = (times - run.x[0]) * (run.x[-1] - times) >= 0.0
    if not reached.any():
        return np.empty(0), np.empty((len(run.y), 0))
    t, y = AtTimes(times, run.result.status == 1)(run)
    return t, y.T


def _between(run, low, high):
    """Times and states, in columns, of the output of a run from `low` to `high`."""
    t, y = run._output(run)
    inside = (low <= t) & (t <= high)
    begin = low if run.x[-1] > run.x[0] else high
    if (run.x[0] - begin) * (begin - run.x[-1]) > 0.0 and begin not in t:
        y = np.vstack([run.interpolant(begin), y[inside]])
        return np.append(begin, t[inside]), y.T
    return t[inside], y[inside].T


def _events_between(run, low, high):
    if run.xe is None:
        return np.empty(0), np.empty((len(run.y), 0)), np.empty(0, int)
    inside = (low <= run.xe) & (run.xe <= high)
    return run.xe[inside], run.ye[:, inside], run.ie[inside]


def ode(**properties) -> InitialValueProblem:
    """
    An initial value problem with its solver, as MATLAB's object ode of R2023b.

    Parameters
    ----------
    ODEFcn : callable
        ``ODEFcn(t, y)`` or, with Parameters, ``ODEFcn(t, y, p)`` returns the derivative.
    InitialTime : float
        0 by default.
    InitialValue : float or array_like, shape (n,)
        The state at InitialTime.
    Parameters : optional
        The third argument of ODEFcn, EventFcn, and functions for MassMatrix and Jacobian.
    RelativeTolerance, AbsoluteTolerance, MassMatrix, Jacobian, NonNegativeVariables : optional
        The options RelTol, AbsTol, Mass, Jacobian and NonNegative of `odeset`.
    EventDefinition : optional
        What `odeEvent` returns.
    Solver : str
        A name of `fastdyn.matlab`'s solvers; "nonstiff" is ode45, "stiff" ode15s, and "auto" is
        ode45, but with MassMatrix or Jacobian ode15s. MATLAB's "auto" may choose another.
    SolverOptions : Options or dict, optional
        Further options of `odeset`, such as MaxStep.

    Returns
    -------
    InitialValueProblem
        With the arguments as attributes, `SelectedSolver`, `solve` and `solutionFcn`.

    Raises
    ------
    TypeError, ValueError
        For unknown names and choices, and values of another kind. An unknown attribute raises
        AttributeError.

    Examples
    --------
    >>> F = ode(ODEFcn=lambda t, y: [y[1], -y[0]], InitialValue=[1, 0])
    >>> F.solve(0, 10).Solution.shape[0]
    2
    """
    return InitialValueProblem(**properties)
