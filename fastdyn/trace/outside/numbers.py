"""The seam between values from outside and the numbers of a trace.

These functions, and no others of this folder, make the symbols that a traced function gets for the
slots of parameters.
"""

import numpy as np

from ..reads.program import real_numbers
from ..symbols.constants import Constants
from ..symbols.lift import symbol
from ..symbols.symbol import Symbol, refuse

MOST = 4_000_000  # limit of an array's length
SMALL = 16  # a longer list of floats is one array of parameters


def number(graph, slot, value):
    """The symbol of a parameter that is now a float, a whole number, or a truth value."""
    kind = "f" if isinstance(value, float | np.floating) else "i"
    node = graph.make("par", (), slot)
    if type(value) is bool:
        return symbol(graph, Symbol(graph, node.key, "i", True) != 0)
    return Symbol(graph, node.key, kind, type(value) in (int, float))


def items(graph, slots, like):
    """The symbols of consecutive slots, as numbers of the type of the number `like`."""
    kind = "f" if isinstance(like, float) else "i"
    python = type(like) in (int, float)
    ids = graph.array(slots, np.empty(len(slots))).tolist()
    return [Symbol(graph, i, kind, python) for i in ids]


def complex_number(outside, value, row):
    """The symbol of a complex number."""
    g = outside.graph
    reads = outside.reads
    slots = reads.parameters(reads.step(row, "real numbers"), real_numbers(np.array([value])))
    pair = tuple(graph_id.key for graph_id in [g.make("par", (), slot) for slot in slots])
    return Symbol(g, pair, "c", type(value) is complex)


def array(outside, value, row):
    """The array that a traced function gets: parameters if possible, else constants of the code."""
    g = outside.graph
    reads = outside.reads
    if value.dtype.kind not in "fiubc":
        refuse(f"an array of {value.dtype}")
    if value.size > MOST:
        refuse(f"an array of {value.size} numbers", final=True, said=False)
    if value.dtype in (float, complex) and not outside.fixed(row) and value.size:
        if value.dtype == float:
            return Symbol(g, g.array(reads.parameters(row, value), value))
        strides = value.strides if value.ndim > 1 else None
        reads.expect(row, "array", (value.dtype, value.shape, strides))
        slots = reads.parameters(reads.step(row, "real numbers"), real_numbers(value))
        return Symbol(g, g.array(slots, value), "c")
    reads.expect_elements(row, value)
    if value.dtype in (float, complex):
        return symbol(g, value)
    return value.copy("K").view(Constants)
