"""The keys of calls of `solve_ivp`: what calls of one kind have in common, but no values."""

import types as python
from typing import Any

import numpy as np

from fastdyn.problem.events import Event, asked_of
from fastdyn.problem.options.table import OPTIONS
from fastdyn.run.again import keyed_code

FUNCTION = python.FunctionType
BY_CODE = {option.name: None for option in OPTIONS.values() if option.in_key == "code"}
DERIVATIVES = "sensitivity", "adjoint"
COMPLEX = "complex"  # the last part of the key of calls with a complex state


def options_of(asked):
    """The options of Arguments as the caller gave them."""
    return asked.options | _given(asked.sensitivity, asked.adjoint)


def _given(*derivatives):
    """The options of DERIVATIVES that are not None, which stand behind the others in a key."""
    pairs = zip(DERIVATIVES, derivatives, strict=True)
    return {name: value for name, value in pairs if value is not None}


def key_of(asked, method):
    """The key of Arguments by a method, and the functions that are called between steps."""
    a = asked
    options = options_of(a)
    rest: tuple = ()
    others: tuple = ()
    if options or a.t_eval is not None or a.events is not None or a.dense_output or a.vectorized:
        rest, others = rest_of(a.t_eval, a.dense_output, a.events, a.vectorized, options)
    kind = a.fun.__class__, id(keyed_code(a.fun)), len(a.y0), method, len(a.args), *rest
    if a.y0.dtype.kind == "c":
        kind = *kind, COMPLEX
    return hashable(kind), others


def rest_of(t_eval, dense_output, events, vectorized, options):
    """The part of the key that most calls do not have, and the functions of the events."""
    watched = None
    functions = ()
    if len(options) > 1 and ("sensitivity" in options or "adjoint" in options):
        options = dict(options)
        derivatives = [options.pop(name, None) for name in DERIVATIVES]
        options |= _given(*derivatives)
    acting = ()
    if options and not BY_CODE.keys().isdisjoint(options):
        options, acting = _by_code(options)
    if events is not None:
        if events.__class__ is FUNCTION and not events.__dict__:
            watched = id(events.__code__)
            functions = (events,)
        else:
            watched, functions = _watched(events)
    rest = (
        None if t_eval is None else len(t_eval), dense_output, vectorized, watched, *options,
        *options.values(),
    )  # fmt: skip
    return rest, functions + acting


def _by_code(options):
    """The options, with the code in place of functions, and these in the order of a Problem's."""
    options = dict(options)
    functions = []
    for name in [name for name in BY_CODE if name in options]:
        given = options[name]
        several = given.__class__ is list or given.__class__ is tuple
        key: list[Any] = [several]
        for function in given if several else (given,):
            key.append(None if function is None else id(keyed_code(function)))
            if function is not None:
                functions.append(function)
        options[name] = tuple(key)
    return options, tuple(functions)


def _watched(events):
    """The key of events, by their code and their rules, and their functions.

    TypeError for what calls again do not take: what can be read once only, and events that have
    occurred before the run, whose rules are not those of their functions.
    """
    if callable(events) or events.__class__ is Event:
        events = (events,)
    if events.__class__ is not list and events.__class__ is not tuple:
        raise TypeError
    key = []
    functions = []
    for event in events:
        key += id(keyed_code(event)), asked_of(event)
        if isinstance(event, Event):
            if event.has_occurred:
                raise TypeError
            key += event.beyond().items()
            event = event.function
        functions.append(event)
    return tuple(key), tuple(functions)


def hashable(kind):
    """A key with the contents of lists, and of arrays of numbers, which may change in place."""
    return tuple([
        (value.dtype.str, value.shape, value.tobytes())
        if value.__class__ is np.ndarray and value.dtype.kind in "fiu"
        else (list, *value) if value.__class__ is list
        else value
        for value in kind
    ])  # fmt: skip
