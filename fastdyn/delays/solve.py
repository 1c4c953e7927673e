"""solve_dde: equations whose right-hand side reads the solution at earlier times."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fastdyn.words.calls import shown_when_wrong

from . import repeated
from .again import RepeatedEquation
from .equation import KINDS, Given

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import Args, Function, Functions, Times, TimeSpan
    from fastdyn.run.result import OdeResult


@shown_when_wrong(**KINDS)
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
        at a time s up to t, ``past(s)[1]`` one of them, ``past.derivative(s)`` the array of their
        derivatives (neutral equations); of an array of times, the times are behind the components.
        Delays may be constants, arguments, or depend on the time and the state.
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
        `max_steps`, `progress`, `on_interrupt`, `checkpoint` and `compile`, as in
        `solve_ivp`; `sensitivity`, names of arguments, delays among them, and "history", if the
        history is constant.

    Returns
    -------
    OdeResult
        As of `solve_ivp`; `sol` has the history, too; `delays` has the constant delays, `jumps`
        the times at which the solution, or a low derivative, jumps, and which the delays carry on.

    Raises
    ------
    ValueError, TypeError
        Arguments that make no sense; a delay that is negative at the start; a function without
        a trace, and without `delays`.

    Notes
    -----
    Where the solution begins, a derivative jumps, and each delay carries the jump on, one
    derivative higher: steps end at these times, up to the order of the method.  A jump of y' that
    `past.derivative` carries on stays one, throughout the span.  Jumps that varying delays,
    switches on the state or the past, and histories that decide by the time or run in Python bring
    are not known before: there, and in neutral equations, the residual of the interpolant (with
    Rodas5P and Radau, its error by the residual) is bounded by two tolerances, with Radau by 30, at
    three times of each step, and a step over a jump is taken again, shorter.  Where components as
    small as their tolerances decide a delay, its time may run to and fro: the solve ends with a
    message, or warns.

    No step is longer than the shortest constant delay, unless the delay is shorter than 1e-4 of the
    span.  A step that contains its own past, because a delay vanishes or is as short, is taken
    again with its own interpolant until the interpolant changes by less than 0.03 tolerances, at
    most 12 times, then shorter.  Steps are kept as long as a delay may read them; where all delays
    are constants or arguments, and `dense_output` is not asked, older ones are dropped from 8 MB
    on.  Where delays vary, all are kept, up to half of the machine's memory.
    """
    given = Given(
        fun, t_span, history, method, t_eval, dense_output, events, args, delays, jumps, options
    )
    key = repeated.key_of(given)
    result = repeated.solved(key, fun, history, args)
    if result is None:
        equation = RepeatedEquation(given)
        result = equation.solve()
        repeated.keep(key, equation, fun, history)
    return result
