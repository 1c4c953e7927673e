"""solve_ivp, solve_second_order, solve_separable: the story of one solve."""

from fastdyn.compile.bind import or_in_python
from fastdyn.problem import validate
from fastdyn.problem.equations import (
    check_pair,
    check_second_order,
    pair_of,
)
from fastdyn.run.assemble import run_of
from fastdyn.run.outcome import result_of

from .scipy_methods import by_scipy


def solve_ivp(
    fun,
    t_span,
    y0,
    method="RK45",
    t_eval=None,
    dense_output=False,
    events=None,
    vectorized=False,
    args=None,
    **options,
):
    """Solve y' = fun(t, y) from y(t0) = y0, with compiled code.

    Parameters, result and messages are those of `scipy.integrate.solve_ivp`; the differences:

    Parameters
    ----------
    method : str or OdeSolver
        Also "ode45" (the Dormand-Prince pair under MATLAB's step control), "RK4" and
        "VelocityVerlet" (constant steps; the latter for y = [q, v] with q'' = a(t, q)).
    breakpoints : array_like of float
        Times at which `fun` has a kink or a jump (sampled input, a switch): adaptive methods end
        a step there and begin anew, and so keep their order.
    project : callable
        ``project(t, y, *args)`` takes the state at the end of each step to where it should be,
        on its constraints or its energy, at the cost of one more evaluation of `fun`.  States at
        the times of `t_eval` are taken there too; those of `sol` are not.
    step : float
        Size of the constant steps.  Steps are never shortened: if the span is not a whole number
        of them, the last one overshoots and the end is interpolated.
    max_steps : int
        Stop with status -1 after so many accepted steps.
    progress : bool
        Show a progress bar.
    on_interrupt : {"raise", "return"}
        On Ctrl-C, raise KeyboardInterrupt, or return what there is with status -2.
    checkpoint : str or path
        A file, written every few seconds, whole or not at all, from which the same call goes on
        bit for bit after a crash or Ctrl-C.
    tier : {"auto", "pointer", "specialised"}
        "specialised" compiles the fastest kernel for this function before the solve.

    Returns
    -------
    OdeResult
        Also with `n_accepted` and `n_rejected`.

    Raises
    ------
    ValueError, TypeError
        Arguments that make no sense, and a derivative of the wrong length or type.

    Notes
    -----
    `fun` may be any Python callable.  What it uses from outside (arguments, closure variables,
    globals, attributes of `self`) is read anew at each call.  A function that Numba cannot
    compile is called in Python from the compiled kernels, with one CompileWarning.
    """
    ours = validate.method_named(method)
    y0 = validate.initial_state(y0)
    t0, tf = validate.time_span(t_span)
    if ours is None or y0.dtype.kind == "c" or y0.size == 0 or t0 == tf:
        return by_scipy(
            fun, t_span, y0, method, t_eval, dense_output, events, vectorized, args, options
        )
    mode = "column" if vectorized else "derivative"
    if ours.second_order:
        check_second_order(fun, t0, y0, validate.extra_arguments(args), ours.name)
        mode = "acceleration"
    problem = validate.problem(
        fun, t0, tf, y0, ours, t_eval, dense_output, events, args, mode, options
    )
    return _solve(problem)


def solve_second_order(
    accel,
    t_span,
    q0,
    v0,
    method="VelocityVerlet",
    t_eval=None,
    dense_output=False,
    events=None,
    args=None,
    **options,
):
    """Solve q'' = accel(t, q) from position q0 and velocity v0, at constant step.

    Parameters
    ----------
    accel : callable
        ``accel(t, q, *args)``, the acceleration, of the length m of q.
    t_span, t_eval, dense_output, events, args
        As in `solve_ivp`; events are functions of (t, y) with y = [q, v].
    q0, v0 : array_like, shape (m,)
    method : str
        One of the explicit symplectic methods, GaussNystrom8 or GaussNystrom16.
    **options
        `step` (required), `max_steps`, `progress`, `on_interrupt`, `tier`; see `solve_ivp`.

    Returns
    -------
    OdeResult
        `y` has shape (2 m, n_points), position over velocity.
    """
    ours = validate.method_named(method)
    if ours is None or not ours.second_order:
        known = ", ".join(name for name, m in validate.METHODS.items() if m.second_order)
        raise ValueError(f"`method={method!r}` does not solve q'' = a(t, q); these do: {known}.")
    problem = validate.problem(
        accel, *validate.time_span(t_span), validate.joined_state(q0, v0, "v0"), ours, t_eval,
        dense_output, events, args, "derivative", options,
    )  # fmt: skip
    return _solve(problem)


def solve_separable(
    velocity,
    force,
    t_span,
    q0,
    p0,
    method="VelocityVerlet",
    t_eval=None,
    dense_output=False,
    events=None,
    args=None,
    **options,
):
    """Solve q' = velocity(t, p), p' = force(t, q), the motion of H = T(p) + V(q).

    Parameters
    ----------
    velocity : callable
        ``velocity(t, p, *args)``, dT/dp, of the length m of p.
    force : callable
        ``force(t, q, *args)``, -dV/dq, of the length m of q.
    t_span, t_eval, dense_output, events, args
        As in `solve_ivp`; events are functions of (t, y) with y = [q, p].
    q0, p0 : array_like, shape (m,)
    method : str
        Any compiled method but the Nystrom ones, which are for q'' = a(t, q).  The explicit
        symplectic ones kick and drift in turn, so that each step evaluates both functions
        equally often; `nfev` counts one for both.
    **options
        As in `solve_ivp`; `step` is required by methods with constant steps.

    Returns
    -------
    OdeResult
        `y` has shape (2 m, n_points), positions over momenta.
    """
    ours = validate.method_named(method)
    if ours is None:
        raise ValueError(f"`method={method!r}` is SciPy's; solve_separable needs a compiled one.")
    y0, pair = validate.joined_state(q0, p0, "p0"), pair_of((velocity, force))
    check_pair(len(y0), ours)
    problem = validate.problem(
        pair, *validate.time_span(t_span), y0, ours, t_eval, dense_output, events, args,
        "derivative", options,
    )  # fmt: skip
    return _solve(problem)


def _solve(problem):
    def solve():
        run = run_of(problem)
        return result_of(problem, run.solve(), run)

    return or_in_python(solve)
