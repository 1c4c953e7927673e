"""Replaces outside values by constants in Numba's IR, and outside functions by compiled ones."""

from types import ModuleType

import numpy as np
from numba.core import ir

from ...callables.captured import MISSING, count_definitions, resolve, track, walks_into
from ...callables.diagnostics import Uncompilable

LARGEST = 10**6  # bytes of an array that may become a constant of the code
JOIN = (np.concatenate, np.hstack, np.vstack, np.stack, np.column_stack, np.dstack)


def replace_outside(blocks, function, owner, called_function):
    """Replace attributes by constants, lists by tuples, and functions by compiled functions.

    ``called_function(value)`` gives the compiled function, or None if the value is no function.
    """
    uses = list(track(blocks, count_definitions(blocks), owner is not None))
    read_from = {p._replace(attributes=p.attributes[:-1]) for *_, p in uses if p.attributes}
    for _, _, statement, path in uses:
        if path.root == "self" and not path.attributes:
            continue
        value, depth = resolve(path, function, owner)
        if depth < len(path.attributes) or value is MISSING:
            continue
        compiled = called_function(value)
        if compiled is not None:
            value = compiled
        elif walks_into(value) and not isinstance(value, ModuleType) and path in read_from:
            value = None  # only attributes are read, and these become constants
        elif _numbers(value) and _only_read(blocks, statement.target.name):
            value = tuple(value)
        elif isinstance(value, np.ndarray):
            value = _constant(value, path)
        elif not path.attributes or isinstance(value, ModuleType) or callable(value):
            continue
        statement.value = ir.Global(_named(path), value, statement.loc)


def _named(path):
    return ".".join((path.name, *path.attributes))


def _constant(array, path):
    """A contiguous array of at most LARGEST bytes, as a constant.

    Numba would put only the address of a larger array into the code.
    """
    if array.nbytes > LARGEST:
        size = f"{array.nbytes} bytes, which are too many for code"
        raise Uncompilable(f"it uses `{_named(path)}`, an array of {size}: pass it as `args`")
    return np.ascontiguousarray(array) if array.ndim else array


def _numbers(value):
    return isinstance(value, list) and {type(v) for v in value} in ({float}, {int})


def _only_read(blocks, name):
    """True if the code only takes the elements of a list, or its length."""
    made = _made_once(blocks)
    for block in blocks.values():
        for statement in block.body:
            used = name in [v.name for v in statement.list_vars()]
            if not used or isinstance(statement, ir.Del) or statement is made.get(name):
                continue
            value = getattr(statement, "value", None)
            op = getattr(value, "op", None)
            element = op in ("getitem", "static_getitem", "getiter") and value.value.name == name
            whole = op == "static_getitem" and isinstance(value.index, slice)
            length = op == "call" and _outside_value(value.func.name, made) is len
            if whole or not (element or length):
                return False
    return True


def join_tuples(blocks):
    """Replace a list display by a tuple in calls such as ``np.concatenate([a, b])``.

    All elements of a Numba list have one type; the arrays may have several types.
    """
    made, uses = _made_once(blocks), {}
    for block in blocks.values():
        for statement in block.body:
            for v in statement.list_vars():
                uses[v.name] = uses.get(v.name, 0) + 1
    for statement in list(made.values()):
        value = statement.value
        if isinstance(value, ir.Expr) and value.op == "call" and len(value.args) >= 1:
            inner = made.get(value.args[0].name)
            if _outside_value(value.func.name, made) in JOIN and inner is not None:
                listed = isinstance(inner.value, ir.Expr) and inner.value.op == "build_list"
                if listed and uses[value.args[0].name] <= 3:  # no use but this call
                    inner.value = ir.Expr.build_tuple(inner.value.items, inner.value.loc)


def _made_once(blocks):
    """{name: statement} of the variables that are assigned once."""
    counts = count_definitions(blocks)
    return {
        statement.target.name: statement
        for block in blocks.values()
        for statement in block.find_insts(ir.Assign)
        if counts[statement.target.name] == 1
    }


def _outside_value(name, made):
    statement = made.get(name)
    value = statement.value if statement else None
    if isinstance(value, ir.Global | ir.FreeVar):
        return value.value
    if isinstance(value, ir.Expr) and value.op == "getattr":
        return getattr(_outside_value(value.value.name, made), value.attr, None)
    return None
