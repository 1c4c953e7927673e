"""The arguments of a solve that a system fills in: events, tolerances, projection."""

import dataclasses
from collections.abc import Iterable
from typing import Any

import numpy as np

from fastdyn.problem.options.names import refuse_unknown
from fastdyn.problem.options.table import OPTIONS, defaults_of
from fastdyn.problem.step_options import within
from fastdyn.problem.validate import method_named, time_span
from fastdyn.words.kinds import shown
from fastdyn.words.near import did_you_mean

OF_SOLVE = {"t_span", "y0", "method", "t_eval", "dense_output", "events", "vectorized", "project"}
DEFAULTS = defaults_of("systems")


def completed(system, method, options, t_span=None, of_ensemble=None) -> dict[str, Any]:
    """Options of a solver with the system's events and breakpoints, and default tolerances.

    Breakpoints are those within `t_span`, if it is given.  `of_ensemble` has the names that
    `ensemble` takes, if the options are for an ensemble.
    """
    for name in {"args", "params", "parameters"}.intersection(options):
        first = next(iter(dataclasses.fields(system))).name
        raise TypeError(
            f"`{name}` of the {system.name} are its parameters; set them by name, "
            f"{system.name}({first}=...)."
        )
    if "stabilise" in options:
        raise TypeError(
            "`stabilise` is no option any more: write `solve(project=True)` for the projection, "
            "`system.baumgarte().solve()` for Baumgarte's pull."
        )
    automatic = isinstance(method, str) and method == "auto"
    ours = None if automatic else method_named(method)
    if ours is not None or automatic:
        _refuse_unknown(system, options, of_ensemble)
    options = dict(options)
    if "events" in options:
        options["events"] = event_functions(system, options["events"])
    if ours is None or ours.error_order:
        if ours is None or not ours.like_matlab:
            options = DEFAULTS | options
        if system.breakpoints is not None and (ours is not None or automatic):
            times = system.breakpoints if t_span is None else within(system.breakpoints, *t_span)
            if times is not None:
                options.setdefault("breakpoints", times)
    return options


def _refuse_unknown(system, options, of_ensemble):
    """Raise TypeError for a name that the solver of a system does not know."""
    if of_ensemble is not None:
        refuse_unknown(f"`ensemble` of the {system.name}", options, of_ensemble)
        return
    own = {field.name for field in dataclasses.fields(system)}
    for name in own.intersection(options):
        raise TypeError(
            f"`{name}` is a parameter of the {system.name}, not of `solve`: write "
            f"{system.name}({name}={options[name]!r}).solve()."
        )
    refuse_unknown(f"`solve` of the {system.name}", options, OPTIONS.keys() | OF_SOLVE | own)


def span(system, t_span):
    """Start and end of a solve."""
    if t_span is None:
        return 0.0, system.t_end
    if np.ndim(t_span) == 0:
        raise TypeError(f"`t_span` must be start and end; got {t_span}: (0, {t_span})?")
    return time_span(t_span)


def projection(system, project):
    """The function for `project`: None, the function of the system, or a function of the user."""
    if project is None or project is False:
        return None
    if callable(project):
        return project
    if project is not True:
        raise TypeError(f"`project` must be True, False or a function; got {project!r}.")
    if not hasattr(system, "project"):
        raise ValueError(f"The {system.name} has no constraints to project onto.")
    return system.project


def full_state(system, y0):
    """`y0` as an array; raises ValueError if it has not the length of the state."""
    if np.shape(y0) != (len(system.states),):
        names = ", ".join(state.name for state in system.states)
        raise ValueError(
            f"`y0` of the {system.name} must be {len(system.states)} numbers ({names}); got "
            f"{shown(y0)}."
        )
    return y0


def event_functions(system, events):
    """Events as functions; names are replaced by the events of the system."""
    if isinstance(events, str) or callable(events):
        events = [events]
    if events is None or not isinstance(events, Iterable):
        return events
    events = list(events)
    for event in events:
        if isinstance(event, str) and event not in system.events:
            known = ", ".join(system.events) or "none"
            advice = did_you_mean(event, system.events) or f"its events are: {known}."
            raise ValueError(f"{system.name} has no event '{event}'; {advice}")
    return [system.events[event] if isinstance(event, str) else event for event in events]
