"""Finds what a function uses from outside: globals, closure variables, attributes of `self`.

Numba's own bytecode reader finds the names, so that no compiled name is missed.  Numba is imported
on first use.
"""

import builtins
import dis
import inspect
import types as python
from typing import NamedTuple

import numpy as np

from .. import memory

MISSING = object()
HEAP_TYPE = 1 << 9  # the flag of classes written in Python


class Reference(NamedTuple):
    """A root ("global", "free" or "self"), a name, and the attributes read one after the other."""

    root: str
    name: str
    attributes: tuple = ()


def track(blocks, n_definitions, owned):
    """Yield (block, position, statement, path) for each use of an outside name in Numba IR.

    `owned` tells whether the first argument is bound (`self`).  A path is a Reference.  Each
    attribute extends the path; every prefix of a path is yielded, too.
    """
    import numba  # noqa: F401  # waits for another thread's import; importing a submodule does not
    from numba.core import ir

    paths = {}
    for label in sorted(blocks):
        block = blocks[label]
        for i, statement in enumerate(block.body):
            if not isinstance(statement, ir.Assign):
                continue
            value, path = statement.value, None
            if isinstance(value, ir.Global):
                path = Reference("global", value.name)
            elif isinstance(value, ir.FreeVar):
                path = Reference("free", value.name)
            elif isinstance(value, ir.Arg) and owned and value.index == 0:
                path = Reference("self", value.name)
            elif isinstance(value, ir.Var):
                path = paths.get(value.name)
            elif isinstance(value, ir.Expr) and value.op == "getattr":
                before = paths.get(value.value.name)
                if before is not None:
                    path = before._replace(attributes=(*before.attributes, value.attr))
            if path is not None and n_definitions[statement.target.name] == 1:
                paths[statement.target.name] = path
                yield block, i, statement, path


def count_definitions(blocks):
    """The number of assignments to each variable."""
    import numba  # noqa: F401  # waits for another thread's import; importing a submodule does not
    from numba.core import ir

    counts = {}
    for block in blocks.values():
        for statement in block.find_insts(ir.Assign):
            counts[statement.target.name] = counts.get(statement.target.name, 0) + 1
    return counts


def _references(code, owned):
    import numba  # noqa: F401  # waits for another thread's import; importing a submodule does not
    from numba.core.compiler import run_frontend

    cells = tuple(python.CellType(None) for _ in code.co_freevars)
    names = {
        n: None for each in _all_codes(code) for n in each.co_names if not hasattr(builtins, n)
    }
    function = python.FunctionType(code, names, code.co_name, None, cells)
    blocks = run_frontend(function).blocks
    counts = count_definitions(blocks)
    found = {path for *_, path in track(blocks, counts, owned)}
    inner = [c for c in code.co_consts if isinstance(c, python.CodeType)]
    for nested in inner:
        found |= {r for r in _references(nested, False) if r.root == "global"}
    longest = {
        r
        for r in found
        if not any(
            o.root == r.root
            and o.name == r.name
            and len(o.attributes) > len(r.attributes)
            and o.attributes[: len(r.attributes)] == r.attributes
            for o in found
        )
    }
    return tuple(sorted(longest))


def _all_codes(code):
    """Yield the code of a function, and of the functions in it, at any depth."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, python.CodeType):
            yield from _all_codes(constant)


_known = memory.Table()


def references(function, owned):
    """The outside names that a Python function uses, as longest paths.

    Raises Numba's exceptions for bytecode that Numba cannot read.
    """
    code = function.__code__
    known = _known.get((id(code), owned))  # hashing the code itself would take a microsecond
    if known is None:
        known = _known.put((id(code), owned), (_references(code, owned), code))
    return known[0]


def walks_into(value):
    """Whether `resolve` looks up attributes of a value, because Numba cannot look them up."""
    if isinstance(value, python.ModuleType | type):
        return True
    plain = (str, bytes, int, float, complex, tuple, list, np.ndarray, np.generic, type(None))
    return not isinstance(value, plain) and not callable(value)


def resolve(reference, function, owner):
    """(current value of a path, number of attributes followed)."""
    if reference.root == "self":
        value = owner
    elif reference.root == "global":
        value = function.__globals__.get(reference.name, MISSING)
        if value is MISSING:
            value = getattr(builtins, reference.name, MISSING)
    else:
        index = function.__code__.co_freevars.index(reference.name)
        try:
            value = function.__closure__[index].cell_contents
        except ValueError:
            value = MISSING
    depth = 0
    for attribute in reference.attributes:
        if not (walks_into(value) or (reference.root == "self" and depth == 0)):
            break
        if _runs_code(value, attribute):
            break
        value = getattr(value, attribute, MISSING)
        depth += 1
    return value, depth


def _runs_code(value, name):
    """Whether looking up an attribute would run the user's code."""
    kind = type(value)
    if isinstance(value, python.ModuleType) or not kind.__flags__ & HEAP_TYPE:
        return False
    if not isinstance(kind.__getattribute__, python.WrapperDescriptorType):
        return True
    found = inspect.getattr_static(value, name, MISSING)
    if found is MISSING:
        return hasattr(kind, "__getattr__")
    of_python = python.FunctionType | staticmethod | classmethod
    return bool(
        not isinstance(found, of_python)
        and hasattr(type(found), "__get__")
        and (type(found).__flags__ & HEAP_TYPE or isinstance(found, property))
    )


def draws_random(value):
    """Whether a value is a random number generator, or one of its methods."""
    bound = isinstance(value, python.BuiltinFunctionType | python.MethodType)
    owner = value.__self__ if bound and value.__self__ is not None else value
    kind = owner if isinstance(owner, type | python.ModuleType) else type(owner)
    name = kind.__name__ if isinstance(kind, python.ModuleType) else kind.__module__
    return name == "random" or name.startswith("numpy.random")


STORES = ("STORE_GLOBAL", "DELETE_GLOBAL", "STORE_DEREF", "DELETE_DEREF")


def stored_outside(code):
    """A global or enclosing variable that a function assigns to; None if there is none."""
    for each in _all_codes(code):
        for instruction in dis.get_instructions(each):
            if instruction.opname in STORES:
                if instruction.opname.endswith("GLOBAL") or instruction.argval in code.co_freevars:
                    return instruction.argval
    return None
