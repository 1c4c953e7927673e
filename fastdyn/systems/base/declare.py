"""The words in which a system declares itself: states, parameters, quantities, events."""

import dataclasses
import functools
import inspect
import math
import numbers
from typing import Any, ClassVar, NamedTuple, cast

import numpy as np

from fastdyn.plot.displayed import table
from fastdyn.words.near import did_you_mean

from .units import is_number, magnitude, said_in_unit, warn_of_degrees


class State(NamedTuple):
    """Name, unit and meaning of one component of the state."""

    name: str
    unit: str
    meaning: str


def parameter(default, unit, meaning, *, positive=False, negative=True) -> Any:
    """
    Declare one parameter of the equations as a field of a `System`.

    Parameters
    ----------
    default : float
        The default value.
    unit : str
        SI unit, for tables and axes.
    meaning : str
        A few words about the parameter.
    positive : bool
        True if values must be greater than zero.
    negative : bool
        False if values must not be below zero.
    """
    about = {"unit": unit, "meaning": meaning, "positive": positive, "negative": negative}
    return dataclasses.field(default=default, metadata=about)


def initial(default, unit, meaning, *, positive=False, negative=True) -> Any:
    """
    Declare one number that only sets the initial state, as a field of a `System`.

    `System.initial_state` uses the number; the functions of the system do not get the number.

    Parameters
    ----------
    default, unit, meaning, positive, negative
        As for `parameter`.
    """
    about = parameter(default, unit, meaning, positive=positive, negative=negative).metadata
    return dataclasses.field(default=default, metadata={**about, "initial": True})


def quantity(unit, label=None, *, group="quantities"):
    """Give a function of (t, y, \\*parameters) a unit and a label for axes and tables."""

    def attach(function) -> Any:
        function.unit = unit
        function.label = label or function.__name__.replace("_", " ")
        function.group = group
        return function

    return attach


def invariant(unit, label=None):
    """As `quantity`, for a function that the exact motion keeps constant."""
    return quantity(unit, label, group="invariants")


def constraint(unit, label=None):
    """As `quantity`, for the residual of a constraint."""
    return quantity(unit, label, group="constraints")


def event(*, direction=0, terminal=False):
    """Give an event function the attributes `direction` and `terminal` of `solve_ivp`."""

    def attach(function) -> Any:
        function.direction = direction
        function.terminal = terminal
        function.group = "events"
        return function

    return attach


def derived(unit) -> type[property]:
    """Make a method a property that `System.derived` lists, with its unit."""
    return cast(Any, functools.partial(Derived, unit=unit))


class of_instance:
    """A method that raises a helpful sentence when it is called on the class."""

    def __init__(self, method):
        self._method = method
        self.__doc__ = method.__doc__

    def __get__(self, instance, owner) -> Any:
        if instance is not None:
            return self._method.__get__(instance, owner)
        method = self._method

        @functools.wraps(method)
        def called(*args, **named):
            if args and isinstance(args[0], Declared):
                return method(*args, **named)
            name = getattr(owner, "name", owner.__name__)
            raise TypeError(
                f"`{name}` is a class of systems, and `{method.__name__}` is for one of them: "
                f"write {name}().{method.__name__}(...), with its parameters in the first brackets."
            )

        return called


class Derived(property):
    """A property with a unit."""

    def __init__(self, function, unit):
        super().__init__(function)
        self.unit = unit


def checked(system, field, value):
    """The value of a parameter as a float; raises a sentence for a wrong value."""
    if "unit" not in field.metadata:
        return value
    unit = field.metadata["unit"]
    about = f"Parameter `{field.name}` of the {system} ({field.metadata['meaning']}, {unit})"
    try:
        value = magnitude(value, unit)
    except ValueError as error:
        raise ValueError(f"{about}: {error}") from None
    if isinstance(value, str) and is_number(value):
        try:
            value = said_in_unit(f"`{field.name}` of the {system}", value, unit)
        except ValueError as error:
            raise ValueError(f"{about}: {error}") from None
    elif isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise TypeError(f"{about} must be one real number, but {value!r} was given.")
    else:
        warn_of_degrees(f"`{field.name}` of the {system}", float(value), unit)
    value = float(value)
    if not math.isfinite(value):
        raise ValueError(f"{about} must be finite, but {value} was given.")
    if field.metadata["positive"] and value <= 0.0:
        raise ValueError(f"{about} must be greater than zero, but {value:g} was given.")
    if not field.metadata["negative"] and value < 0.0:
        raise ValueError(
            f"Parameter `{field.name}` of the {system} must not be negative, but is {value:g}."
        )
    return value


def documented(cls) -> str:
    """The docstring of a system, completed by its source and by parameters without description."""
    own = {name: one for name, one in vars(cls).items() if isinstance(one, dataclasses.Field)}
    fields = getattr(cls, "__dataclass_fields__", {}) | own
    text, notes, rest = inspect.cleandoc(cls.__doc__).partition("\n\nNotes\n-----\n")
    text, _, described = text.partition("\n\nParameters\n----------\n")
    lines = [text, "", "Parameters", "----------"]
    for name, field in fields.items():
        if "unit" in field.metadata and f"\n{name} : " not in f"\n{described}":
            lines += _described(name, field.default, **field.metadata)
    lines += [described] if described else []
    lines += ["", "Raises", "------", "TypeError, ValueError"]
    lines += ["    For an unknown parameter, and for one that is not as said above."]
    return "\n".join(lines) + f"{notes}{rest}\n\nSource: {cls.source}."


def _described(name, default, unit, meaning, positive, negative, **_):
    """Lines of a docstring about one parameter."""
    bound = ", greater than zero" if positive else "" if negative else ", not negative"
    about = f"{meaning[0].upper()}{meaning[1:]} ({unit}){bound}."
    return [f"{name} : float, default {default:g}", f"    {about}"]


@dataclasses.dataclass(frozen=True)
class Declared:
    """The base of declared classes: a name, and fields that are checked numbers with units."""

    name: ClassVar[str]

    def __new__(cls, *values, **named):
        allowed = [field.name for field in dataclasses.fields(cls)]
        unknown = [name for name in named if name not in allowed]
        if unknown:
            advice = did_you_mean(unknown[0], allowed) if len(unknown) == 1 else ""
            advice = advice or f"its parameters are {', '.join(allowed) or 'none'}."
            wrong = ", ".join(f"`{name}`" for name in unknown)
            raise TypeError(f"{cls.name} has no parameter {wrong}; {advice}")
        return super().__new__(cls)

    def __post_init__(self):
        for field in dataclasses.fields(self):
            value = checked(self.name, field, getattr(self, field.name))
            object.__setattr__(self, field.name, value)

    def __str__(self):
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        parts = [f"{name}={_short(value)}" for name, value in values.items()]
        return f"{self.name}({', '.join(part for part in parts if part[-1] != '=')})"

    def _repr_html_(self):
        rows = []
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            unit = field.metadata.get("unit", "")
            meaning = field.metadata.get("meaning", "")
            shown = f"{value:.7g}" if isinstance(value, float) else _short(value)
            if shown:
                rows.append((field.name, shown, unit, "" if meaning == field.name else meaning))
        title = f"{getattr(self, 'title', self.name)} ({self.name})"
        return table(title, rows, ("parameter", "value", "unit", "meaning"))

    @property
    def args(self) -> tuple:
        """Values of the parameters in the order in which the functions take them."""
        return tuple(getattr(self, field.name) for field in self.parameter_fields())

    @classmethod
    def parameter_fields(cls) -> list[dataclasses.Field]:
        """Fields that are arguments of the functions, in their order."""
        return [one for one in dataclasses.fields(cls) if "initial" not in one.metadata]

    @classmethod
    def initial_fields(cls) -> list[dataclasses.Field]:
        """Fields that set the initial state, and are no arguments."""
        return [one for one in dataclasses.fields(cls) if "initial" in one.metadata]


def _short(value):
    """A parameter as a few words; nothing for None."""
    if value is None:
        return ""
    if isinstance(value, np.ndarray):
        return f"array{value.shape}"
    return getattr(value, "__name__", None) or f"{value!r}"
