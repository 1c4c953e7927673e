"""A plain function ``fun(t, y, *args)`` as a system, so that it has a page."""

import dataclasses
import inspect
import keyword
from typing import Any

from fastdyn.problem.events import ATTRIBUTES, asked_of
from fastdyn.systems.base import State, System, initial, parameter
from fastdyn.systems.base.declare import event

END = 10.0  # s, of a run whose end is not given
OWN = {name for base in System.__mro__ for name in getattr(base, "__annotations__", ())}


def system_of(function, name, y0, args, events, t_end=END):
    """
    The system of a function, with a slider for each number among the arguments and in the state.

    Parameters
    ----------
    function : callable
        ``fun(t, y, *args)``
    name : str
    y0 : sequence of float
    args : tuple
    events : dict of str to callable
    t_end : float
    """
    names = list(inspect.signature(function).parameters)[2:] + [""] * len(args)
    starts = [f"y{i}" for i in range(len(y0))]
    space: dict[str, Any] = {"__annotations__": {}}
    for k, value in enumerate(args):
        field = _free(names[k] or f"a{k}", {*space, *starts})
        number = isinstance(value, float | int) and not isinstance(value, bool)
        space["__annotations__"][field] = float if number else Any
        space[field] = parameter(float(value), "", field) if number else value
    for start, value in zip(starts, y0, strict=True):
        space["__annotations__"][start] = float
        space[start] = initial(float(value), "", f"{start} at the start")
    space |= {
        "name": name, "title": name, "source": "fun(t, y, *args)", "t_end": float(t_end),
        "states": tuple(State(f"y{i}", "", "") for i in range(len(y0))),
        "rhs": staticmethod(function), "of_function": True,
        "initial_state": lambda self: tuple([getattr(self, start) for start in starts]),
    }  # fmt: skip
    for key, one in events.items():
        space[f"event_{key}"] = _event(one)
    made = type("OfFunction", (System,), space)
    made.events = dict(zip(events, made.events.values(), strict=True))
    return dataclasses.dataclass(frozen=True)(made)()


def _event(function):
    """An event of the user, as systems have events."""

    def of(t, w, *args):
        return function(t, w, *args)

    found = event()(of)
    for rule, value in zip(ATTRIBUTES, asked_of(function), strict=True):
        if value is not None:
            setattr(found, rule, value)
    return found


def _free(name, taken):
    """A name for a field that no other attribute of a system has."""
    while name in taken | OWN or hasattr(System, name) or keyword.iskeyword(name):
        name += "_"
    return name
