"""The steps by which a later call reaches the objects that a traced function reads."""

import builtins
from typing import Any

import numpy as np

from ..written import function_of
from . import table_reads
from .checks import MISSING

# Steps that one expression says; `compile.traced.reader` writes the expressions out.
WRITTEN = {
    "default": "{parent}.__defaults__[{key}]",
    "keyword default": "{parent}.__kwdefaults__[{key}]",
    "function": "{parent}.__func__",
    "self": "{parent}.__self__",
    "argument": "{parent}.args[{key}]",
    "keyword": "{parent}.keywords[{key}]",
    "item": "{parent}[{key}]",
    "class": "type({parent})",
}
STEPS: dict[str, Any] = {
    name: function_of(
        f"def step(parent, key): return {text.format(parent='parent', key='key')}", "step", name, {}
    )
    for name, text in WRITTEN.items()
} | {
    "global": lambda function, name: function.__globals__.get(name, MISSING),
    "builtin": lambda function, name: vars(builtins).get(name, MISSING),
    "cell": lambda function, i: _content(function.__closure__[i]),
    "inside": lambda wrapper, name: getattr(wrapper, name),  # py_func, fget
    "member": lambda thing, name: getattr(thing, name, MISSING),
    "dict item": lambda thing, key: dict.__getitem__(thing, key),
    "own": lambda thing, name: getattr(thing, "__dict__", {}).get(name, MISSING),
    "base": lambda cls, i: cls.__mro__[i],
    "real numbers": lambda value, _: real_numbers(value),
    "real parts": lambda value, _: real_parts(value),
    "remembered": lambda cached, given: remembered(cached, *given),
    "island": lambda _, island: island.address,
    **table_reads.STEPS,
    # of a pandas table
    "labels": lambda table, which: labels_of(table, which),
    "numbers of": lambda table, _: table.to_numpy(),
    "column": lambda table, name: table[name],
    "line": lambda table, label: table.loc[label],
    "place": lambda table, i: table.iloc[i],
}


def _content(cell):
    try:
        return cell.cell_contents
    except ValueError:  # the variable is not assigned yet
        return MISSING


def labels_of(table, which):
    """The labels of a pandas table, in a form that is cheap to compare."""
    labels = getattr(table, which)
    if hasattr(labels, "start"):  # a range
        return labels.start, labels.stop, labels.step
    return tuple(labels)


def real_numbers(value):
    """Alternating real and imaginary parts of complex numbers; a view of the array if possible."""
    return np.ascontiguousarray(value, dtype=complex).reshape(-1).view(float)


def real_parts(value):
    """The real parts of complex numbers, as a flat array."""
    return np.ascontiguousarray(value.real).reshape(-1)


def remembered(cached, args, named):
    """The value that a function of ``functools.lru_cache`` holds; KeyError if there is none."""
    before = cached.cache_info()
    if not before.currsize:  # a call would be the first to fill the cache
        raise KeyError(args)
    try:
        found = cached(*args, **dict(named))
    except Exception as error:
        raise KeyError(args) from error
    if cached.cache_info().misses != before.misses:
        raise KeyError(args)
    return found
