"""Finds the changes that a run made in copies of outside objects."""

import types

import numpy as np

PLAIN = (bool, int, float, complex, str, bytes)
IGNORED = "__warningregistry__"  # Python notes here the warnings that were shown


def content(thing):
    """The changeable parts of the copy of an object, in a form that `changed` compares."""
    if isinstance(thing, np.ndarray):
        return np.array(thing)
    if isinstance(thing, types.CellType):
        try:
            return [thing.cell_contents]
        except ValueError:  # an empty cell
            return []
    if isinstance(thing, types.FunctionType):
        own = thing.__code__, thing.__defaults__, thing.__kwdefaults__, thing.__name__
        return [*own, thing.__doc__, *vars(thing), *vars(thing).values()]
    if isinstance(thing, type):
        return dict(vars(thing))
    if isinstance(thing, dict):
        return dict.copy(thing)
    if isinstance(thing, list):
        return list.copy(thing)
    return set(thing) if isinstance(thing, set) else list(getattr(thing, "flat", thing))


def changed(thing, before):
    """Whether the copy of an object differs from its `content` before the run."""
    if isinstance(before, np.ndarray):
        now = np.asarray(thing)
        return not np.array_equal(now, before, equal_nan=now.dtype.kind in "fc")
    now = content(thing)
    if isinstance(now, set):
        return now != before
    if isinstance(now, dict):
        return now.keys() - {IGNORED} != before.keys() - {IGNORED} or any(
            value is not now[name] for name, value in before.items() if name != IGNORED
        )
    return len(now) != len(before) or not all(map(_same, now, before))


def _same(a, b):
    """Whether two values are equal, including the signs of zeros."""
    if a is b:
        return True
    if type(a) is not type(b) or not (type(a) in PLAIN or isinstance(a, np.generic)):
        return False
    return a == b and repr(a) == repr(b)  # repr shows the sign of a zero
