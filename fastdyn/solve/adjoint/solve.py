"""Solutions whose derivatives a sweep back over the steps computes: `solve_ivp(adjoint=...)`."""

import math

import numpy as np

from fastdyn.compile.derivatives.compare import compare_vjp
from fastdyn.compile.derivatives.sensitivities import decides, jump_of
from fastdyn.compile.derivatives.vjp import bind_vjp, frozen
from fastdyn.compile.sentences import GaveUp, Uncompilable
from fastdyn.compile.traced.make import Near
from fastdyn.problem.sensitivities import directions_of
from fastdyn.run.functions.compared import AT_FIRST, WHEN, Schedule, apart
from fastdyn.run.loop import Run
from fastdyn.run.outcome import result_of
from fastdyn.run.result import OdeResult
from fastdyn.run.solve_problem import run_of

from ..sensitivities import JUMPS
from .keeping import ROOM, Keeping, Kept, kept_of
from .vjp import Vjp

NEEDS = "`adjoint` needs a function that can be traced and differentiated: {}."


def solve_with_adjoint(problem, names):
    """The result of a problem, with the field `vjp`."""
    p = problem
    directions = directions_of(names, p.fun, p.y0, p.args, "adjoint")
    positions = tuple([d.position for d in directions if d.position])
    try:
        product = bind_vjp(p.fun, p.args, Near(p.t0, p.tf, p.y0), positions)
        run = run_of(p, Run if p.t_eval is None else Keeping)
        bound = run.bounds[0]
        if bound.function is None or bound.function.traced is None:
            raise Uncompilable("it runs in Python")
        result = OdeResult(result_of(p, run.solve(p.y0), run))
        if not result.success:
            result["vjp"] = _Failed(result.message)
            return result
        kept = _kept(run, result)
        _compare(run, product, kept)
    except (Uncompilable, GaveUp) as reason:
        raise ValueError(NEEDS.format(reason)) from None
    if decides(product.bound):
        _refuse_jumps(product.bound, kept)
    kinds, values = [kind for kind, _ in bound.values], bound.given
    own = frozen(
        bound.function, None, list(zip(kinds, values, strict=True)), bound.mode, len(p.y0), bound.at
    )
    problem = run.problem._replace(fun=None, args=(), t_eval=np.array(result.t, float))
    result["vjp"] = Vjp(problem, own, product, directions, kept)
    return result


def _kept(run, result):
    if run.problem.t_eval is not None:
        return kept_of(run)
    t, y = result.t, result.y.T  # each step, which the user may change
    between = max(1, math.ceil(y.size / ROOM))
    return Kept(run.problem, t[1:].copy(), y[between::between].copy(), between)


def _compare(run, product, kept):
    """Compare the product with differences of the function, in solves 1, 2, 4, 8, ..."""
    p, notes = run.problem, product.bound.function.notes
    schedule = notes.setdefault("compared", Schedule(WHEN))
    if schedule.after_one():
        chosen = apart(len(kept.states), AT_FIRST)
        with run.not_repeated():
            compare_vjp(product, p.fun, p.args, kept.t[:: kept.apart][chosen], kept.states[chosen])


def _refuse_jumps(bound, kept):
    """Refuse a jump of the function along the solution, straight between the ends of steps."""
    times, states = kept.t[:: kept.apart][: len(kept.states)], kept.states
    sign = 1.0 if times[-1] >= times[0] else -1.0

    def solution(t):
        return np.array([np.interp(sign * t, sign * times, column) for column in states.T])

    at = jump_of(bound, times, solution)
    if at is not None:
        raise ValueError(JUMPS.format(at).replace("sensitivities jump", "derivatives jump"))


class _Failed:
    """The `vjp` of a solve that failed."""

    def __init__(self, message):
        self._message = message

    def __call__(self, g):
        raise ValueError(f"There are no derivatives of a solve that failed: {self._message}")
