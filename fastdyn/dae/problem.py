"""The arguments of `solve_dae`, checked once for both ways of solving; a Problem of [y, y']."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.mode import RESIDUAL
from fastdyn.compile.python_callback import called_with, derivative, explained
from fastdyn.kernels.methods import BY_NAME
from fastdyn.kernels.methods import RESIDUAL as METHOD
from fastdyn.problem import validate
from fastdyn.problem.arguments import Arguments
from fastdyn.problem.options.names import ARGUMENTS, advice
from fastdyn.problem.options.table import refused_by, taken_by
from fastdyn.problem.sensitivities import directions_of

from .callbacks import with_observed
from .functions import event_of_vector, of_vector

GIVEN = ("differential", "y", "yp")


class DaeArguments(NamedTuple):
    """Checked arguments; `held` is `given` of `solve_dae`: None, a word, or 2 n booleans.

    `directions` are those of `sensitivity`, or None.
    """

    F: Any
    t0: float
    tf: float
    y0: np.ndarray
    yp0: np.ndarray
    t_eval: Any
    dense_output: bool
    events: Any
    args: tuple
    held: Any
    options: dict
    directions: Any = None

    @property
    def n(self):
        return len(self.y0)


def checked(F, t_span, y0, yp0, t_eval, dense_output, events, args, given, options):
    """The DaeArguments; raise a sentence for wrong arguments; options: see `check_options`."""
    if not callable(F):
        raise TypeError(f"`F` must be a function of (t, y, yp); got {F!r}.")
    t0, tf = validate.time_span(t_span)
    y0, yp0, held = _start(y0, yp0, given)
    args = validate.extra_arguments(args)
    t_eval = validate.output_times(t_eval, t0, tf)
    _check_residual(F, t0, y0, yp0, args)
    options, wanted = dict(options), options.get("sensitivity")
    options.pop("sensitivity", None)
    directions = None if wanted is None else directions_of(wanted, F, y0, args, first=3)
    return DaeArguments(
        F, t0, tf, y0, yp0, t_eval, dense_output, events, args, held, options, directions
    )


def problem_of_residual(given):
    """The Problem of the state [y, y'] that BDF solves."""
    for name in sorted(refused_by("residual").keys() & given.options.keys()):
        other = "; `max_step` limits the steps." if name == "step" else "."
        raise TypeError(
            f"`solve_dae` has no option `{name}` without a method of `solve_ivp`{other}"
        )
    n = given.n
    asked = Arguments(
        fun=given.F, t0=given.t0, tf=given.tf, y0=given.y0, t_eval=given.t_eval,
        dense_output=given.dense_output, events=given.events, args=given.args,
        options=with_observed(given.options, lambda t, both: both[:n]),
    )  # fmt: skip
    p = validate.problem(asked, BY_NAME[METHOD], RESIDUAL)
    watched = p.events and [e.like(event_of_vector(e.function, n)) for e in p.events]
    return p._replace(
        fun=of_vector(given.F, n), y0=np.concatenate([given.y0, given.yp0]), events=watched,
        rtol=_twice(p.rtol), atol=_twice(p.atol),
    )  # fmt: skip


def check_options(options, who="solve_dae"):
    """Raise a sentence for an option that the public function `who` does not take."""
    refused = refused_by(who)
    taken = taken_by(who)
    for name in options:
        if refused.get(name):
            raise ValueError(f"`{who}` has no `{name}`: {refused[name]}.")
        if name not in taken:
            always = sorted({*taken} - refused_by("residual").keys())
            known = (*always, *ARGUMENTS, "yp0", "given")
            said = advice(name, known) or f"it has {', '.join(always)}."
            raise TypeError(f"`{who}` has no option `{name}`; {said}")


def _start(y0, yp0, given):
    """y0 and yp0 as arrays of floats, and `given`, checked."""
    y0 = _real(y0, "y0")
    if not y0.size:
        raise ValueError("`y0` is empty: there is nothing to solve.")
    if yp0 is None:
        if isinstance(given, str) and given == "yp":
            raise ValueError("given='yp' holds all of `yp0`: give it.")
        yp0 = np.zeros(len(y0))
        given = "differential" if given is None else given
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
    if held.ndim == 1 and not held.size:
        return np.zeros(2 * n, bool)
    if held.dtype.kind == "i" and held.ndim == 1 and np.all((held >= 0) & (held < n)):
        return np.isin(np.arange(2 * n), held)
    if held.dtype != bool or held.shape != (2 * n,):
        raise ValueError(
            f"`given` must be None, one of {', '.join(map(repr, GIVEN))}, numbers of components of "
            f"`y0`, 0 to {n - 1}, or {2 * n} booleans, for `y0` and then `yp0`; got {given!r}."
        )
    return held


def held_components(given):
    """The components of `y0` that are held in an index reduction; None without an array."""
    held = given.held
    n = given.n
    if held is None or (isinstance(held, str) and held in GIVEN[:2]):
        return None
    if isinstance(held, str) or held[n:].any():
        raise ValueError(
            "`given` holds derivatives: at an index above 1 components of `y0` alone are held."
        )
    return set(np.flatnonzero(held[:n]).tolist())


def _real(values, name):
    values = validate.initial_state(values, name)
    if values.dtype.kind == "c":
        raise TypeError(f"`{name}` is complex: split the unknowns of F into real and imaginary.")
    return values


def _check_residual(F, t0, y0, yp0, args):
    """Evaluate F once in Python, to report its mistakes."""
    try:
        found = derivative(F(t0, y0.copy(), yp0.copy(), *args), len(y0), RESIDUAL)
    except Exception as error:
        explained(error, called_with(F, args), "F", t0, y0)
        raise
    bad = np.flatnonzero(~np.isfinite(found))
    if bad.size:
        raise ValueError(
            f"`F` returned nan or inf at the start, t = {t0:.10g} (equation {bad[0]})."
        )


def _twice(tolerance):
    return tolerance if np.ndim(tolerance) == 0 else np.concatenate([tolerance, tolerance])
