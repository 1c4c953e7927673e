"""Solutions and their derivatives with respect to the initial state and the parameters."""

from typing import NamedTuple

import numpy as np

from fastdyn.compile.derivatives.event_times import time_derivatives
from fastdyn.compile.derivatives.sensitivities import decides, jump_of
from fastdyn.compile.python_callback import evaluate
from fastdyn.compile.sentences import GaveUp, Uncompilable
from fastdyn.compile.traced.make import Near
from fastdyn.problem.schedules import in_order
from fastdyn.problem.sensitivities import (
    by_name,
    directions_of,
    not_differentiable,
    separated,
    with_sensitivities,
)
from fastdyn.run.dense_output import PiecewisePolynomial
from fastdyn.run.outcome import NOT_FINITE
from fastdyn.run.result import OdeResult
from fastdyn.run.solve_problem import followed, run_of

GRAZES = (
    "The new state or its sensitivities are nan or inf at t = {:.10g}: `on_event` returned nan or "
    "inf, or the event function touches zero there without crossing it, and the time of the event "
    "has no derivative."
)
JUMPS = (
    "`fun` jumps at t = {:.10g}, where the state or a parameter passes a limit (`if`, `where`, "
    "`sign`, rounding). The sensitivities jump there, too, which is not computed: make the passage "
    "smooth, tanh(v / w) for sign(v), say, or end the solve there by a terminal event."
)


def solve_with_sensitivities(problem, sensitivity):
    """The result of a problem, with the field `sensitivity`."""
    directions, longer, run = extended(problem, sensitivity)
    try:
        if decides(run.bounds[0]):
            whole = _watched(longer, longer.fun.n)
        else:
            whole = followed(longer, run)
    except (Uncompilable, GaveUp) as reason:
        raise not_differentiable("sensitivity", problem, reason) from None
    found = at_events(problem, whole, directions) if whole["t_events"] else None
    result = parted(whole, longer.fun.n, directions, _parts(problem))
    if found is not None:
        result["event_sensitivity"] = found
    return result


class EventSensitivity(NamedTuple):
    """The derivatives at the times of an event, k of them, each by the names of the directions.

    Attributes
    ----------
    t : dict of str to ndarray
        The derivatives of the times, shape (..., k).
    y : dict of str to ndarray
        Those of the states at these times, before `on_event` acts, shape (n, ..., k).
    """

    t: dict
    y: dict


def event_sensitivity(event, args, near, directions, at):
    """The EventSensitivity of an event, or of a schedule, None; None if there are no derivatives.

    `at` are the `occurrences` of `time_derivatives`.
    """
    *_, rate, s = at
    if event is None:  # schedules do not move
        moved = np.zeros(s.shape[1:])
        states = s
    else:
        positions = tuple([d.position for d in directions])
        moved = time_derivatives(event, args, near, positions, at)
        if moved is None:
            return None
        with np.errstate(all="ignore"):
            states = s + rate[:, None] * moved
    return EventSensitivity(by_name(moved, directions), by_name(states, directions))


def not_met(n_events, n, directions):
    """`at_events` of events of which none has occurred, for a state of n components."""
    none = np.zeros((n, sum([d.size for d in directions]), 0))
    return [
        EventSensitivity(by_name(none[0].copy(), directions), by_name(none.copy(), directions))
        for _ in range(n_events)
    ]


def _parts(problem):
    """The number of parts of a state: [q, v], or a whole."""
    return 2 if problem.method.second_order else 1


def at_events(problem, whole, directions):
    """An EventSensitivity for each event and schedule; None for an event without derivatives."""
    p = problem
    n = len(problem.y0)
    parts = _parts(problem)
    found = []
    near = Near(p.t0, p.tf, p.y0)
    functions = in_order(
        [event.function for event in p.events or ()], p.schedules, [None] * len(p.schedules)
    )
    m = sum([d.size for d in directions])
    for event, t, z in zip(functions, whole["t_events"], whole["y_events"], strict=True):
        z = z.reshape(len(t), n * (1 + m))
        y, s = separated(z, n // parts, parts)
        y = y.T
        s = np.moveaxis(s, 0, -1)
        rate = np.zeros(y.shape)
        event = event if len(t) else None
        if event is not None:
            rate[:] = np.transpose([_rate(p, *each) for each in zip(t, y.T, strict=True)])
        found.append(event_sensitivity(event, p.args, near, directions, (t, y, rate, s)))
    return found


def _rate(problem, t, y):
    """The function at a time and a state; NaN where it raises."""
    p, n = problem, len(y) // _parts(problem)
    try:
        with np.errstate(all="ignore"):
            value = evaluate(lambda t, y: p.fun(t, y, *p.args), p.mode, t, y[:n].copy())
    except Exception:
        return np.full(len(y), np.nan)
    return np.concatenate([y[n:], value])  # of q'' = a(t, q), v and a


def extended(problem, sensitivity):
    """The directions that `sensitivity` names, the longer problem, and a Run of this problem.

    Raises
    ------
    ValueError
        If the names are wrong, or the function has no derivatives.
    """
    directions = directions_of(sensitivity, problem.fun, problem.y0, problem.args)
    longer = with_sensitivities(problem, directions)
    try:
        return directions, longer, run_of(longer)
    except (Uncompilable, GaveUp) as reason:
        raise not_differentiable("sensitivity", problem, reason) from None


def _watched(problem, n):
    """Solve, and refuse a jump of the function along the solution; the whole result."""
    p = problem._replace(t_eval=None, dense_output=True)
    run = run_of(p)
    whole = OdeResult(followed(p, run))
    sol = whole.sol
    t_eval = problem.t_eval
    if sol is not None:
        t = whole.t  # at the ends of a step of a pulse, the pulse is over
        inside = np.sort(np.r_[t, 0.5 * (t[1:] + t[:-1])])[:: 1 if p.tf > p.t0 else -1]
        at = jump_of(run.bounds[0], inside, lambda t: sol(t)[:n])
        if at is not None:
            raise ValueError(JUMPS.format(at))
    if t_eval is not None:
        forwards = 1.0 if p.tf >= p.t0 else -1.0
        whole.t = t_eval[forwards * (t_eval - whole.t[-1]) <= 0]
        whole["y"] = sol(whole.t) if sol is not None and len(whole.t) else []
    if not problem.dense_output:
        whole.sol = None
    return whole


def divided(n, directions):
    """`parted` of states: ``divided(states)`` of `run.outcome.results`, for n components."""

    def views(states):
        columns = states[:, n:].T.reshape(n, -1, len(states))  # a view, as only an axis is split
        return states[:, :n], by_name(columns, directions)

    return views


def parted(whole, n, directions, parts=1):
    """The result of the extended state, now divided into state and sensitivities by name.

    The state has `parts` of n components: see `problem.sensitivities.joined`.
    """
    result = whole
    states = whole["y"]
    k = len(whole["t"])
    if k and parts == 1:
        result["y"] = states[:n]
        columns = states[n:].reshape(n, -1, k)
    elif k:
        each = states.reshape(parts, -1, k)
        result["y"] = each[:, :n].reshape(parts * n, k)
        columns = each[:, n:].reshape(parts * n, -1, k)
    else:  # SciPy's empty output is a list
        columns = np.empty((parts * n, sum([d.size for d in directions]), 0))
    result["sensitivity"] = by_name(columns, directions)
    sol = whole["sol"]
    at_events = whole["y_events"]
    if sol is not None:
        result.sol = PiecewisePolynomial(sol.ts, separated(sol.polynomials, n, parts)[0], sol.spans)
    if at_events is not None:
        result.y_events = [separated(y, n, parts)[0] if y.size else y for y in at_events]
    if whole["status"] == -1:
        if NOT_FINITE in result.message and "`on_event`" in result.message:
            result.message = GRAZES.format(result.t[-1] if k else float("nan"))
        else:
            order = "those of the state"
            if parts > 1:
                order = "the positions and their sensitivities, then the velocities"
            result.message += f" The components are {order}, then those of the sensitivities."
    return result
