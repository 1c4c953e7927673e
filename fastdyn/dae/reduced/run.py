"""The run of a reduced system, and its result."""

import contextlib

import numpy as np

from fastdyn.compile import budget
from fastdyn.compile.bind import or_in_python
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.kernels.algebra.linear import SingularMatrixError
from fastdyn.kernels.state.record import STATE
from fastdyn.problem import validate
from fastdyn.problem.arguments import Arguments
from fastdyn.problem.schedules import listed
from fastdyn.run.functions.bound import bind_functions
from fastdyn.run.loop import Run
from fastdyn.run.outcome import result_of
from fastdyn.run.result import Ended, OdeResult, made
from fastdyn.run.solve_problem import load_kernels, solve_problem
from fastdyn.specialise.series import NoSeries

from ..callbacks import with_observed
from ..jumps import with_acting, with_jumps
from ..structure.start import Unsolved
from .actions import Action
from .borders import Borders
from .events import check_still, watched
from .history import along, decisions
from .trajectory import ReducedSolution, components, places

SINGULAR = (
    "The equations are singular between t = {:.8g} and t = {:.8g}: their index changes there, or "
    "there is no solution beyond; or a step passes too much at once: reduce `max_step`."
)

JUMP = (
    "A constraint has a kink or a jump at t = {:.8g}: the derivative of an equation, by which the "
    "states are constrained, jumps there, as if struck. End the run before, and begin another one "
    "behind with a start that satisfies the constraints."
)

NO_SERIES = (
    "Taylor finds events by their series, and component {} of y, which an event uses, has none: a "
    "system of equations determines the component, by an elimination that chooses among the "
    "equations. Take Vern9 or DOP853."
)


def run(reduction, given, z, method, held, tangent=None):
    """The OdeResult from a consistent start z, all orders of all components.

    `held` are the components that keep their values behind an event.  A `tangent`, a
    sensitivities.ReducedTangent, adds the sensitivities.
    """
    kinks = decisions(reduction.system)
    actions = []
    asked = []
    problem = _problem(reduction, given, z, method, held, bool(kinks), actions, asked)
    borders = Borders(reduction)
    if kinks and tangent is None and problem.checkpoint is None:
        problem = borders.solved_behind(problem)
    whole = None
    try:
        if tangent is not None:
            found, whole = tangent.solved(problem, z)
        else:
            found = borders.of_result(_solved(problem))
    except NoSeries as reason:
        solved = sorted({k for each in asked for k in each.solved})
        if not (solved and "events" in str(reason)):
            raise
        raise NoSeries(NO_SERIES.format(solved[0])) from None
    except SingularMatrixError as error:
        raise Unsolved(
            f"the equations become singular on the way ({error}): their index changes there, or "
            "there is no solution beyond."
        ) from None
    if actions or problem.callback:
        check_still(asked)
    for action in actions:
        if action.bad is not None:
            found.message = action.bad
    log, last, jump = along(reduction, found, kinks, borders.beside(found.t), borders.cuts(found.t))
    if last is not None:
        found.status, found.message = -1, SINGULAR.format(*found.t[last : last + 2])
    else:
        last = len(found.t) - 1
    if jump is not None and abs(jump - found.t[0]) <= abs(found.t[last] - found.t[0]):
        found.status, found.message = -1, JUMP.format(jump)
        last = int(np.flatnonzero(np.abs(found.t - found.t[0]) < abs(jump - found.t[0]))[-1])
        log = [each for each in log if abs(each[0] - found.t[0]) <= abs(jump - found.t[0])]
    result = _result(reduction, given, found, last, log, borders)
    if tangent is not None:
        tangent.put(result, whole)
    return result


def _problem(reduction, given, z, method, held, kinks, actions, asked):
    """The Problem of the reduced state; lists get its Actions, and an Asked for each event."""
    system, options = reduction.system, options_of(given.options, reduction.system, given.n)

    def own(t, x):
        t = np.asarray(t, float)
        x = x[: len(system.states)].reshape(len(system.states), -1)  # sensitivities may follow
        y = components(system, np.atleast_1d(t), x, project=True)
        return y[:, 0] if t.ndim == 0 else y

    options = with_observed(options, own)
    if reduction.projection is not None:
        options["project"] = reduction.projection
    events = listed(given.events, {})
    arguments = Arguments(
        fun=reduction.motion, t0=given.t0, tf=given.tf, y0=z[places(system)],
        dense_output=given.dense_output or given.t_eval is not None or kinks,
        events=events and [watched(each, reduction, given, asked) for each in events],
        args=(reduction.parameters, *given.args), options=options,
    )  # fmt: skip
    p = validate.problem(arguments, validate.method_named(method), DERIVATIVE)

    def acting(act):
        actions.append(Action(system, act, held))
        return actions[-1]

    return with_jumps(p, acting)


def _solved(problem):
    """The OdeResult of a problem; functions that act run in Python."""
    plain = with_jumps(problem, lambda act: None)

    def solve():
        with contextlib.ExitStack() as limits:
            if not problem.method.series:  # a series needs the code, and makes its own kernel
                load_kernels(problem)  # first: no other thread compiles kernels meanwhile
                limits.enter_context(budget.limited(0.0))
            bound, others = bind_functions(plain)
        others = with_acting(problem, others)
        run = Run(problem, bound, others)  # what runs in Python changes no formula of the motion
        return result_of(problem, run.solve(problem.y0), run)

    if problem.t0 == problem.tf:
        return _of_no_time(problem)
    acts = problem.acts or any(each.jump for each in problem.schedules)
    return or_in_python(solve) if acts else solve_problem(problem)


def options_of(options, system, n):
    """The options, with tolerances of each component as those of the reduced state."""
    options = dict(options)
    for name in ("rtol", "atol"):
        value = options.get(name)
        if value is not None and np.ndim(value):
            value = np.asarray(value, float)
            if value.shape != (n,):
                raise ValueError(f"`{name}` has wrong shape.")
            names = [system.name(j, order) for j, order in system.states]
            options[name] = np.array([value.min() if k is None else value[k] for k in names])
    return options


def _of_no_time(problem):
    """The OdeResult of a span without length."""
    n = len(problem.y0)
    events = problem.events is not None
    none = [np.empty(0)] * (len(problem.events or ()) + len(problem.schedules)) if events else None
    return made(
        problem.method, Ended.of(np.zeros(1, STATE)[0]), t=np.array([problem.t0]),
        y=problem.y0.reshape(n, 1), t_events=none, y_events=none, status=0,
        message="The span has no length.",
    )  # fmt: skip


def _result(reduction, given, found, last, log, borders):
    """The result up to the step end `last`."""
    system = reduction.system
    end = found.t[last]
    t_eval = given.t_eval
    sign = 1.0 if found.t[-1] >= found.t[0] else -1.0
    sol = None if found.sol is None else ReducedSolution(system, found.sol, borders.before)
    beside = borders.before
    if t_eval is None:
        t = found.t[: last + 1]
        x = found.y[:, : last + 1]
        beside = borders.beside
    elif sol is None:  # without a step
        t = t_eval[t_eval == found.t[0]]
        x = np.repeat(found.y[:, :1], len(t), axis=1)
    else:
        t = t_eval[sign * t_eval <= sign * end]
        x = np.asarray(found.sol(t))  # pyright: ignore[reportOptionalCall]
    y, yp = (components(system, beside(t), x, True, rates) for rates in (False, True))
    times = []
    states = []
    for at, x in zip(found.t_events or (), found.y_events or (), strict=True):
        here = sign * at <= sign * end
        times.append(at[here])
        x = np.reshape(x, (len(at), len(system.states)))[here].T
        states.append(components(system, borders.before(at[here]), x, project=True).T)
    result = OdeResult(found)
    result.success = found.status >= 0  # a singularity or a jump on the way changed the status
    result.t = t
    result.y = y
    result.sol = sol if given.dense_output else None
    if found.t_events is not None:
        result.t_events = times
        result.y_events = states
    result["yp"], result["index"], result["states"] = yp, reduction.index, log
    result["differentiated"] = reduction.differentiated
    return result
