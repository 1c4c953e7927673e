"""The arguments of `solve_dae`, checked: a Problem of the state [y, y']."""

import numpy as np

from fastdyn.compile.mode import RESIDUAL
from fastdyn.compile.python_callback import derivative
from fastdyn.kernels.methods import BY_NAME
from fastdyn.kernels.methods import RESIDUAL as METHOD
from fastdyn.problem import validate

from .functions import event_of_vector, of_vector

OPTIONS = {
    "rtol", "atol", "max_step", "first_step", "on_event", "max_steps", "progress", "on_interrupt",
}  # fmt: skip
NOT_YET = {
    "breakpoints": "end the run at the jump, and begin anew with given='differential'",
    "jac": "Jacobians are exact where F can be traced, and by differences elsewhere",
}
GIVEN = ("differential", "y", "yp")


def checked(F, t_span, y0, yp0, t_eval, dense_output, events, args, given, options):
    """(the Problem, what of the start is held); raise a sentence for wrong arguments."""
    _check_options(options)
    if not callable(F):
        raise TypeError(f"`F` must be a function of (t, y, yp); got {F!r}.")
    t0, tf = validate.time_span(t_span)
    y0, yp0, given = _start(y0, yp0, given)
    n = len(y0)
    p = validate.problem(
        F, t0, tf, y0, BY_NAME[METHOD], t_eval, dense_output, events, args, RESIDUAL, options
    )
    _check_residual(p, F, y0, yp0)
    watched = p.events and [(event_of_vector(event, n), *how) for event, *how in p.events]
    problem = p._replace(
        fun=of_vector(F, n), y0=np.concatenate([y0, yp0]), events=watched,
        rtol=_twice(p.rtol), atol=_twice(p.atol),
    )  # fmt: skip
    return problem, given


def _check_options(options):
    for name in options:
        if name in NOT_YET:
            raise ValueError(f"`solve_dae` has no `{name}`: {NOT_YET[name]}.")
        if name not in OPTIONS:
            raise TypeError(
                f"`solve_dae` has no option `{name}`; it has {', '.join(sorted(OPTIONS))}."
            )


def _start(y0, yp0, given):
    """y0 and yp0 as arrays of floats, and `given`, checked."""
    y0 = _real(y0, "y0")
    if not y0.size:
        raise ValueError("`y0` is empty: there is nothing to solve.")
    if yp0 is None:
        yp0, given = np.zeros(len(y0)), "differential" if given is None else given
    else:
        yp0 = _real(yp0, "yp0")
    if len(yp0) != len(y0):
        raise ValueError(
            f"`yp0` must have one number for each of `y0`: it has {len(yp0)}, and `y0` {len(y0)}."
        )
    if given is None or (isinstance(given, str) and given in GIVEN):
        return y0, yp0, given
    return y0, yp0, _held(given, len(y0))


def _held(given, n):
    """The booleans that say which of the 2 n numbers `y0`, `yp0` are held."""
    held = np.asarray(given)
    if held.dtype.kind == "i" and held.ndim == 1 and np.all((held >= 0) & (held < n)):
        return np.isin(np.arange(2 * n), held)
    if held.dtype != bool or held.shape != (2 * n,):
        raise ValueError(
            f"`given` must be None, one of {', '.join(map(repr, GIVEN))}, numbers of components of "
            f"`y0`, or {2 * n} booleans, for `y0` and then `yp0`; got {given!r}."
        )
    return held


def held_components(given, n):
    """The components of `y0` that `given` holds in an index reduction; None without an array."""
    if given is None or (isinstance(given, str) and given in GIVEN[:2]):
        return None
    held = np.ones(2 * n, bool) if isinstance(given, str) else _held(given, n)
    if held[n:].any():
        raise ValueError(
            f"`given={given!r}` holds derivatives: at an index above 1 components of `y0` alone "
            "are held."
        )
    return np.flatnonzero(held[:n]).tolist()


def _real(values, name):
    values = validate.initial_state(values, name)
    if values.dtype.kind == "c":
        raise TypeError(f"`{name}` is complex: split the unknowns of F into real and imaginary.")
    return values


def _check_residual(p, F, y0, yp0):
    """Evaluate F once in Python, to report its mistakes."""
    found = derivative(F(p.t0, y0.copy(), yp0.copy(), *p.args), len(y0), RESIDUAL)
    bad = np.flatnonzero(~np.isfinite(found))
    if bad.size:
        raise ValueError(
            f"`F` returned nan or inf at the start, t = {p.t0:.10g} (equation {bad[0]})."
        )


def _twice(tolerance):
    return tolerance if np.ndim(tolerance) == 0 else np.concatenate([tolerance, tolerance])
