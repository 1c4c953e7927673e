"""The run of a reduced system, and its result."""

from typing import Any

import numpy as np

from fastdyn.kernels.algebra.linear import SingularMatrixError
from fastdyn.run.result import OdeResult
from fastdyn.solve.ivp import solve_ivp

from .history import decisions, history, jump_of
from .start import Unsolved
from .trajectory import Solution, components, places

COUNTS = ("nfev", "njev", "nlu", "n_accepted", "n_rejected")
SINGULAR = (
    "The equations are singular between t = {:.8g} and t = {:.8g}: their index changes there, or "
    "there is no solution beyond; or a step passes too much at once: reduce `max_step`."
)

JUMP = (
    "A constraint has a kink or a jump at t = {:.8g}: the derivative of an equation, by which the "
    "states are constrained, jumps there, as if struck. End the run before, and begin another one "
    "behind with a start that satisfies the constraints."
)


def run(reduction, t_span, z, method, t_eval, dense_output, events, args, options):
    """The OdeResult from a consistent start z, all orders of all components."""
    system = reduction.system
    if reduction.projection is not None:
        options["project"] = reduction.projection
    kinks = decisions(system)
    watched = [_of_components(event, reduction) for event in events]
    try:
        found = solve_ivp(
            reduction.motion, t_span, z[places(system)], method,
            dense_output=dense_output or t_eval is not None or bool(kinks), events=watched,
            args=(reduction.parameters, *args), **options,
        )  # fmt: skip
    except SingularMatrixError as error:
        raise Unsolved(
            f"the equations become singular on the way ({error}): their index changes there, or "
            "there is no solution beyond."
        ) from None
    log, last = history(reduction, found.t, found.y)
    if last is not None and last + 1 < len(found.t):
        found.status, found.message = -1, SINGULAR.format(*found.t[last : last + 2])
    else:
        last = len(found.t) - 1
    jump = jump_of(system, kinks, found) if kinks else None
    if jump is not None and abs(jump - found.t[0]) <= abs(found.t[last] - found.t[0]):
        found.status, found.message = -1, JUMP.format(jump)
        last = int(np.flatnonzero(np.abs(found.t - found.t[0]) < abs(jump - found.t[0]))[-1])
        log = [each for each in log if abs(each[0] - found.t[0]) <= abs(jump - found.t[0])]
    return _result(reduction, found, last, log, t_eval, dense_output)


def _of_components(event, reduction):
    """An event of y as an event of the reduced state."""
    all_components = reduction.components

    def watched(t, x, p, *args):
        return event(t, np.array(all_components(t, x, p)), *args)

    found: Any = watched
    for name in ("terminal", "direction"):
        if hasattr(event, name):
            setattr(found, name, getattr(event, name))
    return found


def _result(reduction, found, last, log, t_eval, dense_output):
    """The result up to the step end `last`."""
    system, end = reduction.system, found.t[last]
    sign = 1.0 if found.t[-1] >= found.t[0] else -1.0
    sol = None if found.sol is None else Solution(system, found.sol)
    if sol is None or t_eval is None:
        t = found.t[: last + 1]
        x = found.y[:, : last + 1]
    else:
        t = t_eval[sign * t_eval <= sign * end]
        x = np.asarray(found.sol(t))  # pyright: ignore[reportOptionalCall]
    y, yp = (components(system, t, x, True, rates) for rates in (False, True))
    times, states = [], []
    for at, x in zip(found.t_events, found.y_events, strict=True):
        here = sign * at <= sign * end
        times.append(at[here])
        x = np.reshape(x, (len(at), len(system.states)))[here].T
        states.append(components(system, at[here], x, project=True).T)
    return OdeResult(
        t=t, y=y, yp=yp, sol=sol if dense_output else None, t_events=times, y_events=states,
        status=found.status, message=found.message, success=found.status >= 0,
        index=reduction.index, differentiated=reduction.differentiated, states=log,
        **{name: found.get(name, 0) for name in COUNTS},
    )  # fmt: skip
