"""Names and units of the inputs and results of an ensemble, for axes and tables."""

from typing import NamedTuple

from fastdyn.compile.callables import Y, parts_of
from fastdyn.compile.sentences import Uncompilable


class Label(NamedTuple):
    """A name, a unit ("" if none is known), and a few words."""

    name: str
    unit: str = ""
    meaning: str = ""

    def __str__(self):
        return f"{self.name} ({self.unit})" if self.unit else self.name


def component_labels(system, n):
    """A Label for each component of the state."""
    if system is not None:
        return [Label(*state) for state in system.states]
    return [Label(f"y[{i}]") for i in range(n)]


def argument_labels(fun, args, system):
    """A Label for each argument after t and y, by the names in the function's signature."""
    if system is not None:
        return [_field_label(field) for field in system.parameter_fields()]
    names = [f"args[{j}]" for j in range(len(args))]
    written = [label.name for label in argument_names(fun, args)]
    return [Label(name) for name in [*written, *names[len(written) :]][: len(args)]]


def argument_names(fun, args=()):
    """A Label for each argument that a function's signature names after t and y."""
    try:
        parts = parts_of(fun, args)
    except Uncompilable:
        return []
    code = parts.function.__code__
    first = parts.positional.index(Y) + 1
    return [Label(name) for name in code.co_varnames[first : code.co_argcount]]


def initial_labels(system):
    """A Label for each initial condition of a system."""
    return [] if system is None else [_field_label(field) for field in system.initial_fields()]


def _field_label(field):
    return Label(field.name, field.metadata.get("unit", ""), field.metadata.get("meaning", ""))
