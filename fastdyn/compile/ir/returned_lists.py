"""Returned lists become tuples, which live in registers."""

import numpy as np
from numba.core import ir

from .definitions import made_once, outside_value


def return_tuples(blocks):
    """Turn each returned list display into a tuple, and drop np.array around one."""
    made, uses = made_once(blocks), {}
    for block in blocks.values():
        for statement in block.body:
            for v in statement.list_vars():
                uses[v.name] = uses.get(v.name, 0) + 1
    for block in blocks.values():
        if isinstance(block.terminator, ir.Return):
            _tuple_behind(block.terminator.value.name, made, uses)


def _tuple_behind(name, made, uses):
    # Each variable of the chain is named once where it is made and once where it is used.
    statement = made.get(name)
    if statement is None or uses.get(name, 0) > 2:
        return
    value = statement.value
    if isinstance(value, ir.Var):
        _tuple_behind(value.name, made, uses)
    elif isinstance(value, ir.Expr) and value.op == "cast":
        _tuple_behind(value.value.name, made, uses)
    elif isinstance(value, ir.Expr) and value.op == "build_list":
        statement.value = ir.Expr.build_tuple(value.items, value.loc)
    elif isinstance(value, ir.Expr) and value.op == "call" and len(value.args) == 1:
        function = outside_value(value.func.name, made)
        plain = all(k == "dtype" and _is_float(v.name, made) for k, v in value.kws)
        inner = made.get(value.args[0].name)
        if function in (np.array, np.asarray) and plain and inner is not None:
            items = getattr(inner.value, "items", None)
            displayed = getattr(inner.value, "op", "") in ("build_list", "build_tuple")
            # list_vars names the argument twice: in args and, as Numba keeps it, in kws or func
            if displayed and items is not None and uses[value.args[0].name] <= 3:
                statement.value = ir.Expr.build_tuple(items, value.loc)


def _is_float(name, made):
    return outside_value(name, made) in (float, np.float64)
