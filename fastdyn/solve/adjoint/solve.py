"""Solutions whose derivatives a sweep back over the steps computes: `solve_ivp(adjoint=...)`."""

import math
from typing import Any

import numpy as np

from fastdyn.compile.derivatives.compare import compare_vjp
from fastdyn.compile.derivatives.sensitivities import decides, jump_of
from fastdyn.compile.derivatives.vjp import bind_vjp
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.sentences import GaveUp, Uncompilable
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near
from fastdyn.problem.events import without_functions
from fastdyn.problem.second_order_and_pairs import given_state
from fastdyn.problem.sensitivities import directions_of
from fastdyn.run.functions.compared import AT_FIRST, WHEN, Schedule, apart
from fastdyn.run.loop import Run
from fastdyn.run.outcome import results
from fastdyn.run.result import OdeResult
from fastdyn.run.solve_problem import followed, run_of

from ..sensitivities import JUMPS, not_differentiable
from .along import along_of
from .backward import backward_of
from .events import NO_EVENTS, frozen_of, of_events
from .keeping import ROOM, Keeping
from .legs import (
    end_with_step,
    leg_in,
    leg_of,
    legs_of,
    occurrences_of,
    outputs_of,
    steps_in,
)
from .plain import PlainVjp, Sweeps, Values
from .vjp import UNRESOLVED, Vjp, solved_again

EVENTS = (
    "`adjoint` takes events, and actions of `on_event`, in compiled code: those that run in Python "
    "may change what `fun` uses."
)


def solve_with_adjoint(problem, names):
    """The result of a problem, with the field `vjp`."""
    p = problem
    directions = directions_of(names, p.fun, p.y0, p.args, "adjoint")
    positions = tuple([d.position for d in directions if d.position])
    p = problem = p._replace(differentiated=positions)
    try:
        near = Near(p.t0, p.tf, given_state(p))
        method = p.method
        product = bind_vjp(p.fun, p.args, near, positions, p.mode, method.backward)
        backward_of(method.name, product)  # may refuse
        run = run_of(p, Run if p.t_eval is None else Keeping)
        bound = run.bounds[0]
        if bound.function is None or bound.function.traced is None:
            raise Uncompilable("it runs in Python")
        if any(each.function is None for each in run.bounds):
            raise ValueError(EVENTS)
        events = of_events(p, run, positions)
        result = OdeResult(followed(p, run))
        if not result.success or not result.n_accepted:
            result["vjp"] = Failed(result.message)
            return result
        legs = _legs(run, result, events)
        along = None
        if _compare(run, p, product, legs):
            along = along_of(p, directions)
    except (Uncompilable, GaveUp) as reason:
        raise not_differentiable("adjoint", problem, reason) from None
    if decides(product.bound):
        _refuse_jumps(product.bound, legs, result.status == 1)
    directions = [d._replace(value=np.empty(d.value.shape)) for d in directions]
    t = np.array(result.t, float)
    derivatives = (product, directions, events, along)
    result["vjp"] = vjp_of(t, run.problem, bound, bound.given, derivatives, legs)
    return result


def vjp_of(t, problem, bound, given, derivatives, legs):
    """The Vjp of a solve with outputs at the times t.

    `bound` are the equations, `given` the values of their parameters; `derivatives` are the
    product, the directions, an `events.OfEvents`, and an `along.Along` or None.
    """
    product, directions, events, along = derivatives
    own = frozen_of(bound, product.n, given)
    outputs = outputs_of(legs, t, problem.t_eval is None)
    problem = without_functions(problem)._replace(t_eval=t)
    return Vjp(problem, own, product, directions, events, legs, outputs, along)


class Again:
    """The part of `adjoint` in repeated solves of one kind of call; see `solve/repeated.py`."""

    def __init__(self, names):
        self._names = names
        self._known: Any = None
        self._directions: Any = None
        self._shapes: Any = None
        self._product: Any = None
        self._block: Any = None
        self._schedule: Any = None
        self._sweeps: Any = None
        self._copied: Any = None

    def run_of(self, problem):
        """A run of a problem whose steps can be read; Uncompilable if it needs the long way."""
        p = problem
        if p.t_eval is None and not p.method.error_order:
            raise Uncompilable("its last step goes beyond the end")
        found = directions_of(self._names, p.fun, p.y0, p.args, "adjoint")
        self._directions = [d._replace(value=np.empty(d.value.shape)) for d in found]
        self._shapes = [(d.position - 1, d.value.shape) for d in found if d.position]
        positions = tuple([d.position for d in found if d.position])
        near = Near(p.t0, p.tf, p.y0)
        self._product = bind_vjp(p.fun, p.args, near, positions, backward=p.method.backward)
        bound = self._product.bound
        self._block, self._schedule = bound.block.copy(), _schedule(bound)
        varying = tuple(sorted(positions))
        self._known = Attempt(p.fun, p.args, DERIVATIVE, len(p.y0), varying).known()
        run = run_of(p._replace(differentiated=positions), Run if p.t_eval is None else Keeping)
        if self._known is None or decides(self._product.bound):
            raise Uncompilable("its solves are looked at")
        if p.method.backward == "stages" and p.method.error_order:
            self._sweeps = Sweeps(p, self._product, self._directions)
            self._copied = [Values(each) for each in (run.bounds[0], bound)]
        return run

    def suits(self, args):
        """Whether arguments have the shapes of the directions."""
        for i, shape in self._shapes:
            if i >= len(args):
                return False
            value = args[i]
            if (() if value.__class__ is float else np.shape(value)) != shape:
                return False
        return True

    @staticmethod
    def results(problem, plan, own=None):
        """As `outcome.results`; the field `vjp` of a result has its memory, until `finished`.

        Without `t_eval`, the steps are the outputs.
        """
        make = results(problem, plan, own)

        def made(memory, *end):
            result = make(memory, *end)
            result["vjp"] = memory, own is not None
            return result

        return made

    @staticmethod
    def keep(run):
        """Keep the steps of a Run that took several chunks, or whose code was compared."""
        if run.problem.t_eval is not None:
            run.kept = legs_of(run)

    def finished(self, result, problem, ready, fun, args):
        """The result of a solve by a ReadyRun, with `vjp`; None if it needs the long way."""
        run = ready.run
        at_times = problem.t_eval is not None
        legs = None
        if at_times:
            legs = run.kept
            run.kept = None
        if not result.success:
            result["vjp"] = Failed(result.message)
            return result
        block = self._block.copy()
        values = self._known[0].read(fun, args, block)
        given = ready.given(fun, args)
        if values is None or given is None:
            return None
        taken = ready.taken()
        steps = None
        times = taken["t_eval"]
        if at_times:  # perhaps whole numbers, and kernels read floats
            times = times.astype(float)
            taken["t_eval"] = times
        if not at_times:
            if result.y.size > ROOM:
                return None
            times = result.t.copy()  # which the user may change, as `y`
            steps = times, result.y.T.copy()
        elif legs is None:
            memory, shared = result["vjp"]
            steps = steps_in(run.plan, memory, len(times), taken["t0"], ready.room, shared)
        if steps is not None and self._is_plain():
            self._schedule.left[0] -= 1
            blocks = run.bounds[0].block.copy(), block
            pairs = zip(self._copied, (given, values), blocks, strict=True)
            both = [copied.copied(*pair) for copied, *pair in pairs]
            solve = (*steps, taken["segments"], times, blocks)
            bound = run.bounds[0]

            def whole():
                p = problem._replace(y0=steps[1][0].copy(), **taken)
                return self._whole(times, p, bound, both, leg_in(p, *steps))

            result["vjp"] = PlainVjp(self._sweeps, solve, whole)
            return result
        p = problem._replace(y0=ready.room.copy(), **taken)
        legs = legs if steps is None else leg_in(p, *steps)
        own = p._replace(fun=fun, args=args)
        along = None
        if _compare(run, own, self._with(values), legs):
            with run.not_repeated():
                along = along_of(own, directions_of(self._names, fun, p.y0, args, "adjoint"))
        both = given, values
        result["vjp"] = self._whole(times, p, run.bounds[0], both, legs, along)
        return result

    def _is_plain(self):
        """Whether nothing is compared in the next solve."""
        plain = self._sweeps is not None and self._schedule.left[0] > 1
        return plain and UNRESOLVED not in self._product.bound.function.notes

    def _with(self, values):
        """The product with other outside values."""
        kinds = [kind for kind, _ in self._product.bound.values]
        return self._product.with_values([*zip(kinds, values, strict=True)])

    def _whole(self, times, problem, bound, both, legs, along=None):
        """The Vjp of a solve with the values of its equations and of their product."""
        given, values = both
        derivatives = self._with(values), self._directions, NO_EVENTS, along
        return vjp_of(times, problem, bound, given, derivatives, legs)


def _legs(run, result, events):
    if run.problem.t_eval is not None:
        return legs_of(run)
    constant = not run.problem.method.error_order
    if events.acts or (constant and run.problem.schedules):
        own = frozen_of(run.bounds[0], len(given_state(run.problem)))
        return legs_of(solved_again(run.problem, own, events.others))
    t, y = result.t, result.y.T  # each step, which the user may change
    between = max(1, math.ceil(y.size / ROOM))
    rows = np.arange(0, len(t), between)
    leg = leg_of(run.problem, t.copy(), rows, y[::between].copy(), *occurrences_of(run)[0])
    if result.status == 1 or constant:
        end_with_step(leg, run)
    return [leg]


def _compare(run, problem, product, legs):
    """Compare the product with differences of the function, in solves 1, 2, 4, 8, ...

    Returns whether the gradient is to be compared, too.
    """
    p = problem
    function = product.bound.function
    due = _schedule(product.bound).after_one()
    if due:
        leg = max(legs, key=lambda leg: len(leg.rows))
        chosen = apart(len(leg.states), AT_FIRST)
        with run.not_repeated():
            compare_vjp(product, p.fun, p.args, leg.t[leg.rows[chosen]], leg.states[chosen])
    return due or UNRESOLVED in function.notes


def _schedule(bound):
    """The Schedule of comparisons of a product."""
    return bound.function.notes.setdefault("compared", Schedule(WHEN))


def _refuse_jumps(bound, legs, ended):
    """Refuse a jump of the function along the solution, straight between the ends of steps.

    `ended` tells whether an event ended the solve.
    """
    for leg in legs:
        times = leg.t[leg.rows]
        states = leg.states
        sign = 1.0 if times[-1] >= times[0] else -1.0
        for last in leg.ends[:1] or leg.seen[-1:] * (ended and leg is legs[-1]):
            before = sign * times < sign * last.t  # the solution behind is none
            times = np.append(times[before], last.t)
            states = np.vstack([states[before], last.y])

        def solution(t, sign=sign, times=times, states=states):
            return np.array([np.interp(sign * t, sign * times, column) for column in states.T])

        at = jump_of(bound, times, solution) if len(times) > 1 else None
        if at is not None:
            raise ValueError(JUMPS.format(at).replace("sensitivities jump", "derivatives jump"))


class Failed:
    """The `vjp` of a solve that failed."""

    def __init__(self, message):
        self._message = message

    def __call__(self, g):
        raise ValueError(f"There are no derivatives of a solve that failed: {self._message}")
