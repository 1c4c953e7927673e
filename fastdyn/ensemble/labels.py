"""Names and units of what an ensemble varies and computes, for axes and tables."""

import dataclasses
from typing import NamedTuple

import numpy as np

from fastdyn.compile.diagnostics import Uncompilable
from fastdyn.compile.unwrap import Y, parts_of

TIMES = ("max_time", "min_time", "first_event")  # reductions that are times


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
    """A Label for each argument after t and y, by the names in the function's head."""
    if system is not None:
        fields = dataclasses.fields(system)
        told = [(f.name, f.metadata.get("unit", ""), f.metadata.get("meaning", "")) for f in fields]
        return [Label(*each) for each in told]
    names = [f"args[{j}]" for j in range(len(args))]
    try:
        parts = parts_of(fun, args)
    except Uncompilable:
        return [Label(name) for name in names]
    code, first = parts.function.__code__, parts.positional.index(Y) + 1
    written = code.co_varnames[first : code.co_argcount]
    return [Label(name) for name in [*written, *names[len(written) :]][: len(args)]]


def varied(trajectories):
    """What tells the trajectories apart: (Label, values) of parameters, and of initial states."""
    labels = trajectories.argument_labels
    parameters = [(labels[j], column) for j, column in trajectories.parameters.items()]
    y0 = trajectories.y0
    differ = np.flatnonzero((y0 != y0[:1]).any(axis=0))
    starts = [label._replace(name=f"{label.name} at the start") for label in trajectories.labels]
    return parameters, [(starts[i], y0[:, i]) for i in differ]
