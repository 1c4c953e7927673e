"""A delay equation, checked, and the Run that solves it, once or again with other values."""

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.bind import or_in_python
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.python_callback import called_with, evaluate
from fastdyn.compile.traced.known import Attempt
from fastdyn.kernels.output.arguments import GROWN, RESIDUALS, SHORT, STAGES
from fastdyn.kernels.state.record import Y
from fastdyn.problem import validate
from fastdyn.problem.arguments import checked
from fastdyn.problem.options.table import taken_by, value_of
from fastdyn.run.outcome import result_of
from fastdyn.run.solve_problem import run_of
from fastdyn.words import kinds
from fastdyn.words.near import did_you_mean

from .history import History
from .past import Past
from .points import Delays, delays_of, shorter_than_steps
from .run import DelayRun
from .sensitive import BOTH, NEUTRAL, OF_NEUTRAL, asked_directions, solved_in_parts

# Methods whose interpolant has the order of the method less one at least, and two for stiff
# equations; the interpolant of Radau has the order of its error estimate, 3.
EXPLICIT = ("Tsit5", "Vern7", "Vern9", "DOP853")
STIFF = ("Rodas5P", "Radau")
METHODS = (*EXPLICIT, *STIFF)
COUPLED = "Radau"  # its stages are coupled with the past within the step
NO_ZEROS = "Rodas5P"  # whose exact Jacobian does not have the past as present state
PRECISE = 1e-6  # relative tolerance below which "auto" takes the higher order
VANISHING = 1e-9  # share of the time below which a delay is zero: steps are not as short
KINDS = {  # of the arguments of `solve_dde` and `prepare_dde`
    "fun": kinds.function_of("(t, y, past)"), "t_eval": kinds.times, "delays": kinds.times,
    "jumps": kinds.times, "dense_output": kinds.flag,
}  # fmt: skip


NOT_BEFORE = "a delay is {:.10g}: `past` is for times before t; use `y` at t, and no later time."


class Given(NamedTuple):
    """The arguments of `solve_dde`, as the user gave them."""

    fun: Any
    t_span: Any
    history: Any
    method: Any
    t_eval: Any
    dense_output: Any
    events: Any
    args: Any
    delays: Any
    jumps: Any
    options: dict


class Equation:
    """A delay equation and its history, checked.

    Raises
    ------
    ValueError, TypeError
    """

    def __init__(self, given):
        fun, t_span, history, method, t_eval, dense_output, events, args, delays, jumps, _ = given
        options = dict(given.options)
        _refuse(options)
        t0, tf = validate.time_span(t_span)
        if not t0 < tf < math.inf:
            raise ValueError(f"`t_span` must be finite and ascend; got ({t0}, {tf}).")
        if method != "auto" and method not in METHODS:
            known = f"choose from auto, {', '.join(METHODS)}, whose interpolants are precise."
            meant = did_you_mean(method, METHODS, form='"{}"') or known
            raise ValueError(f"`method={method!r}` does not solve delay equations; {meant}")
        self.fun = fun
        self.args = validate.extra_arguments(args)
        self.history = before = History(history, t0, tf, self.args)
        equations = with_past(fun)
        longer = before.laid_out, *self.args
        with before:
            self._slope = evaluate(called_with(equations, longer), DERIVATIVE, t0, before.y0.copy())
        if method == "auto":
            slopes = before.neutral or "sensitivity" in options
            precise = slopes or np.min(value_of(options, "rtol")) < PRECISE
            method = "Vern7" if precise else "Tsit5"
        asked = checked(
            equations, t_span, before.y0, method, t_eval, True, events, False, longer, options
        )
        method = validate.method_named(method)
        problem = validate.problem(asked, method, DERIVATIVE)
        problem = problem._replace(ends_at_switches=True)  # of SciPy's methods, too
        self.problem = _with_events(problem)
        self.dense_output = dense_output
        self.directions = None
        if asked.sensitivity is not None:
            for name, jumping in (("on_event", _acts(self.problem)), ("jumps", jumps is not None)):
                if jumping:
                    raise ValueError(BOTH.format(name))
            if before.neutral:
                raise ValueError(OF_NEUTRAL)
            self.directions = asked_directions(asked.sensitivity, fun, before, self.args)
        self._given = None if delays is None else np.unique(np.asarray(delays, float))
        self._own_jumps = [] if jumps is None else np.asarray(jumps, float).ravel().tolist()
        self.run: Any = None  # of the last solve without sensitivities
        self._known: Any = None
        self._last: Any = None
        self._jumps: Any = None
        self._looks = 0

    @property
    def _starts(self):
        return [self.problem.t0, *self.history.jumps, *self._own_jumps]

    def solve(self):
        """The OdeResult."""
        before = self.history

        def solve():
            before.still(True)
            if self.directions is None:
                self.run = run_of(self.problem, DelayRun)
                return self._solved(self.run)
            return solved_in_parts(self.problem, before, self.directions, self._solved)

        with before:
            result = or_in_python(solve)
            self._tell_vanishing(result)
        if self.dense_output:
            before.completed(result)
        else:
            result["sol"] = None
        return result

    def _solved(self, run):
        """The result of a Run that follows the jumps of its solution."""
        self._last = run  # whose memory `past` reads, also behind the steps
        p = run.problem
        self._known = known = self._delays(run)
        delays = known.constant
        if known.derivatives and p.method.name not in NEUTRAL:
            raise ValueError(
                f"`method={p.method.name!r}` does not solve neutral equations, which read "
                f"`past.derivative`: choose from auto, {', '.join(NEUTRAL)}, whose interpolants "
                "have precise derivatives."
            )
        if known.derivatives and _acts(p):
            raise ValueError(
                "`on_event` and `past.derivative` do not go together: where the state jumps, its "
                "derivative is an impulse, which comes back after each delay."
            )
        if delays and not delays[0] > 0.0:
            raise ValueError(NOT_BEFORE.format(delays[0]))
        self._looks = looks_at(p, known)
        carried = run.begin_with(*self._begun(run, p, known))
        self.history.still(False)
        p = run.problem
        status = run.solve(p.y0)
        self.history.check()
        result = result_of(p._replace(dense_output=self.dense_output), status, run)
        result["delays"] = np.array(delays)
        result["jumps"] = self._jumps = np.unique(carried.starts)
        return result

    def _begun(self, run, problem, known):
        """The arguments of `DelayRun.begin_with`."""
        looks = looks_at(problem, known)
        return problem, known, self._starts, looks, self._slope, self._longest(run, known)

    def _longest(self, run, known):
        """The longest delay of all functions; None if all steps are to be kept.

        They are if a delay varies or is not known, and if they are read behind the end.
        """
        if self.dense_output or (self.directions is not None and self.problem.events is not None):
            return None
        if self._given is not None or any(bound.function is None for bound in run.bounds):
            return None
        t0 = run.problem.t0
        all_known = [known, *[delays_of(b, t0, self.history.y0) for b in run.bounds[1:]]]
        if any(each is None or each.varying for each in all_known):
            return None
        return max((tau for each in all_known for tau in each.constant), default=None)

    def _delays(self, run):
        """The Delays of a Run: those of the trace, or those that are given.

        Raises
        ------
        ValueError
        """
        p = run.problem
        given = self._given
        known = delays_of(run.bounds[0], p.t0, self.history.y0)
        if known is not None:  # a jump of the history comes back, too
            known = known._replace(decides=known.decides or self.history.decides)
            if p.method.name != NO_ZEROS and 0.0 not in known.neutral:
                known = known._replace(constant=tuple(filter(None, known.constant)))
        if given is not None:
            constant = tuple(given.tolist())
            neutral = self.history.neutral if known is None else known.derivatives
            varying = known is None or known.varying
            decides = known is None or known.decides
            of_state = known is None or known.of_state
            neutral_delays = constant if neutral else ()
            return Delays(constant, varying, neutral_delays, neutral, decides, of_state)
        if known is None:
            if 0.0 in self._asked(p.t0, self.history.y0):
                raise ValueError(NOT_BEFORE.format(0.0))
            attempt = Attempt(p.fun, p.args, p.mode, len(p.y0))
            refusal = attempt.facts().refusal
            attempt.forget_refusals()
            raise ValueError(
                f"the delays of `{p.fun.__name__}` are not known, because it cannot be traced"
                f"{f' ({refusal})' if refusal else ''}: give `delays=`, the constant ones "
                "(`delays=[]` if all vary)."
            )
        return known

    def _asked(self, t, y, problem=None):
        """The delays at which the function of a problem reads the past, in Python."""
        p = problem or self.problem
        with self.history.asked() as times:
            p.fun(t, y.copy(), *p.args)
        return [t - s for s in times]

    def _tell_vanishing(self, result, problem=None):
        """Say that a delay vanishes or is negative, if that is why no step was short enough.

        A repeated solve gives its `problem`.
        """
        if result.status != -1:
            return
        if self._last.turns:
            result["message"] = self._last.turns
            return
        run = self._last  # a result may have no times
        t = float(run.view("solve.state")["t"][0])
        y = run.view("solve.work")[Y, : len(self.problem.y0)].copy()
        shortest = min((tau for tau in self._asked(t, y, problem) if tau), default=math.inf)
        near = VANISHING * max(abs(t), abs(t - self.history.t0))
        if shortest < -near:
            result["message"] = (
                f"a delay is negative behind t = {t:.10g}: `past` is for times before t; end the "
                "span before, or keep the delay above zero."
            )
        elif shortest <= near:
            result["message"] = (
                f"a delay vanishes at t = {t:.10g}: the iteration of a step that contains its own "
                "past does not converge there. End the span before, or keep the delay above zero."
            )


def with_past(function):
    """A function of (t, y, past, *args) as one of (t, y, words, *args), with its name."""
    return functools.update_wrapper(longer_function(function), function)


def longer_function(function):
    """As `with_past`, without the name: what a trace reads is the same."""

    def longer(t, y, laid_out, *args):
        return function(t, y, Past(laid_out, t, y), *args)

    vars(longer).update(vars(function), __wrapped__=function, only_traced=True)
    return longer


def _with_events(problem):
    """The problem, whose events and actions get the past."""
    p = problem
    events = p.events and [e.like(with_past(e.function)).acting(with_past) for e in p.events]
    schedules = [each._replace(jump=each.jump and with_past(each.jump)) for each in p.schedules]
    return p._replace(events=events, schedules=tuple(schedules))


def looks_at(problem, known):
    """How steps are looked at: the bits of PAST_LOOKS."""
    p = problem
    looks = SHORT if known.varying or shorter_than_steps(known.constant, p) else 0
    unseen = known.varying or known.derivatives or known.decides  # jumps may be
    if unseen:
        looks |= RESIDUALS
    if p.method.name != COUPLED:
        looks |= 0 if unseen else GROWN
    elif known.constant or known.varying:
        looks |= STAGES
    return looks


def _acts(problem):
    return problem.acts or any(each.jump is not None for each in problem.schedules)


def _refuse(options):
    taken = taken_by("solve_dde")
    for name in options:
        if name not in taken:
            raise TypeError(
                f"`solve_dde` takes no `{name}`; its options are {', '.join(taken)}. "
                f"{did_you_mean(name, (*taken, 'delays', 'jumps', 't_eval', 'events'))}".rstrip()
            )
