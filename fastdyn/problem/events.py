"""Events and the functions of `on_event`, checked; the functions that are called between steps."""

import dataclasses
import math
from collections.abc import Callable, Iterable
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.mode import COMPLEX_EVENT, EVENT, JUMP, MATRIX, PROJECTION, SALTATION
from fastdyn.compile.sentences import warn
from fastdyn.words.kinds import noted, shown
from fastdyn.words.near import near_names, plain

SCIPYS = ("terminal", "direction")  # attributes of an event in SciPy
ATTRIBUTES = (*SCIPYS, "wait")
NOTHING_ASKED = (None,) * len(ATTRIBUTES)
OTHER_ATTRIBUTES = {  # words of MATLAB and others
    "isterminal": "terminal", "terminate": "terminal", "terminates": "terminal", "stop": "terminal",
    "final": "terminal", "dir": "direction", "sign": "direction", "debounce": "wait",
    "dead_time": "wait", "refractory": "wait",
}  # fmt: skip


@dataclasses.dataclass(frozen=True, slots=True)
class Event:
    """An event: a function whose zeros occur, the rules which of them count, and what they do.

    `of` makes an Event of a user's function; every solver takes an Event in the place of the
    function.  A rule is a field that `RULES` names, and a field of the record in compiled code.

    Attributes
    ----------
    function : callable or None
        Of (t, y, *args), perhaps a form of the user's function for a longer state; None where
        compiled code stands for the function.
    limit : int
        The number of occurrences that ends the run; 0: none does.
    direction : float
        The sign of the crossings that count; 0 for both.
    wait : float
        The time after an occurrence in which no other one counts.
    last : float
        The time of the last occurrence before the run; NaN without any.
    act : callable or None
        The function of `on_event`.
    decides : bool
        Whether the event ends a phase.
    origin : callable or None
        The function of a shorter state, if `function` is a form of one (`of_own`).
    turns : bool
        Whether an event that is much faster than the solution is looked at in parts of a step.
    asked : tuple
        The attributes of the user's function, as `ATTRIBUTES` names them, when they were read.
    """

    function: Any
    limit: int = 0
    direction: float = 0.0
    wait: float = 0.0
    last: float = math.nan
    act: Any = None
    decides: bool = False
    origin: Any = None
    turns: bool = True
    asked: tuple = ()

    @classmethod
    def of(cls, given):
        """The Event of a user's function or schedule; an Event stays."""
        if isinstance(given, cls):
            return given
        _warn_of_attributes(given)
        rules: Any = {name: read(given) for name, read in RULES.items()}
        return cls(given, **rules, asked=asked_of(given))

    def like(self, function):
        """The event with another function: a form of its function for another state."""
        return dataclasses.replace(self, function=function)

    def form(self, function):
        """The event with a form of its function for a longer state, which has the same name."""
        for name in ("__name__", "__qualname__"):
            setattr(function, name, getattr(self.function, name, "event"))
        return self.changed(function=function, origin=self.function)

    def changed(self, **fields):
        """The event with other values of some fields."""
        return dataclasses.replace(self, **fields)

    def acting(self, change):
        """The event with ``change(act)`` as its action; an event without action stays."""
        return self if self.act is None else self.changed(act=change(self.act))

    @property
    def rules(self):
        """The values of the rules, by their names, and the time of the last occurrence."""
        return {name: getattr(self, name) for name in (*RULES, "last")}

    def beyond(self, *known):
        """The rules that change which zeros count, without `known`: their values by their names."""
        others = {name: getattr(self, name) for name in RULES if name not in known}
        return {name: value for name, value in others.items() if value != getattr(PLAIN, name)}

    @property
    def steers(self):
        """True if the event decides what follows, by its action or as the end of a phase.

        Each crossing counts then, also two within a step of a method that counts one, as SciPy.
        """
        return self.decides or self.act is not None

    @property
    def has_occurred(self):
        """True if the event has occurred before the run."""
        return not math.isnan(self.last)

    @property
    def name(self):
        """The name of the user's function; None without a name."""
        return getattr(self.function, "__name__", None)


def asked_of(event):
    """The attributes of a user's event function, as `Event.asked`."""
    if event.__class__ is Event:
        return event.asked
    if event.__class__ is FunctionType:  # in a fifth of the time
        asked = event.__dict__
        return tuple(map(asked.get, ATTRIBUTES)) if asked else NOTHING_ASKED
    return tuple([getattr(event, name, None) for name in ATTRIBUTES])


def event_list(events) -> Any:
    """Events as a list of Event; None for None."""
    if events is None:
        return None
    given: Any = (events,) if callable(events) or isinstance(events, Event) else events
    return [Event.of(event) for event in given]


def for_scipy(events, args):
    """Event functions of (t, y) alone, with the attributes that SciPy reads.

    Raises
    ------
    ValueError
        For a rule that SciPy does not have.
    """
    if events is None:
        return None
    found = []
    for event in event_list(events):
        for name, value in zip(ATTRIBUTES, event.asked, strict=True):
            if value is not None and name not in SCIPYS:
                raise ValueError(
                    f"`{name}` of the event `{_name(event.function)}` is for fastdyn's methods, "
                    f"and this solve is SciPy's, which has {' and '.join(SCIPYS)} alone: take a "
                    "compiled method and a real state."
                )
        found.append(_with_args(event, args))
    return found


def _with_args(event, args):
    """The function of an Event that SciPy calls."""
    function = event.function
    if not args and asked_of(function) == event.asked:
        return function

    def with_args(t, y):
        return function(t, y, *args)

    for name, value in zip(ATTRIBUTES, event.asked, strict=True):
        if value is not None:
            setattr(with_args, name, value)
    return with_args


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


def _wait(event):
    """The time after an occurrence in which no other one counts."""
    wait = getattr(event, "wait", 0.0)
    try:
        number = float(wait)
    except (TypeError, ValueError):
        number = math.nan
    if not number >= 0.0:
        raise ValueError(
            "The `wait` attribute of each event must be a time, 0 or above: no occurrence counts "
            f"within `wait` of the last one; that of `{_name(event)}` is {shown(wait)}."
        )
    return number


class Called(NamedTuple):
    """A function that is called between steps: its mode, and the option that it is given by."""

    mode: Any
    option: str


# By fields of a Problem, in the order of `between_steps`; events and their actions stand before.
BETWEEN = {
    "inside": Called(EVENT, "domain"),
    "project": Called(PROJECTION, "project"),
    "jac": Called(MATRIX, "jac"),
}
# By fields of Event, which are fields of a row of compiled code, too.
RULES: dict[str, Callable] = {"limit": _limit, "direction": _direction, "wait": _wait}
PLAIN = Event(None)


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


def acting(on_event, events) -> Any:
    """Checked events with their functions of `on_event`.

    ``terminal = True`` of an event that changes the state does not end the run; a number does.
    """
    if on_event is None:
        return events
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
    found = []
    for event, jump in zip(events or (), jumps, strict=True):
        unlimited = isinstance(event.asked[0], bool | np.bool_)  # `terminal`
        limit = 0 if jump is not None and unlimited else event.limit
        found.append(event.changed(act=jump, limit=limit))
    return events and found


def endless(tf, events, max_steps, schedules=()):
    """Refuse an infinite span if neither an event nor `max_steps` ends the run."""
    if (
        math.isinf(tf)
        and max_steps is None
        and not any(each.limit for each in (*(events or ()), *schedules))
    ):
        raise ValueError(
            f"`t_span` ends at {tf} and nothing stops the run before: "
            "give a terminal event or `max_steps`."
        )


def between_steps(problem):
    """(function, mode) of the events, of `on_event`, the domain, the projection, the Jacobian."""
    p = problem
    event_mode = COMPLEX_EVENT if p.mode.complex_numbers else EVENT
    events = p.events or ()
    functions = [(event.function, event_mode) for event in events]
    changes = SALTATION if p.mode.sensitivities else JUMP
    functions += [(jump, changes) for jump in p.jumps if jump is not None]
    return functions + [
        (getattr(p, name), called.mode)
        for name, called in BETWEEN.items()
        if getattr(p, name) is not None
    ]


def called_between(problem):
    """The functions of `between_steps`, without a Jacobian that is a matrix."""
    return [given for given, mode in between_steps(problem) if callable(given) or not mode.matrix]


def apart(problem, functions):
    """Functions in the order of `called_between`: of events and their actions, others by field."""
    given = [getattr(problem, name) for name in BETWEEN]
    names = [n for n, f in zip(BETWEEN, given, strict=True) if f is True or callable(f)]
    n = len(functions) - len(names)
    return [*functions[:n]], dict(zip(names, functions[n:], strict=True))


def with_functions(problem, functions):
    """The problem with other functions, in the order of `called_between`."""
    p = problem
    first, others = apart(p, functions)
    given = iter(first)
    events = p.events and [event.like(next(given)) for event in p.events]
    events = events and [event.acting(lambda _: next(given)) for event in events]
    schedules = [
        each if each.jump is None else each._replace(jump=next(given)) for each in p.schedules
    ]
    return p._replace(events=events, schedules=tuple(schedules), **others)


def of_own(event, n):
    """An Event as one of a longer state, whose first n components are the event's state."""
    return event.form(of_first(event.function, n))


def of_first(given: Any, n):
    """A function of a longer state, of whose first n components `given` is a function."""

    def watched(t, y, *args):
        return given(t, y[:n], *args)

    return watched


def without_functions(problem):
    """A problem without the user's functions and arguments, which are only marked."""
    p = problem
    events = p.events and [
        e.changed(function=None, origin=None, act=e.act and True) for e in p.events
    ]
    schedules = tuple([each._replace(jump=each.jump and True) for each in p.schedules])
    marked: Any = {name: True for name in (*BETWEEN, "domain") if callable(getattr(p, name))}
    return p._replace(fun=None, args=(), events=events, schedules=schedules, **marked)
