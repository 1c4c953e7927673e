"""The words in which a system declares itself: states, parameters, quantities, events."""

import dataclasses
import math
import numbers
from typing import Any, NamedTuple


class State(NamedTuple):
    """Name, unit and meaning of one component of the state."""

    name: str
    unit: str
    meaning: str


def parameter(default, unit, meaning, *, positive=False) -> Any:
    """
    Declare one parameter of the equations as a field of a `System`.

    Parameters
    ----------
    default : float
        Value when none is given.
    unit : str
        SI unit, as it appears in tables and on axes.
    meaning : str
        What the number is, in a few words.
    positive : bool
        Refuse values that are not greater than zero.
    """
    about = {"unit": unit, "meaning": meaning, "positive": positive}
    return dataclasses.field(default=default, metadata=about)


def initial(default, unit, meaning, *, positive=False) -> Any:
    """
    Declare one number that sets the initial state and nothing else, as a field of a `System`.

    The functions of the system are not given it; `System.initial_state` uses it.

    Parameters
    ----------
    default, unit, meaning, positive
        As for `parameter`.
    """
    about = {"unit": unit, "meaning": meaning, "positive": positive, "initial": True}
    return dataclasses.field(default=default, metadata=about)


def quantity(unit, label=None):
    """Give a function of (t, y, \\*parameters) a unit and a label for axes and tables."""

    def attach(function) -> Any:
        function.unit = unit
        function.label = label or function.__name__.replace("_", " ")
        return function

    return attach


def event(*, direction=0, terminal=False):
    """Give an event function the attributes that `solve_ivp` looks for."""

    def attach(function) -> Any:
        function.direction = direction
        function.terminal = terminal
        return function

    return attach


def checked(system, field, value):
    """Value of a parameter as a float, or a sentence about what is wrong with it."""
    if "unit" not in field.metadata:
        return value
    unit = field.metadata["unit"]
    about = f"Parameter `{field.name}` of the {system} ({field.metadata['meaning']}, {unit})"
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise TypeError(f"{about} must be one real number, but {value!r} was given.")
    value = float(value)
    if not math.isfinite(value):
        raise ValueError(f"{about} must be finite, but {value} was given.")
    if field.metadata["positive"] and value <= 0.0:
        raise ValueError(f"{about} must be greater than zero, but {value:g} was given.")
    return value
