"""solve_separable: q' = v(t, p), p' = f(t, q), the motion of H = T(p) + V(q)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fastdyn.compile.mode import DERIVATIVE
from fastdyn.problem import validate
from fastdyn.problem.arguments import Arguments
from fastdyn.problem.options.docstrings import filled
from fastdyn.problem.second_order_and_pairs import check_pair, pair_of
from fastdyn.run.solve_problem import solve_problem
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

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
    y0, pair = validate.joined_state(q0, p0, "p0"), pair_of((velocity, force))
    check_pair(len(y0), ours)
    t0, tf = validate.time_span(t_span)
    asked = Arguments(
        fun=pair, t0=t0, tf=tf, y0=y0, t_eval=t_eval, dense_output=dense_output, events=events,
        args=validate.extra_arguments(args), options=options,
    )  # fmt: skip
    return solve_problem(validate.problem(asked, ours, DERIVATIVE))
