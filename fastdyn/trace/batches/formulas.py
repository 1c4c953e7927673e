"""Functions of numbers on long arrays.

A function is run once on placeholder symbols ("arg").  Each node of its graph becomes a batch.
"""

from typing import Any

import numpy as np

from ...operations import OPERATIONS
from ..graph.expressions import live
from ..symbols.complex_pair import Pair, is_complex, parts
from ..symbols.conditions import Condition, kind_of_number
from ..symbols.layout import laid_out, like_a_ufunc
from ..symbols.real import Symbol
from ..symbols.symbolic import Symbolic, refuse
from .columns import Columns, ids_and_kind, ids_of, joint

DEEPEST = 64  # operations of a formula


def elementwise(table, function, values) -> Any:
    """``function(*numbers)`` for each element of the broadcast arrays in `values`.

    Refuses a function that branches on its numbers.
    """
    g = table.g
    arrays = {i: as_columns(table, v) for i, v in enumerate(values) if _is_array(v)}
    shape = np.broadcast_shapes(*[a.shape for a in arrays.values()])
    operands, given, places = [], list(values), {}

    def placeholder(a):
        operand = operand_of(a, shape)
        place = operand if isinstance(operand, int) else operand.tobytes(), a.truth
        if place not in places:
            node = g.make("arg", (), (len(operands), a.truth))
            places[place] = Condition(g, node) if a.truth else Symbol(g, node)
            operands.append(operand)
        return places[place]

    for i, a in arrays.items():
        both = list(map(placeholder, a.parts()))
        given[i] = both[0] if len(both) == 1 else Pair(*both)
    decided, before = len(g.taken), (g.raising, g.sizes)
    g.raising = g.sizes = g.false
    try:
        result = function(*given)
        raising, sizes = g.raising, g.sizes
    finally:
        g.raising, g.sizes = before
    if len(g.taken) != decided:
        refuse("a function of numbers that decides, on a long array")
    g.raising = g.both(before[0], _anywhere(table, raising, operands, shape), "or")
    g.sizes = g.both(before[1], _anywhere(table, sizes, operands, shape), "or")
    like = like_a_ufunc(list(arrays.values()))
    found = _instances(table, result, operands, shape)
    if isinstance(found, tuple):
        return tuple(laid_out(each, like) for each in found)
    return laid_out(found, like)


def _anywhere(table, node, operands, shape):
    """The condition that `node`, a condition on one element, holds for at least one element."""
    g = table.g
    if not any(each.op == "arg" for each in live([node])):
        return node
    chosen = Symbol(g, g.select(node, g.const(1.0), g.const(0.0)))
    ones = _instances(table, chosen, operands, shape)
    batch = table.make("top", ones.size, (), [ones.whole().number])
    return g.compare(table.symbol(batch.first).node, g.const(0.5), "gt")


def _instances(table, given: Any, operands, shape) -> Any:
    """Make a batch of each node of a formula; return the array of the formula's results."""
    if isinstance(given, tuple):
        return tuple(_instances(table, each, operands, shape) for each in given)
    if is_complex(given):
        return joint(*(_instances(table, each, operands, shape) for each in parts(given)))
    if not isinstance(given, Symbolic):
        return filled(table, shape, given)
    result: Any = given
    nodes = live([result.node])
    if len(nodes) > DEEPEST:
        refuse("a long formula of each element")
    found: dict = {}
    for node in nodes:
        if node.op == "arg":
            found[node.key] = operands[node.data[0]], None
        elif any(a.key in found for a in node.args):
            args = [
                found[a.key][0] if a.key in found else np.array(table.one(a), np.int32)
                for a in node.args
            ]
            batch = table.make(node.op, node.data, shape, args, OPERATIONS[node.op].truth)
            found[node.key] = batch.number, batch
    if result.node.key not in found:
        return filled(table, shape, result)
    operand, batch = found[result.node.key]
    ids: Any = operand
    if batch is None:  # the formula returns an operand unchanged
        batch = table.batches[operand] if isinstance(operand, int) else None
        if batch is None:
            ids = np.broadcast_to(ids.reshape(shape) if ids.ndim else ids, shape)
            return Columns(table, ids.copy(), kind=kind_of_number(result))
    return Columns(table, None, batch, kind=kind_of_number(result))


def filled(table, shape, value):
    """A long array filled with one number."""
    ids, kind = ids_and_kind(table, value)
    return Columns(table, np.full(shape, ids, ids.dtype), kind=kind)


def _is_array(value):
    return isinstance(value, np.ndarray | list | tuple) and np.ndim(value) > 0


def as_columns(table, value):
    if isinstance(value, Columns):
        return value
    ids, kind = ids_and_kind(table, value)
    return Columns(table, ids, kind=kind)


def as_complex(table, value):
    """Any array or number as an array of complex numbers."""
    array = as_columns(table, value)
    return array if array.kind == "c" else Columns(table, ids_of(table, array, "c"), kind="c")


def operand_of(array, shape):
    """Convert an array, not a complex one, to an operand of a batch with this shape.

    Later writes to the array do not change the operand.
    """
    if array.whole() is not None and array.shape == shape:
        return array.whole().number
    ids = array.ids
    if ids.size == 1:
        return np.array(ids.reshape(-1)[0])
    return np.ascontiguousarray(np.broadcast_to(ids, shape)).reshape(-1).copy()
