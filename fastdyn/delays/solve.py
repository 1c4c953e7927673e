"""solve_dde: equations whose right-hand side reads the solution at earlier times."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from fastdyn.compile.bind import or_in_python
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.python_callback import called_with, evaluate
from fastdyn.kernels.output.arguments import RESIDUALS, SHORT, STAGES
from fastdyn.problem import validate
from fastdyn.problem.arguments import checked
from fastdyn.problem.options.table import value_of
from fastdyn.run.outcome import result_of
from fastdyn.run.solve_problem import run_of
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong
from fastdyn.words.near import did_you_mean

from .history import History
from .past import Past
from .points import Delays, delays_of, shorter_than_steps
from .run import DelayRun
from .sensitive import NEUTRAL, asked_directions, solved_in_parts

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import Args, Function, Functions, Times, TimeSpan
    from fastdyn.run.result import OdeResult

# Methods whose interpolant has the order of the method less one at least, and two for stiff
# equations; the interpolant of Radau has the order of its error estimate, 3.
EXPLICIT = ("Tsit5", "Vern7", "Vern9", "DOP853")
STIFF = ("Rodas5P", "Radau")
METHODS = (*EXPLICIT, *STIFF)
COUPLED = "Radau"  # its stages are coupled with the past within the step
OPTIONS = (
    "rtol", "atol", "max_step", "first_step", "on_event", "at", "every", "breakpoints", "max_steps",
    "progress", "on_interrupt", "compile", "sensitivity",
)  # fmt: skip
PRECISE = 1e-6  # relative tolerance below which "auto" takes the higher order
VANISHING = 1e-9  # share of the time below which a delay is zero: steps are not as short


@shown_when_wrong(
    fun=kinds.function_of("(t, y, past)"), t_eval=kinds.times, delays=kinds.times,
    jumps=kinds.times, dense_output=kinds.flag,
)  # fmt: skip
def solve_dde(
    fun: Function,
    t_span: TimeSpan,
    history: Any,
    method: str = "auto",
    t_eval: Times | None = None,
    dense_output: bool = False,
    events: Functions | None = None,
    args: Args = (),
    delays: Times | None = None,
    jumps: Times | None = None,
    **options: Any,
) -> OdeResult:
    """Solve ``y' = fun(t, y, past)``, where ``past(t - tau)`` is the state at an earlier time.

    Parameters
    ----------
    fun : callable
        ``fun(t, y, past, *args)`` returns n numbers.  ``past(s)`` is an array of the n components
        at a time s before t, ``past(s)[1]`` one of them, ``past.derivative(s)`` the array of their
        derivatives (neutral equations).  Delays may be constants, arguments, or
        depend on the time and the state.
    t_span : (float, float)
        Start and end, in this order.
    history : array_like, callable or OdeResult
        The state up to the start: n numbers, a function ``history(t)``, or the result of an earlier
        solve with ``dense_output=True``, which goes on.  A neutral equation takes the derivative of
        a function from its trace, or ``history.derivative(t)``.
    method : str
        "auto" (Vern7 for `rtol` below 1e-6, neutral equations and sensitivities, else Tsit5),
        "Tsit5", "Vern7", "Vern9" or "DOP853", for stiff equations "Rodas5P" or "Radau", for neutral
        ones "Vern7" or "Vern9".  Other methods do not interpolate as precisely as they step.
    t_eval, dense_output, args
        As in `solve_ivp`.
    events : callable or Schedule or list of these, optional
        As in `solve_ivp`, called as ``event(t, y, past, *args)``, and so are the functions of
        `on_event`.
    delays : array_like of float, optional
        The constant delays of a function that cannot be traced; the trace of a function has them.
    jumps : array_like of float, optional
        Times, before or after the start, at which the history or the equations jump.  (Switching
        times of a traced function are found, and those of an earlier result are known.)
    **options
        `rtol`, `atol`, `max_step`, `first_step`, `on_event`, `at`, `every`, `breakpoints`,
        `max_steps`, `progress`, `on_interrupt` and `compile`, as in `solve_ivp`; `sensitivity`,
        names of arguments, delays among them, and "history", if the history is constant.

    Returns
    -------
    OdeResult
        As of `solve_ivp`; `delays` has the constant delays, `jumps` the times at which the
        solution, or a low derivative, jumps, and which the delays carry on.

    Raises
    ------
    ValueError, TypeError
        Arguments that make no sense; a delay that is not positive at the start; a function without
        a trace, and without `delays`.

    Notes
    -----
    Where the solution begins, a derivative jumps, and each delay carries the jump on, one
    derivative higher: steps end at these times, up to the order of the method.  A jump of y' that
    `past.derivative` carries on stays one, throughout the span.  Jumps that
    varying delays, and switches on the state or the past, bring are not known before: there, and in
    neutral equations, the residual of the interpolant is bounded by two tolerances at three times
    of each step, and a step over a jump is taken again, shorter.

    No step is longer than the shortest constant delay, unless the delay is shorter than 1e-4 of the
    span.  A step that contains its own past, because a delay vanishes or is as short, is taken
    again with its own interpolant until the interpolant changes by less than 0.03 tolerances, at
    most 12 times, then shorter.  All steps are kept, since any of them may be asked for.
    """
    _refuse(options)
    t0, tf = validate.time_span(t_span)
    if not t0 < tf < math.inf:
        raise ValueError(f"`t_span` must be finite and ascend; got ({t0}, {tf}).")
    if method != "auto" and method not in METHODS:
        known = f"choose from auto, {', '.join(METHODS)}, whose interpolants are precise enough."
        meant = did_you_mean(method, METHODS, form='"{}"') or known
        raise ValueError(f"`method={method!r}` does not solve delay equations; {meant}")
    args = validate.extra_arguments(args)
    before = History(history, t0, tf, args)
    n = before.n

    def equations(t, y, laid_out, *args):
        return fun(t, y, Past(laid_out, t, n), *args)

    functools.update_wrapper(equations, fun)
    given_args = before.laid_out, *args
    with before:
        slope = evaluate(called_with(equations, given_args), DERIVATIVE, t0, before.y0.copy())
    if method == "auto":
        precise = (
            before.neutral
            or "sensitivity" in options
            or np.min(value_of(options, "rtol")) < PRECISE
        )
        method = "Vern7" if precise else "Tsit5"
    asked = checked(
        equations, t_span, before.y0, method, t_eval, True,
        events, False, given_args, options,
    )  # fmt: skip
    problem = _with_past(validate.problem(asked, validate.method_named(method), DERIVATIVE), n)
    directions = None
    if asked.sensitivity is not None:
        if problem.acts or any(each.jump is not None for each in problem.schedules):
            raise ValueError(
                "`sensitivity` and `on_event` do not go together in a delay equation: the jumps "
                "come back at times that vary with the directions."
            )
        if jumps is not None:
            raise ValueError(
                "`sensitivity` and `jumps` do not go together: the jumps come back at times that "
                "vary with the directions."
            )
        directions = asked_directions(asked.sensitivity, fun, before, args)
    given = None if delays is None else np.unique(np.asarray(delays, float))
    starts = [*before.jumps, *([] if jumps is None else np.asarray(jumps, float).ravel().tolist())]

    def solved(run):
        return _solved(run, before, given, [t0, *starts], slope)

    def solve():
        before.still(True)
        if directions is None:
            return solved(run_of(problem, DelayRun))
        return solved_in_parts(problem, before, directions, solved)

    with before:
        result = or_in_python(solve)
        _tell_vanishing(result, equations, asked.args, before)
    result["history"] = before
    if not dense_output:
        result["sol"] = None
    return result


def _refuse(options):
    for name in options:
        if name not in OPTIONS:
            raise TypeError(
                f"`solve_dde` takes no `{name}`; its options are {', '.join(OPTIONS)}. "
                f"{did_you_mean(name, (*OPTIONS, 'delays', 'jumps', 't_eval', 'events'))}".rstrip()
            )


def _with_past(problem, n):
    """The problem, whose events and actions get the past."""

    def longer(function):
        @functools.wraps(function)
        def with_past(t, y, laid_out, *args):
            return function(t, y, Past(laid_out, t, n), *args)

        return with_past

    p = problem
    events = p.events and [e.like(longer(e.function)).acting(longer) for e in p.events]
    schedules = [each._replace(jump=each.jump and longer(each.jump)) for each in p.schedules]
    return p._replace(events=events, schedules=tuple(schedules))


def _tell_vanishing(result, equations, args, history):
    """Say that a delay vanishes or is negative, if that is why no step was short enough."""
    if result.status != -1:
        return
    t = float(result.t[-1])
    y = result.y[:, -1].copy()
    with history.asked() as times:
        equations(t, y, *args)
    shortest = min((t - s for s in times), default=math.inf)
    near = VANISHING * max(abs(t), abs(t - history.t0))
    if shortest < -near:
        result["message"] = (
            f"a delay is negative behind t = {t:.10g}: `past` is for times before t; end the span "
            "before, or keep the delay above zero."
        )
    elif shortest <= near:
        result["message"] = (
            f"a delay vanishes at t = {t:.10g}: the iteration of a step that contains its own past "
            "does not converge there. End the span before, or keep the delay above zero."
        )


def _delays(run, history, given):
    """The Delays of a Run: those of the trace, or those that are `given`.

    Raises
    ------
    ValueError
    """
    p = run.problem
    known = delays_of(run.bounds[0], p.t0, history.y0)
    if given is not None:
        constant = tuple(given.tolist())
        neutral = history.neutral if known is None else known.derivatives
        varying = known is None or known.varying
        decides = known is None or known.decides
        return Delays(constant, varying, constant if neutral else (), neutral, decides)
    if known is None:
        raise ValueError(
            f"the delays of `{p.fun.__name__}` are not known, because it cannot be traced: give "
            "`delays=`, the constant ones (`delays=[]` if all vary)."
        )
    return known


def _looks(p, known):
    """How steps are looked at: the bits of PAST_LOOKS."""
    looks = SHORT if known.varying or shorter_than_steps(known.constant, p) else 0
    unseen = known.varying or known.derivatives or known.decides  # jumps may be
    if unseen and p.method.name not in STIFF:  # where errors are small, residuals are not
        looks |= RESIDUALS
    if p.method.name == COUPLED and (known.constant or known.varying):
        looks |= STAGES
    return looks


def _solved(run, history, given, starts, slope):
    """The result of a Run that follows the jumps of its solution."""
    p = run.problem
    known = _delays(run, history, given)
    delays = known.constant
    if known.derivatives and p.method.name not in NEUTRAL:
        raise ValueError(
            f"`method={p.method.name!r}` does not solve neutral equations, which read "
            f"`past.derivative`: choose from auto, {', '.join(NEUTRAL)}, whose interpolants have "
            "precise derivatives."
        )
    acts = p.acts or any(each.jump is not None for each in p.schedules)
    if known.derivatives and acts:
        raise ValueError(
            "`on_event` and `past.derivative` do not go together: where the state jumps, its "
            "derivative is an impulse, which comes back after each delay."
        )
    if delays and not delays[0] > 0.0:
        raise ValueError(
            f"a delay is {delays[0]:.10g}: `past` is for times before t; use `y` at t, and no "
            "later time."
        )
    carried = run.begin_with(p, known, starts, _looks(p, known), slope)
    p = run.problem
    status = run.solve(p.y0)
    history.check()
    result = result_of(p, status, run)
    result["delays"] = np.array(delays)
    result["jumps"] = np.unique(carried.starts)
    return result
