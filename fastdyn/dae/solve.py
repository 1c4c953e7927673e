"""solve_dae: integrate one differential-algebraic equation F(t, y, y') = 0."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fastdyn.compile.bind import or_in_python

from .problem import checked
from .result import result_of
from .start import run_of

if TYPE_CHECKING:
    from fastdyn.problem import argument_types as types
    from fastdyn.run.result import OdeResult


def solve_dae(
    F: types.Function,
    t_span: types.TimeSpan,
    y0: types.State,
    yp0: types.State | None = None,
    *,
    t_eval: types.Times | None = None,
    dense_output: bool = False,
    events: types.Functions | None = None,
    args: types.Arguments | None = None,
    given: Any = None,
    **options: Any,
) -> OdeResult:
    """Solve F(t, y, y') = 0, of index 1, from y(t0) = y0, with compiled code.

    The method is BDF of orders 1 to 5 with variable steps, as in DASSL and IDA.

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
    t_eval, dense_output, args
        As in `solve_ivp`.
    events : callable or sequence of callable, optional
        ``event(t, y, *args)``, as in `solve_ivp`.
    given : {None, "differential", "y", "yp"} or array_like of bool, shape (2 n,)
        What of the start is held; Newton's iteration changes the rest until F = 0.  None: all, and
        a start with F != 0 raises ValueError.  "differential": the components of `y0` whose
        derivatives occur in F; the other components and all derivatives are computed.  "y":
        all of `y0`.  "yp": all of `yp0`.  An array: what it marks, of `y0` and then `yp0`.
    **options
        `rtol`, `atol`, `max_step`, `first_step`, `on_event`, `max_steps`, `progress` and
        `on_interrupt`, as in `solve_ivp`.  The error of all components is controlled, algebraic
        ones included.  A function of `on_event` returns `y`; behind the event, its differential
        components are held, and the others and `yp` are computed, in Python.

    Returns
    -------
    OdeResult
        The fields of `solve_ivp`, and `yp`, of the shape of `y`, and `yp_events`.  `nfev` counts
        all evaluations of F, those for differences included.  ``sol.derivative(t)`` is the
        derivative of the polynomial ``sol(t)``.

    Raises
    ------
    ValueError, TypeError
        For wrong arguments, for a start that is not consistent, and for equations whose index is
        above 1 at the start.

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
    problem, given = checked(
        F, t_span, y0, yp0, t_eval, dense_output, events, args, given, options
    )  # fmt: skip

    def solve():
        run = run_of(problem, given)
        return result_of(run.problem, run.solve(run.problem.y0), run)

    return or_in_python(solve)
