"""Events and the functions of `on_event`, checked; the functions that are called between steps."""

import functools
import math
from typing import Any

import numpy as np

from fastdyn.compile.mode import COMPLEX_EVENT, DERIVATIVE, EVENT, JUMP, MATRIX, SALTATION

AS_GIVEN = "__fastdyn_event__"  # marks an event function of the first components of a longer state


def event_list(events):
    """Events as a list, each with its limit (0: not terminal) and direction."""
    if events is None:
        return None
    checked = []
    for event in (events,) if callable(events) else events:
        terminal = getattr(event, "terminal", None)
        limit = 0
        if terminal is not None and terminal != 0:
            if not (int(terminal) == terminal and terminal > 0):
                raise ValueError(
                    "The `terminal` attribute of each event must be a boolean or positive integer."
                )
            limit = int(terminal)
        direction = getattr(event, "direction", 0)
        if direction is None or direction != direction:
            raise ValueError("The `direction` attribute of each event must be a number.")
        checked.append((event, limit, float(direction)))
    return checked


def acting(on_event, events) -> tuple[Any, tuple]:
    """Checked events, and for each its function of `on_event` or None; () without `on_event`.

    ``terminal = True`` of an event that changes the state does not end the run; a number does.
    """
    if on_event is None:
        return events, ()
    try:
        jumps = (on_event,) if callable(on_event) else tuple(on_event)
    except TypeError:
        jumps = (on_event,) * len(events or ())  # refused below
    if len(jumps) != len(events or ()):
        raise ValueError(
            f"`on_event` must have a function, or None, for each event: it has {len(jumps)}, and "
            f"there are {len(events or ())} events."
        )
    for jump in jumps:
        if jump is not None and not callable(jump):
            raise TypeError(
                "`on_event` must be a function of (t, y) that returns a state, None, or a "
                f"sequence of them; got {jump!r}."
            )
    if not any(jumps):
        return events, ()
    return [_unless_true(*each) for each in zip(events, jumps, strict=True)], jumps


def _unless_true(event, jump):
    function, limit, direction = event
    if jump is not None and isinstance(getattr(function, "terminal", None), bool | np.bool_):
        limit = 0
    return function, limit, direction


def endless(tf, events, max_steps, schedules=()):
    """Refuse an infinite span if neither an event nor `max_steps` ends the run."""
    if (
        math.isinf(tf)
        and max_steps is None
        and not (any(e[1] for e in events or ()) or any(each.limit for each in schedules))
    ):
        raise ValueError(
            f"`t_span` ends at {tf} and nothing stops the run before: "
            "give a terminal event or `max_steps`."
        )


def between_steps(problem):
    """(function, mode) of the events, of `on_event`, the domain, the projection, the Jacobian."""
    p = problem
    event_mode = COMPLEX_EVENT if p.mode.complex_numbers else EVENT
    functions = [(event, event_mode) for event, _, _ in p.events or ()]
    jumps = [*p.on_event, *[each.jump for each in p.schedules]]
    changes = SALTATION if p.mode.sensitivities else JUMP
    functions += [(jump, changes) for jump in jumps if jump is not None]
    if p.inside is not None:
        functions.append((p.inside, EVENT))
    if p.project is not None:
        functions.append((p.project, DERIVATIVE))
    if p.jac is not None:
        functions.append((p.jac, MATRIX))
    return functions


def of_own(event, n):
    """An event function of the first n components of a longer state."""
    while isinstance(event, functools.partial) and not event.args and not event.keywords:
        event = event.func  # the event of a partial that only carries marks

    def watched(t, y, *args):
        return event(t, y[:n], *args)

    watched.__name__ = getattr(event, "__name__", "event")
    watched.__qualname__ = getattr(event, "__qualname__", "event")
    setattr(watched, AS_GIVEN, event)
    return watched
