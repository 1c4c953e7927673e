"""Events of y as events of the reduced state.

An event is given the states, and of the other components those that it uses: an event of positions
needs no forces, which a system of equations determines.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fastdyn.compile.mode import EVENT
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near, traced_function
from fastdyn.problem.events import Event
from fastdyn.problem.schedules import Schedule
from fastdyn.trace.graph.expressions import live

from ..functions import named
from .trajectory import places


class Asked(NamedTuple):
    """The components that an event uses and that are no states, and those that it uses now."""

    solved: set
    now: Callable


def watched(event, reduction, given, asked):
    """The Event of the reduced state for an event of y; a Schedule stays.

    An Asked is appended to the list `asked`.
    """
    if isinstance(event, Schedule) or not (callable(event) or isinstance(event, Event)):
        return event
    own = Event.of(event)
    event = own.function
    system = reduction.system
    states = {k for k in range(given.n) if _place(system.given, k) in places(system)}
    used = _used(event, given)
    components = reduction.components(used | states)

    def of_state(t, x, p, *args):
        return event(t, np.array(components(t, x, p)), *args)

    asked.append(Asked(used - states, lambda: _used(event, given) - states))
    return own.like(named(of_state, event))


def check_still(asked):
    """Raise ValueError if an event now uses components that were not computed for the event."""
    for each in asked:
        more = each.now() - each.solved
        if more:
            raise ValueError(
                f"an event uses component {min(more)} of y since another function has changed what "
                "the event reads, and did not before: let the event use the component always."
            )


def _place(given, k):
    """The place of component k among all orders of all components."""
    column, order = given.place(k)
    return order * given.n + column


def _used(event, given):
    """The components of y that an event uses; all if that is not known."""
    near = Near(given.t0, given.tf, given.y0)
    found = traced_function(Attempt(event, given.args, EVENT, given.n), near)
    if found is None:
        return set(range(given.n))
    trace = found[0].traced.trace
    return {node.data for node in live([*trace.outputs, trace.raising]) if node.op == "y"}
