"""Motions in two halves: q'' = a(t, q), and q' = v(t, p), p' = f(t, q)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fastdyn.compile.mode import DERIVATIVE
from fastdyn.problem import validate
from fastdyn.problem.arguments import Arguments
from fastdyn.problem.options.docstrings import filled
from fastdyn.problem.second_order_and_pairs import check_pair, pair_of
from fastdyn.problem.sensitivities import check_method
from fastdyn.run.solve_problem import solve_problem
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .sensitivities import solve_with_sensitivities

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import (
        Args,
        Function,
        Functions,
        Method,
        State,
        Times,
        TimeSpan,
    )
    from fastdyn.run.result import OdeResult


@shown_when_wrong(accel=kinds.function_of("(t, q)"), dense_output=kinds.flag)
@filled("solve_second_order")
def solve_second_order(
    accel: Function,
    t_span: TimeSpan,
    q0: State,
    v0: State,
    method: Method = "VelocityVerlet",
    t_eval: Times | None = None,
    dense_output: bool = False,
    events: Functions | None = None,
    args: Args | None = None,
    *,
    step: float,
    **options: Any,
) -> OdeResult:
    """Solve q'' = accel(t, q) from position q0 and velocity v0, at constant step.

    Parameters
    ----------
    accel : callable
        ``accel(t, q, *args)`` returns the acceleration, m numbers for q of shape (m,).
    t_span, t_eval, dense_output, events, args
        As in `solve_ivp`; events are functions of (t, y) with y = [q, v].
    q0, v0 : array_like, shape (m,)
        Initial positions and velocities.
    method : str
        One of the explicit symplectic methods, GaussNystrom8 or GaussNystrom16.
    step : float
        Size of the constant steps.
    **options
        As in `solve_ivp`, except {refused}, and what is for adaptive methods.

    Returns
    -------
    OdeResult
        `y` has shape (2 m, n_points), position over velocity.

    Raises
    ------
    ValueError, TypeError
        For wrong arguments, and for a method that does not solve q'' = a(t, q).
    """
    ours = validate.method_named(method)
    if ours is None or not ours.second_order:
        known = ", ".join(name for name, m in validate.METHODS.items() if m.second_order)
        raise ValueError(f"`method={method!r}` does not solve q'' = a(t, q); these do: {known}.")
    t0, tf = validate.time_span(t_span)
    sensitivity = options.pop("sensitivity", None)
    asked = Arguments(
        fun=accel, t0=t0, tf=tf, y0=validate.joined_state(q0, v0, "v0"), t_eval=t_eval,
        dense_output=dense_output, events=events, args=validate.extra_arguments(args),
        options={"step": step, **options},
    )  # fmt: skip
    if sensitivity is None:
        return solve_problem(validate.problem(asked, ours, DERIVATIVE))
    check_method(asked, ours)
    return solve_with_sensitivities(validate.problem(asked, ours, DERIVATIVE), sensitivity)


@shown_when_wrong(dense_output=kinds.flag)
@filled("solve_separable")
def solve_separable(
    velocity: Function,
    force: Function,
    t_span: TimeSpan,
    q0: State,
    p0: State,
    method: Method = "VelocityVerlet",
    t_eval: Times | None = None,
    dense_output: bool = False,
    events: Functions | None = None,
    args: Args | None = None,
    **options: Any,
) -> OdeResult:
    """Solve q' = velocity(t, p), p' = force(t, q), the motion of H = T(p) + V(q).

    Parameters
    ----------
    velocity : callable
        ``velocity(t, p, *args)`` returns dT/dp, m numbers for p of shape (m,).
    force : callable
        ``force(t, q, *args)`` returns -dV/dq, m numbers for q of shape (m,).
    t_span, t_eval, dense_output, events, args
        As in `solve_ivp`; events are functions of (t, y) with y = [q, p].
    q0, p0 : array_like, shape (m,)
        Initial positions and momenta.
    method : str
        Any compiled method except the Nystrom methods, which are for q'' = a(t, q).  The steps of
        the explicit symplectic methods evaluate both functions equally often; `nfev` counts an
        evaluation of both as one.
    **options
        As in `solve_ivp`, except {refused}; `step` is required by methods with constant steps.

    Returns
    -------
    OdeResult
        `y` has shape (2 m, n_points), positions over momenta.

    Raises
    ------
    ValueError, TypeError
        For wrong arguments, and for a method that is not for H = T(p) + V(q).
    """
    ours = validate.method_named(method)
    if ours is None:
        raise ValueError(
            f"`method={method!r}` is SciPy's; solve_separable needs a compiled method."
        )
    y0 = validate.joined_state(q0, p0, "p0")
    pair = pair_of((velocity, force))
    check_pair(len(y0), ours)
    t0, tf = validate.time_span(t_span)
    asked = Arguments(
        fun=pair, t0=t0, tf=tf, y0=y0, t_eval=t_eval, dense_output=dense_output, events=events,
        args=validate.extra_arguments(args), options=options,
    )  # fmt: skip
    return solve_problem(validate.problem(asked, ours, DERIVATIVE))
