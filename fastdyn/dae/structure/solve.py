"""Solves F(t, y, y') = 0 of any index by index reduction."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fastdyn.problem.validate import (
    extra_arguments,
    initial_state,
    method_named,
    output_times,
    time_span,
)

from .compare import check_with_function
from .reduction import Reduction
from .run import run
from .start import consistent, guess

if TYPE_CHECKING:
    from fastdyn.problem import argument_types as types
    from fastdyn.run.result import OdeResult

TAKEN = {
    "rtol", "atol", "max_step", "first_step", "max_steps", "step", "breakpoints", "compile",
}  # fmt: skip


def reduce_index(
    fun: Callable,
    y0: types.State,
    yp0: types.State | None = None,
    args: types.Arguments | None = None,
    t0: float = 0.0,
) -> Reduction:
    """Analyse and reduce the index of ``fun(t, y, yp, *args) = 0``, from a plain Python function.

    The function is traced. Its equations are differentiated by time, exactly, as often as their
    structure says, so that they determine the derivative of each component.

    Parameters
    ----------
    fun : callable
        ``fun(t, y, yp, *args)`` returns n residuals for n components of y and their derivatives.
    y0, yp0 : array_like, shape (n,)
        A state near which the function is called; `yp0` is zero by default.

    Returns
    -------
    Reduction
        With `index`, `differentiated` and `freedom`.

    Raises
    ------
    ValueError
        If the structure is singular, or the function cannot be traced.
    """
    y0, args = initial_state(y0), extra_arguments(args)
    yp0 = _derivative(yp0, y0)
    _probe(fun, t0, y0, yp0, args)
    return Reduction(fun, float(t0), y0, yp0, args)


def solve_reduced(
    fun: Callable,
    t_span: types.TimeSpan,
    y0: types.State,
    yp0: types.State | None = None,
    method: str = "DOP853",
    t_eval: types.Times | None = None,
    dense_output: bool = False,
    events: types.Functions | None = None,
    args: types.Arguments | None = None,
    given: Sequence[int] | None = None,
    **options: Any,
) -> OdeResult:
    """Solve ``fun(t, y, yp, *args) = 0`` of any index by index reduction.

    The derivatives of all states are computed from the equations and their derivatives, by
    compiled code, and integrated by a method of `solve_ivp`. After each step the states are held,
    and all other components follow from the constraints, hidden ones included. The states are
    chosen at the start, and anew where the others would change too much with them.

    Parameters
    ----------
    fun : callable
        ``fun(t, y, yp, *args)`` returns n residuals; fun must be traceable.
    t_span : pair of float
    y0, yp0 : array_like, shape (n,)
        The start. Components that the others determine, such as forces of constraints, are
        guesses; so is all of `yp0`, zero by default.
    method : str
        A method of `solve_ivp` that takes `project`: an adaptive explicit method, "Taylor",
        "Radau" or "Rodas5P".
    t_eval, dense_output, events, args
        As for `solve_ivp`; events are functions of all components of y.
    given : sequence of int, optional
        The components of y0 that keep their values; the others are guesses and move to the nearest
        consistent start. By default, a start that violates the constraints is refused.
    **options
        `rtol`, `atol`, `max_step`, `first_step`, `max_steps`, `step`, `breakpoints`, `compile` of
        `solve_ivp`.

    Returns
    -------
    OdeResult
        Of `solve_ivp`, with y of all components; `yp`, their derivatives, nan where the equations
        have none; `index`, the structural index;
        `differentiated`, how often each equation was differentiated; `states`, a list of (time,
        components that are states from there on), where n l + j stands for derivative l of
        component j.

    Raises
    ------
    ValueError, TypeError
        For wrong arguments, for a function that cannot be traced, for a singular structure, and
        for a start that is not consistent.
    """
    unknown = sorted(set(options) - TAKEN)
    if unknown:
        raise TypeError(
            f"index reduction takes no option `{unknown[0]}`; it takes {', '.join(sorted(TAKEN))}."
        )
    t0, tf = time_span(t_span)
    y0, args = initial_state(y0), extra_arguments(args)
    yp0 = _derivative(yp0, y0)
    _probe(fun, t0, y0, yp0, args)
    reduction = Reduction(fun, t0, y0, yp0, args)
    _check_method(method, reduction)
    held = None if given is None else _held(given, reduction, len(y0))
    z = consistent(reduction.system, t0, guess(reduction.system, y0, yp0), held)
    events = [events] if callable(events) else list(events or ())
    t_eval = output_times(t_eval, t0, tf)
    _options(options, reduction, len(y0))
    found = run(reduction, (t0, tf), z, method, t_eval, dense_output, events, args, options)
    check_with_function(fun, args, found)
    return found


def _derivative(yp0, y0):
    if y0.dtype.kind == "c":
        raise ValueError("index reduction is for real equations: split complex ones into parts.")
    yp0 = np.zeros_like(y0) if yp0 is None else np.asarray(yp0, float)
    if yp0.shape != y0.shape:
        raise ValueError(f"`yp0` must have shape {y0.shape}, as `y0`; got {yp0.shape}.")
    for name, value in (("y0", y0), ("yp0", yp0)):
        if not np.isfinite(value).all():
            raise ValueError(f"`{name}` must be finite; got {value}.")
    return yp0


def _probe(fun, t0, y0, yp0, args):
    """Raise ValueError unless the function returns one residual for each component."""
    found = np.shape(fun(t0, y0.copy(), yp0.copy(), *args))
    if found != y0.shape:
        raise ValueError(
            f"`fun(t, y, yp)` must return {len(y0)} residuals, one for each component; it returns "
            f"shape {found}."
        )


def _check_method(method, reduction):
    found = method_named(method)
    constrained = reduction.system.offsets.equations.any()
    if found is None or found.second_order or (constrained and not found.projects):
        raise ValueError(
            f"`method={method!r}` cannot return a state to its constraints; take an adaptive "
            "explicit method (DOP853, Vern9, Taylor, ...), or Radau or Rodas5P for stiff equations."
        )


def _held(given, reduction, n):
    """The set of components that keep their values, checked."""
    held = set(np.atleast_1d(np.asarray(given, int)).tolist()) if np.size(given) else set()
    if not held <= set(range(n)):
        raise ValueError(f"`given` must name components 0 to {n - 1}; got {sorted(held)}.")
    system = reduction.system
    d = system.offsets.components - system.extra
    free = {system.name(j, order) for j, order in system.states if order < d[j]}
    algebraic = sorted(held - free)
    if algebraic:
        raise ValueError(
            f"component {algebraic[0]} cannot be `given`: the equations determine it from the "
            "others at each time."
        )
    return held


def _options(options, reduction, n):
    """Change tolerances of each component to those of the reduced state."""
    system = reduction.system
    for name in ("rtol", "atol"):
        value = options.get(name)
        if value is not None and np.ndim(value):
            value = np.asarray(value, float)
            if value.shape != (n,):
                raise ValueError(f"`{name}` has wrong shape.")
            names = [system.name(j, order) for j, order in system.states]
            options[name] = np.array([value.min() if k is None else value[k] for k in names])
