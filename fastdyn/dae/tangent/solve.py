"""Solves F(t, y, y') = 0 with its sensitivities by BDF."""

import numpy as np

from fastdyn.compile.derivatives.sensitivities import decides, jump_of
from fastdyn.compile.sentences import Uncompilable
from fastdyn.compile.traced.make import Near
from fastdyn.problem.schedules import in_order
from fastdyn.problem.sensitivities import by_name, not_traced
from fastdyn.run.functions.compared import off_the_solution
from fastdyn.run.outcome import NOT_FINITE
from fastdyn.run.result import OdeResult
from fastdyn.solve.sensitivities import GRAZES, JUMPS, event_sensitivity

from ..result import result_of
from ..start import run_of
from .residual import Tangent

OF_KINKS = (
    " A kink of `F` (max, abs, where) in an equation without derivatives is a jump of its "
    "`sensitivity`."
)


def solve_with_sensitivities(asked, problem, breakpoints):
    """The OdeResult of a problem.DaeArguments, with `sensitivity` and `event_sensitivity`."""
    try:
        run, index = _run_of(asked, problem, breakpoints)
    except Uncompilable as reason:
        raise not_traced("sensitivity", problem, reason) from None
    if decides(run.bounds[0]):
        whole = _watched(asked, problem, breakpoints)
    else:
        whole = result_of(run.problem, run.solve(run.problem.y0), run, index)
    if breakpoints is not None:
        whole = breakpoints.of_result(whole)
    return _parted(asked, problem, whole)


def _run_of(asked, problem, breakpoints):
    return run_of(
        problem, asked.held, breakpoints,
        lambda p, equations: Tangent(p, equations, asked.directions, asked.held),
    )  # fmt: skip


def _watched(asked, problem, breakpoints):
    """Solve, and refuse a jump of F along the solution."""
    p = problem._replace(t_eval=None, dense_output=True)
    run, index = _run_of(asked, p, breakpoints)
    whole = result_of(run.problem, run.solve(run.problem.y0), run, index)
    n = asked.n
    sol = whole.sol
    t_eval = problem.t_eval
    if sol is not None:
        cuts = np.flatnonzero(np.diff(whole.t) == 0) + 1
        for t in np.split(whole.t, cuts):
            at = _jump(run.bounds[0], t, sol, n)
            if at is not None:
                raise ValueError(JUMPS.format(at).replace("`fun`", "`F`"))
    if t_eval is not None:
        forwards = 1.0 if p.tf >= p.t0 else -1.0
        whole.t = t_eval[forwards * (t_eval - whole.t[-1]) <= 0]
        if sol is not None:
            whole.y, whole["yp"] = sol(whole.t), sol.derivative(whole.t)
    if not problem.dense_output:
        whole.sol = None
    return whole


def _jump(bound, t, sol, n):
    """The first time at which F jumps within a smooth part of the solution, or None."""
    if len(t) < 2:
        return None
    late, begin = np.maximum if t[-1] >= t[0] else np.minimum, np.nextafter(t[0], t[-1])
    times = np.empty(2 * len(t) - 1)
    times[::2], times[1::2] = t, 0.5 * (t[1:] + t[:-1])

    def away(t):
        """States with another y': at the solution F is rounding, and any change of it large."""
        t = late(t, begin)
        return np.transpose([
            off_the_solution(np.r_[y[:n], yp[:n]])
            for y, yp in zip(sol(t).T, sol.derivative(t).T, strict=True)
        ])  # fmt: skip

    return jump_of(bound, times, away)


def _parted(asked, problem, whole):
    """The result of the longer state, divided into y and its sensitivities."""
    directions = asked.directions
    n = asked.n
    k = len(whole.t)
    m = sum([d.size for d in directions])
    result = OdeResult(whole)
    y = np.reshape(whole.y, (n * (1 + m), k))
    result.y, result["yp"] = y[:n], np.reshape(whole.yp, y.shape)[:n]
    result["sensitivity"] = by_name(y[n:].reshape(n, m, k), directions)
    if whole.sol is not None:
        result.sol = whole.sol.of_first(n)
    if whole.t_events is not None:
        parts = [
            (np.reshape(y, (len(t), n * (1 + m))), np.reshape(yp, (len(t), n * (1 + m))))
            for t, y, yp in zip(whole.t_events, whole.y_events, whole.yp_events, strict=True)
        ]
        result["event_sensitivity"] = _at_events(asked, problem, whole.t_events, parts)
        for name, i in (("y_events", 0), ("yp_events", 1)):
            result[name] = [each[i][:, :n] if len(each[i]) else whole[name][j]
                            for j, each in enumerate(parts)]  # fmt: skip
    if whole.status == -1 and NOT_FINITE in result.message:
        result.message = GRAZES.format(result.t[-1] if k else float("nan"))
    elif whole.status == -1:
        result.message += OF_KINKS
    return result


def _at_events(asked, problem, times, parts):
    """An EventSensitivity for each event and schedule; None for an event without derivatives."""
    p = problem
    n = asked.n
    found = []
    near = Near(asked.t0, asked.tf, asked.y0)
    functions = in_order(
        [event.function for event in p.events or ()], p.schedules, [None] * len(p.schedules)
    )
    for event, t, (z, zp) in zip(functions, times, parts, strict=True):
        y = z[:, :n].T
        rate = zp[:, :n].T
        s = np.moveaxis(z[:, n:].reshape(len(t), n, -1), 0, -1)
        own = event if len(t) else None
        at = (t, y, rate, s)
        found.append(event_sensitivity(own, asked.args, near, asked.directions, at))
    return found
