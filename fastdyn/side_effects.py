"""Functions of one solve that change what others use: a flag that an event sets for `fun`.

Compiled code reads outside values when a solve begins.  Where a function that runs in Python
assigns to such a value, the functions that use it have to run in Python, too.
"""

import dis
import types as python

from .parts import parts_of
from .references import of_library, references, resolve
from .refusal import Uncompilable

CHANGED = "another function of the solve may change what it uses"
STORES = {"STORE_GLOBAL", "DELETE_GLOBAL", "STORE_DEREF", "DELETE_DEREF", "STORE_ATTR"}


def stored_by(fun):
    """What a callable may change: places (of globals and cells) and names of attributes."""
    places = set()
    for function, _ in _reached(fun):
        for code in _codes(function.__code__):
            for instruction in dis.get_instructions(code):
                if instruction.opname == "STORE_ATTR":
                    places.add(instruction.argval)
                elif instruction.opname in STORES:
                    places.add(_place(function, instruction.argval))
    return places


def used_by(fun):
    """Places and names of attributes that a callable reads, and whether a list is among them."""
    places, lists = set(), False
    for function, owner in _reached(fun):
        for reference in references(function, owner is not None):
            lists = lists or isinstance(resolve(reference, function, owner)[0], list)
            places.update(reference.attributes)
            if reference.root != "self":
                places.add(_place(function, reference.name))
    return places, lists


def depends(fun, others):
    """Whether a function uses what others, which run in Python, may change."""
    try:
        places, lists = used_by(fun)
    except Exception:  # it cannot be read, and so is not compiled
        return False
    return lists or any(places & stored_by(other) for other in others)


def _place(function, name):
    """A hashable thing that stands for the variable of this name in a function."""
    code = function.__code__
    if name in code.co_freevars:
        return id(function.__closure__[code.co_freevars.index(name)])
    return id(function.__globals__), name


def _codes(code):
    yield code
    for constant in code.co_consts:
        if isinstance(constant, python.CodeType):
            yield from _codes(constant)


def _reached(fun):
    """(function, owner) of the Python functions behind a callable: itself and all it calls."""
    found, todo = [], [fun]
    while todo:
        one = todo.pop()
        try:
            function, owner = parts_of(one, ())[:2]
        except (Uncompilable, TypeError, ValueError):
            continue
        if of_library(function) or any(function is known for known, _ in found):
            continue
        found.append((function, owner))
        try:
            outside = references(function, owner is not None)
        except Exception:
            continue
        values = (resolve(reference, function, owner)[0] for reference in outside)
        todo += [v for v in values if isinstance(v, python.FunctionType | python.MethodType)]
    return found
