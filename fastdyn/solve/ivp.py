"""solve_ivp, solve_second_order, solve_separable: the story of one solve."""

import numpy as np

from fastdyn.compile.bind import bind, or_in_python
from fastdyn.compile.parameters import may_write
from fastdyn.compile.python_callback import evaluate
from fastdyn.compile.side_effects import CHANGED, depends
from fastdyn.kernels.state.record import FINISHED, INTERRUPTED
from fastdyn.problem import validate
from fastdyn.problem.equations import (
    Pair,
    bind_equations,
    check_pair,
    check_second_order,
    look_at,
    pair_of,
)
from fastdyn.run.dense_output import PiecewisePolynomial
from fastdyn.run.loop import Run, counters
from fastdyn.run.result import SUCCESS, OdeResult, outcome

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


_verified: set = set()


def _verify(bound, look, n):
    """Evaluate a function in Python the first time it meets a state of n, for its mistakes.

    Not one that could tell: it runs in Python, or may write to an array.
    """
    if bound.function is None:
        return
    place = (bound.function.address, n)
    if place not in _verified:
        if not any(may_write(k) for b in (bound, *bound.parts) for k, _ in b.values):
            look()
        _verified.add(place)


def _solve(problem):
    def solve():
        run = run_of(problem)
        return result_of(problem, run.solve(), run)

    return or_in_python(solve)


def run_of(problem):
    """A Run with the functions of a problem compiled, and evaluated once."""
    p = problem
    n = len(p.y0)
    bound, bound_events, projection = _bound(p)
    _verify(bound, lambda: look_at(p), n)
    if projection is not None:
        _verify(projection, lambda: evaluate(projection.python, "derivative", p.t0, p.y0.copy()), n)
    run = Run(p, bound, bound_events, projection)
    if p.mode == "acceleration" and bound.function is None:
        run.state["n_extra"] = 2  # evaluations by which `check_second_order` found its form
    return run


def _bound(problem):
    """The equations, the events and the projection of a problem, or None for the last."""
    p, n = problem, len(problem.y0)
    others = [(event, "event") for event, _, _ in p.events or ()]
    if p.project is not None:
        others.append((p.project, "derivative"))
    bound = bind_equations(p)
    bounds = [bind(fun, p.args, mode, n) for fun, mode in others]
    equations = list(p.fun) if isinstance(p.fun, Pair) else [p.fun]
    if others and (bound.function is None or any(b.function is None for b in bounds)):
        every = [(bound, equations), *((b, [f]) for b, (f, _) in zip(bounds, others, strict=True))]
        in_python = [f for b, functions in every if b.function is None for f in functions]
        if bound.function is not None and any(depends(f, in_python) for f in equations):
            bound = bind_equations(p, CHANGED)
        for i, (fun, mode) in enumerate(others):
            if bounds[i].function is not None and depends(fun, in_python):
                bounds[i] = bind(fun, p.args, mode, n, refused=CHANGED)
    projection = bounds.pop() if p.project is not None else None
    return bound, bounds, projection


def result_of(problem, status, run):
    """What is returned for a problem whose Run ended with this status."""
    p, state, output = problem, run.state, run.output
    if status == INTERRUPTED:
        code, message = -2, f"Interrupted at t = {state[0]['t']:.10g}; the result ends there."
    elif status == FINISHED:
        code, message = 0, SUCCESS
    else:
        code, message = outcome(status, state, run.work, p)
    t, y = output.points()
    sol = None
    if p.dense_output:
        polynomials, spans = output.polynomials()
        if len(polynomials):
            ends = np.append(spans[:, 0], t[-1] if p.t_eval is None else spans[-1].sum())
            sol = PiecewisePolynomial(ends, polynomials, spans)
    t_events = y_events = None
    if p.events is not None:
        t_events, y_events = output.occurrences()
    y = y.T
    if p.t_eval is not None:
        t = p.t_eval[: len(t)].copy()
        if not len(t):
            t, y = [], []
    n_accepted, n_rejected, n_extra = counters(state)
    nfev = n_extra + p.method.n_stages * (n_accepted + n_rejected)
    return OdeResult(
        t=t, y=y, sol=sol, t_events=t_events, y_events=y_events, nfev=nfev, njev=0, nlu=0,
        status=code, message=message, success=code >= 0,
        n_accepted=n_accepted, n_rejected=n_rejected,
    )  # fmt: skip
