"""Solutions whose derivatives a sweep back over the steps computes: `solve_ivp(adjoint=...)`."""

import math
from typing import Any

import numpy as np

from fastdyn.compile.derivatives.compare import compare_vjp
from fastdyn.compile.derivatives.sensitivities import decides, jump_of
from fastdyn.compile.derivatives.vjp import bind_vjp, frozen
from fastdyn.compile.mode import DERIVATIVE, VJP
from fastdyn.compile.sentences import GaveUp, Uncompilable
from fastdyn.compile.traced.known import known_trace
from fastdyn.compile.traced.make import Near
from fastdyn.problem.sensitivities import directions_of
from fastdyn.run.functions.compared import AT_FIRST, WHEN, Schedule, apart
from fastdyn.run.loop import Run
from fastdyn.run.outcome import result_of, results
from fastdyn.run.result import OdeResult
from fastdyn.run.solve_problem import run_of

from ..sensitivities import JUMPS, not_differentiable
from .keeping import ROOM, Keeping, Kept, kept_in, kept_of
from .vjp import Vjp

EVENTS = (
    "`adjoint` takes events that act on nothing, in compiled code.  Take `sensitivity` for "
    "schedules; events that run in Python may change what `fun` uses."
)


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
        if p.schedules or any(each.function is None for each in run.bounds):
            raise ValueError(EVENTS)
        result = OdeResult(result_of(p, run.solve(p.y0), run))
        if not result.success or not result.n_accepted:
            result["vjp"] = Failed(result.message)
            return result
        kept = _kept(run, result)
        _compare(run, p, product, kept)
    except (Uncompilable, GaveUp) as reason:
        raise not_differentiable("adjoint", problem, reason) from None
    if decides(product.bound):
        _refuse_jumps(product.bound, kept)
    directions = [d._replace(value=np.empty(d.value.shape)) for d in directions]
    p = run.problem
    if result.status == 1:
        p = p._replace(tf=float(kept.t[-1]))
        kept.end_with_step(run)
    return with_vjp(result, p, bound, bound.given, product, directions, kept)


def with_vjp(result, problem, bound, given, product, directions, kept):
    """The result of a solve with the field `vjp`.

    `bound` are the equations, `given` the values of their parameters.
    """
    values = zip([kind for kind, _ in bound.values], given, strict=True)
    own = frozen(bound.function, None, values, bound.mode, product.n, bound.at)
    problem = problem._replace(
        fun=None, args=(), events=None, on_event=(), t_eval=np.array(result.t, float)
    )
    result["vjp"] = Vjp(problem, own, product, directions, kept)
    return result


class Again:
    """The part of `adjoint` in repeated solves of one kind of call; see `solve/repeated.py`."""

    def __init__(self, names):
        self._names = names
        self._known: Any = None
        self._directions: Any = None
        self._product: Any = None

    def run_of(self, problem):
        """A Keeping run of a problem; Uncompilable if the solve needs the long way."""
        p = problem
        found = directions_of(self._names, p.fun, p.y0, p.args, "adjoint")
        self._directions = [d._replace(value=np.empty(d.value.shape)) for d in found]
        positions = tuple([d.position for d in found if d.position])
        self._product = bind_vjp(p.fun, p.args, Near(p.t0, p.tf, p.y0), positions)
        varying = tuple(sorted(positions))
        self._known = known_trace(p.fun, p.args, DERIVATIVE, len(p.y0), varying)
        run = run_of(p, Keeping)
        if self._known is None or decides(self._product.bound) or run.switching is not None:
            raise Uncompilable("its solves are looked at")
        return run

    def suits(self, args):
        """Whether arguments have the shapes of the directions."""
        return all(
            np.shape(args[d.position - 1]) == d.value.shape for d in self._directions if d.position
        )

    @staticmethod
    def results(problem, plan, own=None):
        """As `outcome.results`; the field `vjp` of a result has its memory, until `finished`."""
        make = results(problem, plan, own)

        def made(memory, grown, code, message):
            result = make(memory, grown, code, message)
            result["vjp"] = memory, own is not None
            return result

        return made

    @staticmethod
    def keep(run):
        """Keep the steps of a Run that took several chunks, or whose code was compared."""
        run.kept = kept_of(run)

    def finished(self, result, problem, ready, fun, args):
        """The result of a solve by a ReadyRun, with `vjp`; None if it needs the long way."""
        run, product = ready.run, self._product
        kept, run.kept = run.kept, None
        if not result.success:
            result["vjp"] = Failed(result.message)
            return result
        values = self._known[0].read(fun, args, product.bound.block.copy())
        given = ready.given(fun, args)
        if values is None or given is None:
            return None
        bound = product.bound
        pairs = zip([kind for kind, _ in bound.values], values, strict=True)
        product = product._replace(
            bound=frozen(bound.function, None, pairs, VJP, 2 * product.n, bound.at)
        )
        kept = kept or kept_in(problem, run.plan, *result["vjp"])
        _compare(run, problem._replace(fun=fun, args=args), product, kept)
        return with_vjp(result, problem, run.bounds[0], given, product, self._directions, kept)


def _kept(run, result):
    if run.problem.t_eval is not None:
        return kept_of(run)
    t, y = result.t, result.y.T  # each step, which the user may change
    between = max(1, math.ceil(y.size / ROOM))
    return Kept(run.problem, t[1:].copy(), y[::between].copy(), between)


def _compare(run, problem, product, kept):
    """Compare the product with differences of the function, in solves 1, 2, 4, 8, ..."""
    p, notes = problem, product.bound.function.notes
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


class Failed:
    """The `vjp` of a solve that failed."""

    def __init__(self, message):
        self._message = message

    def __call__(self, g):
        raise ValueError(f"There are no derivatives of a solve that failed: {self._message}")
