"""From arguments to a Problem: validation, and its messages.

Where SciPy raises, this file raises SciPy's exception, with the start of SciPy's message; what
SciPy's message leaves open is a note of the exception.
A NaN in a tolerance, a time or t_eval, with which SciPy never ends, raises ValueError.
"""

import inspect
import math
from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.mode import Mode
from fastdyn.compile.sentences import warn
from fastdyn.kernels.methods import METHODS
from fastdyn.kernels.methods.method import SHARED_METHODS
from fastdyn.words.kinds import noted, shown, times
from fastdyn.words.near import did_you_mean
from fastdyn.words.raised import argument_names, of_odeint

from . import jacobian, lsoda, mass, schedules, step_options
from .domains import options as domains
from .options.names import warn_unused
from .options.table import CHECKED, UNSET, check_kinds, checked_by_themselves, value_of

IMPLICIT = ("Radau", "BDF", "LSODA")
OTHER_METHODS = {  # names in other packages, and those of families
    "adams": "LSODA", "cash": "RK45", "dop5": "RK45", "dopri5": "RK45", "dopri8": "DOP853",
    "dp5": "RK45", "feagin": "Vern9", "ieuler": "Radau", "leapfrog": "VelocityVerlet",
    "ode113": "LSODA", "ode15s": "BDF", "ode23s": "Rodas5P", "ode23t": "Radau", "ode78": "DOP853",
    "ode89": "Vern9", "odeint": "LSODA", "rk": "RK4", "rk54": "RK45", "rkf45": "RK45",
    "rosenbrock": "Rodas5P",
    "rungekutta": "RK4", "rungekutta4": "RK4", "stiff": "Radau", "stoermerverlet": "VelocityVerlet",
    "stormerverlet": "VelocityVerlet", "vode": "BDF", "cvode": "BDF", "ida": "BDF",
}  # fmt: skip


CALLED = (int, float, list, tuple, np.ndarray, np.number)  # what a function returned


class Reaction(NamedTuple):
    """How a solve reacts that "auto" has begun: a solve by a method that the user named warns.

    Attributes
    ----------
    automatic : bool
        The methods are those of "auto", which no sentence recommends again.
    gives_up : str
        "stiff": a run whose steps stability limits raises `Stiff` at a look.  "slides": besides,
        a run that slides along a switch raises `Sliding`.
    refuses_large : bool
        A function for which a series does not pay has none, although it could have.
    """

    automatic: bool = False
    gives_up: str = ""
    refuses_large: bool = False


class Problem(NamedTuple):
    """A checked initial value problem.  Times are floats, `y0` float64 of shape (n,)."""

    fun: Any
    t0: float
    tf: float
    y0: np.ndarray
    method: Any
    t_eval: np.ndarray | None
    dense_output: bool
    events: list | None
    args: tuple
    mode: Mode
    rtol: Any
    atol: Any
    h_max: float
    h: float
    segments: np.ndarray
    project: Any
    max_steps: float = UNSET["max_steps"]
    progress: bool = UNSET["progress"]
    on_interrupt: str = UNSET["on_interrupt"]
    compile: str = UNSET["compile"]
    checkpoint: Any = UNSET["checkpoint"]
    callback: Any = UNSET["callback"]
    jac: Any = None
    differences: bool = False
    sparsity: Any = None
    mass: Any = None
    h_least: float = 0.0
    band: tuple = lsoda.NO_BAND
    orders: tuple = lsoda.ORDERS  # highest orders of Adams' formulas and of BDF
    limit: float | None = None  # steps of LSODA pass the end, as odeint's, up to this time
    most_between: int = 0  # most steps between two times of `t_eval`; 0: any number
    schedules: tuple = ()
    domain: Any = None
    inside: Any = None  # the sign of `domain`, 1.0 inside
    nonnegative: Any = None  # n bools
    told: Any = None  # receives the STATE of the solver at each time of `t_eval`
    ends_at_switches: bool = True  # whether steps end where `fun` switches with the time
    reaction: Reaction = Reaction()
    differentiated: tuple = ()  # positions of arguments, from 1, by which a sweep differentiates
    bare: Any = None  # the Problem of functions whose forms, here, keep a solve inside

    @property
    def acts(self):
        """Whether an event changes the state."""
        return any(event.act is not None for event in self.events or ())

    @property
    def jumps(self):
        """The function that changes the state, or None, of each event, then of each schedule."""
        return [*[event.act for event in self.events or ()], *[one.jump for one in self.schedules]]

    @property
    def events_as_scipy(self):
        """Whether the times of events are located as by SciPy."""
        return not (self.method.has_own_results or self.acts)


def time_span(t_span):
    """The two ends of `t_span`; the second end may be infinite."""
    try:
        t0, tf = map(float, t_span)
    except (TypeError, ValueError) as error:  # the exception is SciPy's
        error.add_note(_wanted_span(t_span))
        raise
    if (t_span.__class__ is not tuple and isinstance(t_span, str | set | dict)) or (
        isinstance(t_span, tuple | list) and str in map(type, t_span)
    ):
        raise TypeError(_wanted_span(t_span))
    if not math.isfinite(t0) or math.isnan(tf):
        raise ValueError(f"`t_span` must be two times that are not NaN; got ({t0}, {tf}).")
    if abs(t0) > step_options.LATEST or step_options.LATEST < abs(tf) < math.inf:
        raise ValueError(
            f"`t_span` must lie within {step_options.LATEST:.1e}, where steps have a size that is "
            f"a number; got ({t0}, {tf})."
        )
    return t0, tf


def _wanted_span(t_span):
    """The sentence about a `t_span` that is no pair of numbers."""
    said = f"`t_span` must be start and end; got {shown(t_span)}"
    if isinstance(t_span, int | float | np.number):
        return f"{said}: (0, {t_span})?"
    if isinstance(t_span, tuple | list | np.ndarray) and len(t_span) > 2:
        return f"{said}: times of output are `t_eval`."
    return f"{said}."


def function(fun, name="fun"):
    """Raise SciPy's TypeError for what is no function."""
    if hasattr(fun, "rhs") and hasattr(fun, "solve"):
        known = "its class" if isinstance(fun, type) else shown(fun)
        raise TypeError(
            f"`{name}` must be a function of (t, y); got a system, {known}: write "
            "`system.solve()`, or give `system.rhs`, with args=system.args."
        )
    if callable(fun):
        if said := of_odeint(argument_names(fun), f"`{name}`", f"{name}(t, y)"):
            warn(said)
        return
    called = " (the function itself, not what it returns)" if isinstance(fun, CALLED) else ""
    raise noted(
        TypeError(f"{type(fun).__name__!r} object is not callable"),
        f"`{name}` must be a function of (t, y){called}; got {shown(fun)}.",
    )


def initial_state(y0, name="y0"):
    """The initial state as a new 1-D array of float64 or complex128, finite."""
    given = y0
    try:
        y0 = np.asarray(given)
    except ValueError as error:  # NumPy's, as in SciPy
        error.add_note(f"`{name}` must be numbers in a row; got {shown(given)}.")
        raise
    if y0.dtype.kind in "fi" and y0.ndim == 1:
        if y0 is given or y0.dtype != float:
            y0 = np.array(y0, dtype=float)
        if math.isfinite(sum(y0.tolist()) if y0.size < 32 else np.add.reduce(y0)):
            return y0  # a sum that overflows is examined below
    if y0.dtype.kind in "US" or given is None:
        raise TypeError(f"`{name}` must be numbers; got {shown(given)}.")
    if y0.dtype.kind not in "fiubc":
        try:
            y0 = y0.astype(float)
        except (TypeError, ValueError):
            raise TypeError(f"`{name}` must be numbers; got {shown(given)}.") from None
    y0 = y0.astype(complex if y0.dtype.kind == "c" else float)
    if y0.ndim != 1:
        raise noted(ValueError(f"`{name}` must be 1-dimensional."), _wanted_state(y0, name))
    if not np.isfinite(y0).all():
        raise ValueError(f"All components of the initial state `{name}` must be finite.")
    return y0


def _wanted_state(y0, name):
    """The advice for a state of another shape than (n,)."""
    if y0.ndim == 0:
        return f"One number is a state of one component: {name}=[{y0}]."
    said = f"It has shape {y0.shape}"
    if max(y0.shape) == y0.size:
        return f"{said}: a row or a column becomes a state by np.ravel({name})."
    return f"{said}: one solve has one state; fastdyn.solve_ensemble takes a state in each row."


def joined_state(q0, other, name):
    """Positions and, by another name, velocities or momenta as one state."""
    q0 = initial_state(q0, "q0")
    other = initial_state(other, name)
    if q0.shape != other.shape or q0.dtype == complex or other.dtype == complex:
        raise ValueError(
            f"`q0` and `{name}` must be real and of one length; "
            f"got shapes {q0.shape}, {other.shape}."
        )
    return np.concatenate([q0, other])


def method_named(method, automatic=False):
    """The Facts of a method, by its name or by SciPy's class; None for another class of SciPy's.

    `automatic` tells whether the caller takes "auto", for the ValueError.
    """
    if isinstance(method, str):
        if method in METHODS:
            return METHODS[method]
    elif inspect.isclass(method):
        import scipy.integrate
        from scipy.integrate import OdeSolver

        if method in [getattr(scipy.integrate, name) for name in SHARED_METHODS]:
            return METHODS[method.__name__]
        if issubclass(method, OdeSolver):
            return None
    if method == "WisdomHolman":
        raise ValueError(
            '`method="WisdomHolman"` needs masses instead of a function: take '
            "fastdyn.planets.Planets(masses, q0, v0, G).solve(t_span, step=...)."
        )
    known = ["auto", *METHODS] if automatic else [*METHODS]
    if method == "auto":
        raise ValueError(
            '`method="auto"` is for solve_ivp and for `solve` of a system; name a method here: '
            f"one of {', '.join(known)}."
        )
    said = did_you_mean(method, known, OTHER_METHODS, form='"{}"')
    said = said or f"`method` must be one of {', '.join(known)} or OdeSolver class."
    raise ValueError(f"`method={method!r}` is unknown: {said}")


def extra_arguments(args):
    """`args` as a tuple."""
    if args is None:
        return ()
    if isinstance(args, str | dict | set):
        raise TypeError(f"`args` must be a tuple, args=({args!r},); got {shown(args)}.")
    try:
        return tuple(args)
    except TypeError as error:
        raise TypeError(
            "Supplied 'args' cannot be unpacked. Please supply `args`"
            f" as a tuple (e.g. `args=({args},)`)"
        ) from error


def output_times(t_eval, t0, tf):
    """`t_eval` as a new 1-D array, inside the span and strictly monotonic."""
    if t_eval is None:
        return None
    given = t_eval
    t_eval = np.array(t_eval)  # a solver for the next call keeps the times
    if t_eval.dtype.kind not in "fiub":
        times("t_eval", given)
        t_eval = t_eval.astype(float)
    if t_eval.ndim != 1:
        raise noted(
            ValueError("`t_eval` must be 1-dimensional."),
            f"For {given} times: t_eval=np.linspace({t0:g}, {tf:g}, {given})."
            if type(given) is int
            else f"One time is t_eval=[{t_eval}]."
            if t_eval.ndim == 0
            else f"It has shape {t_eval.shape}; times in a row are np.ravel(t_eval).",
        )
    if t_eval.size:
        rising = t_eval if tf >= t0 else t_eval[::-1]
        low, high = (t0, tf) if tf >= t0 else (tf, t0)
        if not (low <= rising[0] and rising[-1] <= high and (rising[1:] > rising[:-1]).all()):
            if np.isnan(t_eval).any():
                raise ValueError("`t_eval` must not contain NaN.")
            if t_eval.min() < low or t_eval.max() > high:
                raise noted(
                    ValueError("Values in `t_eval` are not within `t_span`."),
                    f"`t_eval` goes from {t_eval.min():g} to {t_eval.max():g}, `t_span` from "
                    f"{t0:g} to {tf:g}.",
                )
            raise noted(
                ValueError("Values in `t_eval` are not properly sorted."),
                f"They must {'rise' if tf >= t0 else 'fall'}, each once, from {t0:g} to {tf:g}.",
            )
    return t_eval


def _ends_at_switches(asked, method):
    """Whether steps end at switching times: not where they are SciPy's, MATLAB's or constant."""
    own = method.has_own_results or asked.method == "auto"
    return bool(own and method.error_order and not method.like_matlab)


def problem(asked, method, mode):
    """The Problem of Arguments, with a real `y0`, for a compiled method and a mode of `fun`."""
    options = asked.options
    t0 = asked.t0
    tf = asked.tf
    y0 = asked.y0
    span = abs(tf - t0)
    check_kinds(options)
    by_themselves = {} if CHECKED.isdisjoint(options) else checked_by_themselves(options)
    events, scheduled = schedules.checked(asked.events, options, t0, tf)
    warn_unused(options, method)
    if method.error_order:
        rtol, atol = step_options.tolerances(
            value_of(options, "rtol"), value_of(options, "atol"), y0,
            step_options.EPS if method.series else 100 * step_options.EPS,
        )  # fmt: skip
        h_max, h = step_options.step_limits(options, span)
        if h_max is None:
            h_max = span * method.h_max_share
        elif options.get("max_steps") is None and not any(e.limit for e in events or ()):
            step_options.never_ends(h_max, t0, tf)
    else:
        rtol = 0.0
        atol = 0.0
        h_max = math.inf
        h = step_options.fixed_step(options, t0, tf, method.name)
    project = options.get("project")
    if project is not None and (not method.projects or not callable(project)):
        raise ValueError(
            f"{method.name} does not take `project`; RK4 and the adaptive methods do, except for "
            "BDF and LSODA."
            if not method.projects
            else f"`project` must be a function of (t, y) that returns a state; got {project!r}."
        )
    if mode.second_order and len(y0) % 2:
        raise ValueError(f"the state [q, v] has an even number of components; got {len(y0)}.")
    if method.like_matlab and (np.any(np.asarray(atol) <= 0) or np.ndim(rtol)):
        raise ValueError(f"{method.name} takes one `rtol` and, for each component, `atol` > 0.")
    fun, matrix = mass.equations_of(asked, method, mode)
    of_matrices: Any = {}
    if method.n_matrices:
        of_jacobian, h_least, band = lsoda.options_of(asked, method)
        jac, differences, sparsity = jacobian.options_of(of_jacobian, len(y0))
        of_matrices = {
            "jac": jac, "differences": differences, "sparsity": sparsity, "mass": matrix,
            "h_least": h_least, "band": band,
        }  # fmt: skip
    found = Problem(
        fun=fun, t0=t0, tf=tf, y0=y0, method=method, t_eval=output_times(asked.t_eval, t0, tf),
        dense_output=bool(asked.dense_output), events=events, args=asked.args, mode=mode,
        rtol=rtol, atol=atol, h_max=h_max, h=h,
        segments=schedules.segments(options, scheduled, t0, tf, not method.error_order),
        project=project, schedules=scheduled, ends_at_switches=_ends_at_switches(asked, method),
        reaction=asked.reaction, **of_matrices, **by_themselves,
    )  # fmt: skip
    return domains.kept_inside(found, options) if domains.asked(options) else found
