"""Motion in phases, each with its own equations; events switch between phases."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Hashable, Mapping
from itertools import repeat
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fastdyn.compile.python_callback import value_of
from fastdyn.kernels.methods import METHODS
from fastdyn.kernels.output.arguments import APART, TOLERANCE
from fastdyn.problem.arguments import checked
from fastdyn.problem.events import Event
from fastdyn.problem.options.docstrings import filled
from fastdyn.problem.options.table import refused_among
from fastdyn.problem.schedules import refuse_schedules
from fastdyn.problem.step_options import largest_time, unit_of_times, within
from fastdyn.problem.validate import function, method_named, output_times
from fastdyn.run.dense_output import PiecewisePolynomial
from fastdyn.run.outcome import SUCCESS
from fastdyn.run.result import FIELDS, OdeResult, of_parts
from fastdyn.words.calls import shown_when_wrong
from fastdyn.words.kinds import function_of, number, shown
from fastdyn.words.near import did_you_mean

from . import automatic
from .discrete import parted, with_discrete_phases

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import Args, Functions, State, Times, TimeSpan


class Phase(NamedTuple):
    """One phase of a motion.

    Parameters
    ----------
    fun : callable
        ``fun(t, y, *args)``, the equations of motion of the phase.
    event : callable
        ``event(t, y, *args)`` ends the phase at its zero; its attribute `terminal` must be True.
    after : callable
        ``after(t, y, *args)`` returns the name of the next phase and its initial state.
    options : mapping
        Further options of `solve_ivp` in this phase, such as `project`.
    """

    fun: Callable
    event: Callable
    after: Callable
    options: Mapping[str, Any] = {}


@shown_when_wrong()
@filled("solve_phases")
def solve_phases(
    phases: Mapping[str, Phase],
    first: str,
    t_span: TimeSpan,
    y0: State,
    method: str = "RK45",
    t_eval: Times | None = None,
    dense_output: bool = False,
    events: Functions | None = None,
    args: Args | None = None,
    max_phases: int = 10_000,
    **options: Any,
) -> OdeResult:
    """Solve through the phases of a motion, in one call.

    Parameters
    ----------
    phases : dict of str to Phase
    first : str
        Name of the phase at the start.
    max_phases : int
        Largest number of phases; then the run ends with status -1.  A motion whose phases become
        ever shorter would never end.
    t_span, y0, method, t_eval, dense_output, events, args, **options
        As for `solve_ivp`, except {refused}; all phases share the components of
        the state and `args`.  With `discrete`, m numbers that `after` changes,
        all functions of the phases get them behind y,
        and `after` returns ``(name, y, d)``.

    Returns
    -------
    OdeResult
        Also with `phases`, a list of (name, start, end).  If the state jumps from one phase to the
        next, `t` has the time twice, with the state before and after the jump.

    Raises
    ------
    ValueError, TypeError
        For wrong arguments, and for a phase whose event is not terminal.
    """
    _check(phases, method, events, max_phases, options)
    events = [events] if callable(events) else list(events or ())
    asked = checked(None, t_span, y0, method, t_eval, dense_output, events, False, args, options)
    if asked.discrete is None:
        return _solved(phases, first, asked, max_phases)
    longer, asked, n = with_discrete_phases(phases, asked)
    return parted(_solved(longer, first, asked, max_phases), n)


def _solved(phases, first, asked, max_phases):
    """The OdeResult of phases, whose common Arguments have no function."""
    name = first
    t = asked.t0
    tf = asked.tf
    y = asked.y0
    events = asked.events
    t_eval = output_times(asked.t_eval, t, tf)
    options = dict(asked.options)
    seen = [0] * len(events)
    last = [math.nan] * len(events)
    steps_left = options.pop("max_steps", None)
    segments = []
    log = []
    ended = None
    jumps = [False]
    while len(segments) < max_phases:
        if not isinstance(name, Hashable) or name not in phases:
            known = ", ".join(map(repr, phases))
            advice = did_you_mean(name, phases, form="{!r}") or f"there are {known}."
            raise ValueError(f"there is no phase {name!r}; {advice}")
        phase = phases[name]
        wanted = t_eval
        if t_eval is not None:
            ahead = t_eval - t if tf >= asked.t0 else t - t_eval
            wanted = t_eval[ahead > 0.0 if segments else ahead >= 0.0]
        given = {**options, **phase.options}
        if "breakpoints" in given:
            given["breakpoints"] = within(given["breakpoints"], t, tf)
        if steps_left is not None:
            given["max_steps"] = steps_left
        near = _near(asked, given, t)
        watched = [_crossed(phase, ended, asked, given, y, near)]
        watched += map(_gone_on, events, seen, last, repeat((t, near)))
        segment = automatic.solved(
            checked(
                phase.fun, (t, tf), y, given.pop("method", asked.method), wanted,
                given.pop("dense_output", asked.dense_output), watched,
                given.pop("vectorized", False), asked.args, given,
            )
        )  # fmt: skip
        for i, times in enumerate(segment.t_events[1:]):
            seen[i] += len(times)
            last[i] = float(times[-1]) if len(times) else last[i]
        if steps_left is not None:
            steps_left = max(1, steps_left - segment.n_accepted)
        ends = segment.t_events[0]
        end = float(ends[-1]) if len(ends) else float(segment.t[-1]) if len(segment.t) else t
        segments.append(segment)
        log.append((name, t, tf if segment.status == 0 else end))
        status, message = segment.status, segment.message
        if message.startswith("`max_steps"):
            message = f"All the `max_steps` were taken at t = {end:.10g}: raise it."
        # The end, a failure, or one of the user's `events`.
        if status != 1 or not len(ends) or _have_ended(events, seen):
            break
        ended = _Crossing(phase.event, t, end, segment.y_events[0][-1])
        t = end
        name, y = _next(phase, t, segment.y_events[0][-1], asked.args)
        jumps.append(not np.array_equal(y, segment.y_events[0][-1]))
        if t == tf:
            status, message = 0, SUCCESS
            break
    else:
        message = f"`max_phases={max_phases}` was reached at t = {t:.10g}; are they ever shorter?"
        status = -1
    keep_start = [t_eval is not None or jump or i == 0 for i, jump in enumerate(jumps)]
    return _joined(segments, log, status, message, keep_start, len(events))


def _next(phase, t, y, args):
    """The name of the next phase, and the state at its start."""
    found: Any = value_of(phase.after, args, "after", t, y)
    name: Any = None
    state: Any = None
    if isinstance(found, tuple | list) and len(found) == 2:
        with contextlib.suppress(TypeError, ValueError):
            name = found[0]
            state = np.array(found[1], dtype=float)
    if np.shape(state) != y.shape:
        raise ValueError(
            f"`after` must return (name, y), the next phase and {len(y)} numbers; got "
            f"{shown(found)}."
        )
    return name, state


class _Crossing(NamedTuple):
    """The event that ended a phase, at the time t and the state y."""

    event: Any
    begun: float
    t: float
    y: np.ndarray


def _have_ended(events, seen):
    """Whether one of the user's events has occurred as often as ends the motion."""
    return any(0 < Event.of(event).limit <= n for event, n in zip(events, seen, strict=True))


def _near(asked, given, t):
    """The resolution of two roots at the time t at which a phase begins."""
    by = METHODS.get(given.get("method", asked.method))
    unit = unit_of_times(by is not None and not by.has_own_results, t, asked.tf)
    return 2 * TOLERANCE * (unit + largest_time(given.get("breakpoints"), t, asked.tf))


def _crossed(phase, crossing, asked, given, y, near):
    """The event of a phase that begins at y behind a crossing, which does not count twice.

    The root may lie before or behind the true one by its resolution, and the function of the same
    event crosses zero once more at the start of the next phase.  The crossing goes on if the state
    is the same, and if the time alone is what crosses, as where the function jumps.  A phase that
    begins at a zero, as a body at rest does, did not cross.
    """
    found = Event.of(phase.event).changed(decides=True)
    if crossing is None:
        return found
    before = Event.of(crossing.event)
    if (found.origin or found.function) is not (before.origin or before.function):
        return found
    t = crossing.t
    same = found.direction != 0.0 and np.array_equal(y, crossing.y)
    if not (same and abs(t - crossing.begun) > near):
        sides = [
            float(np.ravel(value_of(found.function, asked.args, "event", t + way * near, y))[0])
            for way in (-1.0, 1.0)
        ]
        if not sides[0] * sides[1] < 0.0:
            return found
    return found.changed(wait=max(found.wait, near), last=t)


def _check(phases, method, events, max_phases, options):
    """Raise ValueError for options that phases do not take."""
    if method_named(method) is None:
        raise ValueError(f"`method={method!r}` is SciPy's; phases need a compiled method.")
    for name, reason in refused_among(options, "solve_phases"):
        raise ValueError(f"phases take no `{name}`: {reason}.")
    refuse_schedules(events, "a schedule belongs to one span, and each phase has its own")
    number("max_phases", max_phases)
    if not max_phases >= 1:
        raise ValueError(f"`max_phases` must be at least 1; got {max_phases}.")
    if not isinstance(phases, Mapping):
        raise TypeError(f"`phases` must be a dict of names and Phases; got {shown(phases)}.")
    for name, phase in phases.items():
        if not isinstance(phase, Phase):
            raise TypeError(f"phase '{name}' must be a Phase; got {shown(phase)}.")
        function(phase.fun, f"fun of phase '{name}'")
        function_of("(t, y)")(f"after of phase '{name}'", phase.after)
        if not getattr(phase.event, "terminal", False):
            raise ValueError(f"the event of phase '{name}' must be terminal: it ends the phase.")


def _gone_on(event, n, last, begins):
    """An event of the user that has occurred n times in earlier phases, the last time at `last`.

    `begins` is the time at which the phase begins, where no occurrence counts twice, and the
    resolution of two roots.
    """
    t, near = begins
    event = Event.of(event)
    apart = APART * near if abs(t - last) <= APART * near else 0.0
    limit = event.limit and event.limit - n
    return event.changed(limit=limit, last=last, wait=max(event.wait, apart))


def _joined(segments, log, status, message, keep_start, n_events):
    t = []
    y = []
    for segment, keep in zip(segments, keep_start, strict=False):
        n_times = len(segment.t)
        states = np.empty((0, 0))
        if n_times:
            states = np.asarray(segment.y, float).reshape(-1, n_times)
        t.append(np.asarray(segment.t, float)[0 if keep else 1 :])
        y.append(states[:, 0 if keep else 1 :])
    full = [states for states in y if states.size]
    parts = dict(
        t=np.concatenate(t),
        y=np.concatenate(full, axis=1) if full else [],
        sol=_joined_solution([segment.sol for segment in segments if segment.sol is not None]),
        t_events=[np.concatenate([s.t_events[i + 1] for s in segments]) for i in range(n_events)],
        y_events=[_stacked([s.y_events[i + 1] for s in segments]) for i in range(n_events)],
        status=status,
        message=message,
        success=status >= 0,
        phases=log,
        **of_parts(segments),
    )
    return OdeResult({name: segments[-1].get(name) for name in FIELDS} | parts)


def _stacked(states):
    found = [one for one in states if len(one)]
    return np.concatenate(found) if found else np.empty(0)


def _joined_solution(pieces):
    """One OdeSolution from several consecutive OdeSolutions; None from an empty list."""
    if not pieces:
        return None
    ts = np.concatenate([pieces[0].ts[:1], *(piece.ts[1:] for piece in pieces)])
    return PiecewisePolynomial(
        ts,
        np.concatenate([piece.polynomials for piece in pieces]),
        np.concatenate([piece.spans for piece in pieces]),
        _joined_floors(pieces),
    )


def _joined_floors(pieces):
    """The least values in all pieces; None if no piece has any."""
    if all(piece.floors is None for piece in pieces):
        return None
    none = (np.full((piece.n_segments, piece.polynomials.shape[2]), -np.inf) for piece in pieces)
    given = zip((piece.floors for piece in pieces), none, strict=True)
    return np.concatenate([other if floors is None else floors for floors, other in given])
