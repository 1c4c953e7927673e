"""Refuses functions with values that Numba cannot type, before Numba is imported."""

import builtins
import dis
import sys
import types as python
from typing import Any, NamedTuple

import numpy as np

from fastdyn.trace.graph.user_lines import of_user
from fastdyn.trace.outside.identities import compared_by_identity
from fastdyn.trace.outside.kinds import has_functions

from .. import memory
from .captured import HEAP_TYPE, MISSING
from .diagnostics import EMPTY, Uncompilable, located
from .parts import T, Y

KNOWN = (  # types that Numba supports, or whose values are inspected
    int, float, complex, str, bytes, type(None), type(Ellipsis), slice, range, type,
    python.ModuleType, np.ndarray, np.generic, np.dtype,
)  # fmt: skip
DATA = int, float, complex, str, bytes, list, tuple, np.ndarray
DEEPEST = 3  # depth of functions that call functions


class Chain(NamedTuple):
    """A name, the attributes read from the named object, and the source line.

    `root` is "global", "free" (a closure variable) or "first" (the first argument, `self`).
    """

    root: str
    name: str
    attributes: tuple
    line: int | None


@memory.cached
def chains(code):
    """The Chains of a code object, and the "global" Chains of the functions nested in it."""
    found: list[Any] = []
    line, before = code.co_firstlineno, False
    first = code.co_varnames[0] if code.co_argcount else None
    for step in dis.get_instructions(code):
        line = step.starts_line if type(step.starts_line) is int else line
        if step.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
            found.append(Chain("global", step.argval, (), line))
        elif step.opname in ("LOAD_DEREF", "LOAD_CLASSDEREF"):
            found.append(Chain("free", step.argval, (), line))
        elif step.opname in ("LOAD_FAST", "LOAD_FAST_BORROW") and step.argval == first:
            found.append(Chain("first", step.argval, (), line))
        elif step.opname in ("LOAD_ATTR", "LOAD_METHOD") and before:
            chain = found[-1]
            found[-1] = chain._replace(attributes=(*chain.attributes, step.argval))
        else:
            before = before and step.opname in ("CACHE", "EXTENDED_ARG")
            continue
        before = True
    for inner in code.co_consts:
        if isinstance(inner, python.CodeType):
            found += [c for c in chains(inner) if c.root == "global"]
    return tuple(found)


def refuse_at_sight(parts):
    """Raise Uncompilable, with name and line, for a value that compiled code cannot hold."""
    for value in parts.positional:
        if value is not T and value is not Y and _never(value):
            raise Uncompilable(
                f"an argument is of type {type(value).__name__}, which compiled code cannot "
                "hold: pass its numbers as `args`"
            )
    _look(parts.function, parts.owner, DEEPEST)


def _look(function, owner, depth):
    code = function.__code__
    if any(each is not None for each in compared_by_identity(code)):
        raise Uncompilable("it compares identities with `is`, and compiled code has values only")
    for chain in chains(code):
        value, taken = _value(chain, function, owner)
        if isinstance(value, python.FunctionType):
            if depth and of_user(value.__code__.co_filename):
                _look(value, None, depth - 1)
        elif value is not MISSING and _never(value):
            name = ".".join((chain.name, *chain.attributes[:taken]))
            raise Uncompilable(
                located(
                    f"it uses `{name}`, of type {type(value).__name__}, which compiled code "
                    "cannot hold: pass its numbers as `args`",
                    (code.co_filename, chain.line),
                )
            )


def _value(chain, function, owner):
    """(value of a chain, number of attributes followed).

    An attribute whose look-up would run the user's code is not followed.
    """
    if chain.root == "global":
        value = function.__globals__.get(chain.name, vars(builtins).get(chain.name, MISSING))
    elif chain.root == "free":
        cells = dict(zip(function.__code__.co_freevars, function.__closure__ or (), strict=False))
        cell = cells.get(chain.name, EMPTY)
        value = MISSING if cell == EMPTY else cell.cell_contents
    else:
        value = MISSING if owner is None or not chain.attributes else owner
    for i, attribute in enumerate(chain.attributes):
        own = getattr(value, "__dict__", None) if value is not MISSING else None
        if isinstance(value, dict | set) or own is None:
            return value, i
        if attribute not in own:
            return MISSING, i
        value = own[attribute]
    return value, len(chain.attributes)


def _never(value):
    """True if Numba has no type for a value; False for values that are inspected or called.

    If a user's class derives from a number or a sequence, Numba would treat an instance as that
    number or sequence, and ignore the methods of the class.
    """
    if isinstance(value, DATA) and any(map(has_functions, type(value).__mro__)):
        return True
    if isinstance(value, KNOWN) or callable(value):
        return False
    if isinstance(value, list | tuple):
        return any(map(_never, value[:1])) and _untyped(value)
    if isinstance(value, dict | set):
        return True
    written_in_python = type(value).__flags__ & HEAP_TYPE
    return bool(written_in_python) and _untyped(value)


def _untyped(value):
    if hasattr(type(value), "_numba_type_"):  # an instance of a class that Numba has compiled
        return False
    # With __getattr__, Numba's look-ups of attributes would run the user's code.
    asked = any("__getattr__" in vars(kind) for kind in type(value).__mro__)
    if "numba" not in sys.modules or asked:
        return True
    from numba import typeof

    try:
        typeof(value)
    except Exception:
        return True
    return False
