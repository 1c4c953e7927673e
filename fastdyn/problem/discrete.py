"""Discrete states: numbers behind the state that only events and schedules change.

Discrete states are further components with the derivative 0.  They are no part of the error of a
step, and no part of the state that the user's functions get.
"""

import inspect

import numpy as np

from . import validate
from .domains.options import listed_components
from .events import Event
from .options.table import TOLERANCES, refused_among
from .options.tolerances import longer_tolerances
from .schedules import SHORTHANDS, Schedule, listed

BESIDE = "behind y, every function gets `discrete`"


def longer(asked):
    """The Arguments for the longer state, and the length n of its first part, y.

    Raises
    ------
    ValueError, TypeError
    """
    y0 = asked.y0
    options = asked.options
    d0 = discrete_states(asked.discrete, y0, {**options, "vectorized": asked.vectorized})
    expect_action(options.get("on_event"))
    n = len(y0)
    m = len(d0)
    ours = method_for(asked.method)
    events, on_event = extended_events(listed(asked.events, options), options["on_event"], n, m)
    options = {name: value for name, value in options.items() if name not in SHORTHANDS}
    options = extended_options({**options, "on_event": on_event}, ours, n, m)
    state = np.concatenate([y0, d0])
    extended = asked._replace(
        fun=extended_function(asked.fun, n, m), y0=state, given_y0=state, events=events,
        options=options, discrete=None,
    )  # fmt: skip
    return extended, n


def method_for(method):
    """The Facts of a method that takes `discrete`; None for "auto"; raises ValueError."""
    ours = None if method == "auto" else validate.method_named(method)
    if method != "auto" and (ours is None or ours.second_order):
        raise ValueError(
            f"{method!r} takes no `discrete`; RK4, Gauss8 and fastdyn's adaptive methods do."
        )
    return ours


def expect_action(on_event):
    """Raise ValueError if no function of `on_event` can change discrete states."""
    if on_event is None or (isinstance(on_event, list | tuple) and not any(on_event)):
        raise ValueError(
            "`discrete` never changes: give `on_event` for an event or a schedule (`at`, `every`), "
            "or pass constants as `args`."
        )


def discrete_states(discrete, y0, options):
    """`discrete` as a new array of m floats; raises ValueError."""
    d0 = validate.initial_state(discrete, "discrete")
    if d0.dtype.kind == "c" or y0.dtype.kind == "c":
        raise ValueError("`discrete` is for real numbers and real states: split complex ones.")
    if not d0.size or not y0.size:
        raise ValueError("`discrete` must have one number at least, and `y0` one component.")
    refused = [name for name, _ in refused_among(options, "discrete")]
    for name in refused + ["vectorized"] * bool(options.get("vectorized")):
        raise ValueError(f"`discrete` and `{name}` do not go together.")
    return d0


def joined_rows(y0, discrete, n, m):
    """States with discrete states behind, a row each, or one state of shape (n + m,).

    Raises
    ------
    ValueError
        For another number of columns than n or m, and for different numbers of rows.
    """
    states = [np.asarray(y0, float), np.asarray(discrete, float)]
    for name, state, length in zip(("y0", "discrete"), states, (n, m), strict=True):
        if state.ndim not in (1, 2) or state.shape[-1] != length:
            raise ValueError(
                f"`{name}` must have shape ({length},), or a row of {length} numbers for each "
                f"trajectory; got {state.shape}."
            )
    counts = {len(state) for state in states if state.ndim == 2} - {1}
    if len(counts) > 1:
        raise ValueError(
            "`y0` and `discrete` must have a row for each trajectory: "
            f"`y0` has {len(states[0])}, `discrete` has {len(states[1])}."
        )
    if not np.isfinite(states[1]).all():
        raise ValueError("All numbers of `discrete` must be finite.")
    if all(state.ndim == 1 for state in states):
        return np.concatenate(states)
    rows = [np.broadcast_to(state, (max(counts, default=1), state.shape[-1])) for state in states]
    return np.hstack(rows)


def extended_events(events, on_event, n, m):
    """The events and the functions of `on_event`, as functions of the longer state."""
    longer = [extended_event(event, n) for event in events or ()]
    if callable(on_event):
        return longer, _jump(on_event, n, m)
    try:
        jumps = list(on_event)
    except TypeError:
        return longer, on_event  # refused with the other mistakes
    return longer, [_jump(jump, n, m) if callable(jump) else jump for jump in jumps]


def extended_options(options, method, n, m):
    """The options of a solve of the longer state."""
    options = dict(options)
    if method is None or method.error_order:
        given = {**TOLERANCES, **options}
        longer = longer_tolerances(method, given["rtol"], given["atol"], n, m)
        options["rtol"], options["atol"] = longer
    for name, diagonal in (("jac", 0.0), ("mass", 1.0)):
        if callable(options.get(name)):
            options[name] = _matrices(options[name], n, m, diagonal)
    for name in ("jac", "jac_sparsity", "mass"):
        matrix = options.get(name)
        if matrix is not None and not callable(matrix) and not isinstance(matrix, str):
            options[name] = _padded(matrix, m, 1.0 if name == "mass" else 0.0)
    if callable(options.get("project")):
        options["project"] = _projection(options["project"], n)
    if callable(options.get("domain")):
        options["domain"] = _of_parts(options["domain"], n)
    nonnegative = listed_components(options.get("nonnegative"), n)
    if nonnegative is not None:
        options["nonnegative"] = np.r_[nonnegative, np.full(m, False)]
    return options


def _padded(matrix, m, diagonal):
    """A matrix with m more rows and columns, which are a multiple of the identity."""
    given = np.asarray(matrix.toarray() if hasattr(matrix, "toarray") else matrix)
    if given.ndim != 2:
        return matrix  # refused with the other mistakes
    rows, columns = given.shape
    longer = np.zeros((rows + m, columns + m), given.dtype if diagonal == 0.0 else float)
    longer[:rows, :columns] = given
    longer[rows:, columns:] = diagonal * np.eye(m)
    return longer


def extended_function(fun, n, m):
    """The derivative of the longer state."""

    def derivative(t, z, *args):
        found = _listed(fun(t, z[:n], z[n:], *args))
        if len(found) != n:
            said = f"`fun` returned {len(found)} value{'s' * (len(found) != 1)} for a state of {n}"
            raise ValueError(f"{said}; {BESIDE}.")
        return [*found, *([0.0] * m)]

    _sign(derivative, fun)
    return derivative


def _listed(found):
    """A result as a sequence with one entry for each component; a number becomes one entry."""
    return found if hasattr(found, "__len__") else [found]


def _sign(longer, fun):
    """Give a function the name of the user's function, and its parameters without `discrete`."""
    _name(longer, fun)
    try:
        signature = inspect.signature(fun)
    except (TypeError, ValueError):
        return
    parameters = list(signature.parameters.values())
    if len(parameters) > 3 and all(p.kind is p.POSITIONAL_OR_KEYWORD for p in parameters[:3]):
        longer.__signature__ = signature.replace(parameters=[*parameters[:2], *parameters[3:]])


def _name(longer, function):
    """Give a function the name of the user's function, which warnings show, and its form."""
    longer.form = "t, y, d, *args"
    for name in ("__name__", "__qualname__"):
        setattr(longer, name, getattr(function, name, getattr(longer, name)))


def extended_event(event, n):
    """An event of (t, y, d, *args) as an Event of the longer state; a Schedule stays."""
    if isinstance(event, Schedule) or not (callable(event) or isinstance(event, Event)):
        return event
    event = Event.of(event)
    return event.like(_of_parts(event.function, n))


def _of_parts(function, n):
    """A function of (t, y, d, *args) as a function of the longer state."""

    def of_parts(t, z, *args):
        return function(t, z[:n], z[n:], *args)

    _name(of_parts, function)
    return of_parts


def _jump(jump, n, m):
    def jumped(t, z, *args):
        found = jump(t, z[:n], z[n:], *args)
        pair = isinstance(found, tuple | list) and len(found) == 2
        y, d = map(_listed, found) if pair else ((), ())
        if len(y) != n or len(d) != m:
            raise ValueError(
                f"with `discrete`, `on_event` must return (y, d), {n} and {m} numbers; got "
                f"{type(found).__name__} "
                + (f"of {len(y)} and {len(d)}." if pair else "that is no such pair.")
            )
        return [*y, *d]

    _name(jumped, jump)
    return jumped


def _projection(project, n):
    def projected(t, z, *args):
        return [*_listed(project(t, z[:n], z[n:], *args)), *z[n:]]

    _name(projected, project)
    return projected


def _matrices(given, n, m, diagonal):
    def matrix(t, z, *args):
        return _padded(given(t, z[:n], z[n:], *args), m, diagonal)

    _name(matrix, given)
    return matrix
