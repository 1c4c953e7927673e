"""Events and the functions of `on_event`, checked; the functions that are called between steps."""

import functools
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from fastdyn.compile.mode import COMPLEX_EVENT, EVENT, JUMP, MATRIX, PROJECTION, SALTATION
from fastdyn.compile.sentences import warn
from fastdyn.words.kinds import noted, shown
from fastdyn.words.near import near_names, plain

ATTRIBUTES = ("terminal", "direction")  # of an event, as in SciPy
OTHER_ATTRIBUTES = {  # words of MATLAB and others
    "isterminal": "terminal", "terminate": "terminal", "terminates": "terminal", "stop": "terminal",
    "final": "terminal", "dir": "direction", "sign": "direction",
}  # fmt: skip
AS_GIVEN = "__fastdyn_event__"  # marks an event function of the first components of a longer state


def event_list(events):
    """Events as a list, each with its limit (0: not terminal) and direction."""
    if events is None:
        return None
    checked = []
    for event in (events,) if callable(events) else events:
        _warn_of_attributes(event)
        checked.append((event, _limit(event), _direction(event)))
    return checked


def _limit(event):
    """The number of occurrences of an event that end the run; 0 for one that does not."""
    terminal = getattr(event, "terminal", None)
    if terminal is None:
        return 0
    wanted = "The `terminal` attribute of each event must be a boolean or positive integer"
    note = f"{wanted}; that of `{_name(event)}` is {shown(terminal)}."
    try:
        limit = int(terminal)
    except (TypeError, ValueError, OverflowError) as error:  # SciPy's
        raise noted(error, note) from None
    if limit != terminal or limit < 0:
        raise noted(ValueError(f"{wanted}."), note)
    return limit


def _direction(event):
    """The sign of the crossings of zero that count; 0 for both."""
    direction = getattr(event, "direction", 0)
    wanted = "The `direction` attribute of each event must be a number"
    note = (
        f"{wanted}, 1 for rising, -1 for falling and 0 for both; that of `{_name(event)}` is "
        f"{shown(direction)}."
    )
    try:
        number = float(direction) if direction is not None else math.nan
    except (TypeError, ValueError) as error:  # SciPy's
        raise noted(error, note) from None
    if number != number:
        raise noted(ValueError(f"{wanted}."), note)
    return number


def _name(event):
    return getattr(event, "__name__", type(event).__name__)


def _warn_of_attributes(event):
    """Warn of attributes with names near to `terminal` and `direction`, which have no effect."""
    given = getattr(event, "__dict__", None)
    if not given or given.keys() <= {*ATTRIBUTES}:
        return
    for name in given:
        if name in ATTRIBUTES or name.startswith("_"):
            continue
        if hasattr(event, "__code__"):
            near = near_names(name, ATTRIBUTES, OTHER_ATTRIBUTES)
        else:  # an object with fields of its own
            near = [one for one in ATTRIBUTES if plain(one) == plain(name)]
        if near and near[0] not in given:
            warn(
                f"the attribute `{name}` of the event `{_name(event)}` has no effect; did you mean "
                f"`{near[0]}`?"
            )


def acting(on_event, events) -> tuple[Any, tuple]:
    """Checked events, and for each its function of `on_event` or None; () without `on_event`.

    ``terminal = True`` of an event that changes the state does not end the run; a number does.
    """
    if on_event is None:
        return events, ()
    if callable(on_event):
        jumps = (on_event,)
    elif isinstance(on_event, Iterable) and not isinstance(on_event, str):
        jumps = tuple(on_event)
    else:
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
        functions.append((p.project, PROJECTION))
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
