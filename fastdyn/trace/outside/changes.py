"""Finds the changes that a run made in copies of outside objects."""

import collections
import types

import numpy as np

from .copies import slots_of

PLAIN = (bool, int, float, complex, str, bytes)
OF_FUNCTIONS = ("__code__", "__defaults__", "__kwdefaults__", "__name__", "__doc__")
IGNORED = {"__warningregistry__"}  # Python notes here the warnings that were shown


def changed(copy, before):
    """Whether a copy differs from its content before the run."""
    if isinstance(copy, np.ndarray | list | collections.deque):
        now = list(copy.flat) if isinstance(copy, np.ndarray) else [*iter(copy)]
        return len(now) != len(before) or not all(map(_same, now, before))
    if isinstance(copy, set):
        return copy != before
    if isinstance(copy, dict):
        return dict.keys(copy) - IGNORED != before.keys() - IGNORED or any(
            dict.__getitem__(copy, k) is not before[k] for k in before if k not in IGNORED
        )
    if isinstance(copy, types.FunctionType) and type(before) is list:
        return any(a is not b for a, b in zip(facts(copy), before, strict=True))
    if isinstance(copy, types.CellType):
        return not _is_set(type(copy).cell_contents, copy) or copy.cell_contents is not before
    slots = slots_of(type(copy))
    if not isinstance(copy, type | types.FunctionType) and any(_is_set(s, copy) for s in slots):
        return True  # the copy has no slot set at first: reads of slots go to the original
    own = object.__getattribute__(copy, "__dict__")
    return bool(before.keys() - own.keys()) or any(
        before.get(name, copy) is not value for name, value in own.items()
    )


def facts(function):
    """The attributes that determine what a function does."""
    return [getattr(function, name) for name in OF_FUNCTIONS]


def _same(a, b):
    """Whether two values are equal, including the signs of zeros."""
    if a is b:
        return True
    if type(a) is not type(b) or not (type(a) in PLAIN or isinstance(a, np.generic)):
        return False
    return a == b and repr(a) == repr(b)  # repr shows the sign of a zero


def _is_set(slot, thing):
    try:
        slot.__get__(thing)
    except (AttributeError, ValueError):  # an unset slot, an empty cell
        return False
    return True
