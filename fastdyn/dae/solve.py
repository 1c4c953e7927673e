"""solve_dae: integrate one differential-algebraic equation F(t, y, y') = 0."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fastdyn.compile.bind import or_in_python
from fastdyn.problem.options.docstrings import filled
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .breakpoints import Breakpoints
from .discrete import solve_with_discrete
from .index import HighIndexError, not_reduced
from .problem import check_options, checked, problem_of_residual
from .reduced.solve import solve_reduced
from .result import result_of
from .start import run_of
from .switching import with_breakpoints
from .tangent.solve import solve_with_sensitivities

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import (
        Args,
        Function,
        Functions,
        State,
        Times,
        TimeSpan,
    )
    from fastdyn.run.result import OdeResult

LARGEST = 200  # equations whose index is reduced unasked: the work grows with the cube


@shown_when_wrong(dense_output=kinds.flag)
@filled("solve_dae")
def solve_dae(
    F: Function,
    t_span: TimeSpan,
    y0: State,
    yp0: State | None = None,
    *,
    method: str | None = None,
    t_eval: Times | None = None,
    dense_output: bool = False,
    events: Functions | None = None,
    args: Args | None = None,
    given: Any = None,
    **options: Any,
) -> OdeResult:
    """Solve F(t, y, y') = 0 from y(t0) = y0, with compiled code.

    Equations of index 0 and 1 are solved by BDF of orders 1 to 5 with variable steps, as in DASSL
    and IDA.  Equations of a higher index, such as those of mechanics with constraints on positions,
    are differentiated until they determine all derivatives; see `reduce_index`.

    Parameters
    ----------
    F : callable
        ``F(t, y, yp, *args)`` returns the residual, n numbers; `t` is a float, `y` and its
        derivative `yp` are ndarrays of shape (n,).  Any Python callable; a function that does not
        compile runs in Python, with one CompileWarning.
    t_span : pair of float
        Start and end; the end may lie before the start.
    y0, yp0 : array_like, shape (n,)
        The state and its derivative at the start, or guesses of what `given` lets be computed.
        Without `yp0`, the guess is 0, and `given` is "differential".
    method : str, optional
        "BDF", or a method of `solve_ivp` that solves the equations behind an index reduction: one
        that takes `project`.  By default BDF if the index is 0 or 1, otherwise DOP853.
    t_eval, dense_output, args
        As in `solve_ivp`.
    events : callable or sequence of callable, optional
        ``event(t, y, *args)``, as in `solve_ivp`.
    given : {None, "differential", "y", "yp"} or sequence of int or bool, optional
        What of the start is held; Newton's iteration changes the rest until F = 0.  None: all, and
        a start with F != 0 raises ValueError.  "differential": the components of `y0` whose
        derivatives occur in F; the other components and all derivatives are computed.  "y":
        all of `y0`.  "yp": all of `yp0`.  Numbers: these components of
        `y0`.  2 n booleans: what they mark, of `y0` and then `yp0`.
        At a higher index, what the other components determine, and `yp0`, are guesses in any case;
        numbers hold components of `y0`, and without them a start that violates the constraints is
        refused.
    **options
        {options}, as in `solve_ivp`; `step` and `compile` with a `method` alone.
        The error of all components is controlled, algebraic ones included.
        A function of `on_event` returns `y`; behind the event, its
        differential components are held, and the others and `yp` are computed, in Python.  At a
        higher index all constraints hold behind the event; `given` says what is held.  With
        `discrete`, F is ``F(t, y, yp, d, *args)``.  At `breakpoints` of F, its differential
        components are held; the result has the time twice.  The derivatives of `sensitivity` by
        `y0` are those by the components that are held, by default by those whose derivatives occur
        in F; at a higher index, a direction of `y0` is the nearest that the constraints allow.

    Returns
    -------
    OdeResult
        The fields of `solve_ivp`, and `yp`, of the shape of `y`, `yp_events` and `index`; at a
        higher index `differentiated` and `states` instead of `yp_events`.  `nfev` counts
        all evaluations of F, those for differences included.  ``sol.derivative(t)`` is the
        derivative of the polynomial ``sol(t)``.

    Raises
    ------
    ValueError, TypeError
        For wrong arguments, for a start that is not consistent, for equations that are singular,
        and for an `F` of a higher index that cannot be traced.

    Notes
    -----
    The Jacobians dF/dy and dF/dy' of a traced F are exact, others are by differences.  The
    polynomials of `sol` have the order of the steps, their derivatives one less.

    Examples
    --------
    >>> def circuit(t, y, yp):
    ...     return [yp[0] + y[0] - y[1], y[0] + y[1] - math.sin(t)]
    >>> result = solve_dae(circuit, (0, 10), [0.0, 0.0], rtol=1e-6, atol=1e-9)
    """

    if options.get("discrete") is not None:
        arguments = {
            "F": F, "t_span": t_span, "y0": y0, "yp0": yp0, "method": method, "t_eval": t_eval,
            "dense_output": dense_output, "events": events, "args": args, "given": given,
        }  # fmt: skip
        return solve_with_discrete(solve_dae, arguments, options)
    options.pop("discrete", None)
    check_options(options)
    asked = checked(F, t_span, y0, yp0, t_eval, dense_output, events, args, given, options)
    asked = or_in_python(lambda: with_breakpoints(asked))
    if method not in (None, "BDF"):
        return solve_reduced(asked, method)
    try:
        return or_in_python(lambda: _by_residual(asked))
    except HighIndexError as found:
        if method is not None or asked.n > LARGEST:
            raise
        reason = found
    try:
        return solve_reduced(asked, "DOP853")
    except ValueError as why:
        raise not_reduced(reason, why) from None


def _by_residual(asked):
    """The OdeResult of BDF; HighIndexError if the index is above 1."""
    problem = problem_of_residual(asked)
    breakpoints = Breakpoints.of(problem, asked.options)
    if asked.directions is not None:
        return solve_with_sensitivities(asked, problem, breakpoints)
    run, index = run_of(problem, asked.held, breakpoints)
    result = result_of(run.problem, run.solve(run.problem.y0), run, index)
    return result if breakpoints is None else breakpoints.of_result(result)
