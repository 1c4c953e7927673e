"""The keys of calls of `solve_ivp`: what calls of one kind have in common, but no values."""

import operator
import types as python
from typing import Any

import numpy as np

from fastdyn.compile import memory
from fastdyn.problem.events import BETWEEN, NOTHING_ASKED, Event, asked_of
from fastdyn.problem.options.table import OPTIONS
from fastdyn.run.again import keyed_code

FUNCTION = python.FunctionType
# In the order of `called_between`.
OF_FUNCTIONS = "on_event", *(called.option for called in BETWEEN.values())
BY_CODE = sorted((o.name for o in OPTIONS.values() if o.in_key == "code"), key=OF_FUNCTIONS.index)
BY_KINDS = [option.name for option in OPTIONS.values() if option.in_key == "kinds"]
OTHERS = {*BY_CODE, *BY_KINDS}  # the options whose values are not the part of a key
FIELDS = "sensitivity", "adjoint", "error_estimate"  # options that are fields of Arguments
COMPLEX = "complex"  # the last part of the key of calls with a complex state
N_BEFORE = 5  # parts of a key before those of `rest_of`
LEAVES = (int, float, str, np.generic, type(None))  # of lists
VALUES = (*LEAVES, list, tuple, np.ndarray)  # of the options that are known by values


def is_known(option, value):
    """Whether calls with this value of an Option are known by their key."""
    if option.in_key == "code" and callable(value):
        return True
    return bool(option.in_key) and isinstance(value, VALUES) and _is_lasting(value)


def _is_lasting(value):
    """Whether a value has no parts of other kinds, which may change while their hash does not."""
    if value.__class__ is list or value.__class__ is tuple:
        return all(callable(part) or _is_lasting(part) for part in value)
    return isinstance(value, LEAVES) or value.__class__ is np.ndarray


def options_of(asked):
    """The options of Arguments as the caller gave them."""
    return asked.options | _given([getattr(asked, name) for name in FIELDS])


def _given(values):
    """The options of FIELDS that are not None, which stand behind the others in a key."""
    pairs = zip(FIELDS, values, strict=True)
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
    functions = called = names = values = ()
    if options:
        names, fields, has_others, values_of = _order(tuple(options))
        for name in fields:
            if options[name] is None:
                given = {k: v for k, v in options.items() if v is not None or k not in FIELDS}
                return rest_of(t_eval, dense_output, events, vectorized, given)
        if has_others:
            options, called = _by_code(options)
        values = values_of(options)
    if events is not None:
        if events.__class__ is FUNCTION and not events.__dict__:
            watched = id(events.__code__)
            functions = (events,)
        else:
            watched, functions = _watched(events)
    rest = (
        None if t_eval is None else len(t_eval), dense_output, vectorized, watched, names, *values,
    )  # fmt: skip
    return rest, functions + called


@memory.cached
def _order(names):
    """The order of options in a key: FIELDS stand last.

    With those of FIELDS, whether some are of OTHERS, and a function that takes the values in order.
    """
    fields = [name for name in FIELDS if name in names]
    ordered = *[name for name in names if name not in FIELDS], *fields
    values_of = operator.itemgetter(*ordered) if len(ordered) > 1 else dict.values
    return ordered, fields, not OTHERS.isdisjoint(names), values_of


def _by_code(options):
    """The options, with the code in place of functions, and these in the order of a Problem's."""
    options = dict(options)
    functions = []
    for name in BY_CODE:
        given: Any = options.get(name)
        if given.__class__ is FUNCTION:  # most are
            options[name] = False, id(given.__code__)
            functions.append(given)
        elif given is not None:
            options[name], called = _code_of(given)
            functions += called
    for name in BY_KINDS:
        given = options.get(name)
        if given is not None and given.__class__ is not np.ndarray:
            options[name] = _with_kinds(given)
    return options, tuple(functions)


def _code_of(given):
    """The key of an option by its code, and its functions; a matrix or a word is its own key."""
    several = given.__class__ is list or given.__class__ is tuple
    among = given if several else (given,)
    functions = [each for each in among if callable(each)]
    if not functions:
        try:
            return np.asarray(given) if several and any(among) else given, functions
        except ValueError:  # rows of several lengths
            raise TypeError from None
    codes = [None if each is None else id(keyed_code(each)) for each in among]
    return (several, *codes), functions


def _with_kinds(value):
    """A value with its type and those of its parts: True equals 1, and is not the index 1."""
    if value.__class__ is list or value.__class__ is tuple:
        return (*value, *map(type, value))
    return value.__class__, value


def with_times(key, n):
    """The key of calls like those of a key, with n times of output."""
    return *key[:N_BEFORE], n, *key[N_BEFORE + 1 :]


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
        code = event.__code__ if event.__class__ is FUNCTION else keyed_code(event)
        asked = asked_of(event)
        key += id(code), asked
        if asked is not NOTHING_ASKED:  # True is not the number 1 of an event that acts
            key.append(tuple(map(type, asked)))
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
        if value.__class__ is np.ndarray and value.dtype.kind in "fiub"
        else (list, *hashable(value)) if value.__class__ is list
        else value
        for value in kind
    ])  # fmt: skip
