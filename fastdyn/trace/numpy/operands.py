"""Tables in the arguments of NumPy's functions, without a symbol for each number."""

from typing import Any, NamedTuple

import numpy as np

from ..symbols.arrays import Array
from ..symbols.lazy import complete
from ..symbols.real import Symbol
from ..symbols.symbolic import Lazy, refuse
from ..symbols.symbolic_indices import table_of


class Operand(NamedTuple):
    """A table: name in the graph, current numbers, and ``at(i)``, which gives element i."""

    name: str
    known: np.ndarray
    at: Any


def operand(g, value):
    """Convert a one-dimensional array to an Operand; refuse elements that depend on the state."""
    found: Any = value.table() if isinstance(value, Lazy) else None  # pyright: ignore
    if found:
        return Operand(*found, lambda i: value[i])  # pyright: ignore
    value = complete(value)
    array = value if isinstance(value, np.ndarray) else np.array(value, dtype=object)
    if array.ndim != 1:
        refuse("a table of more than one dimension")
    if array.dtype != object:
        known = np.asarray(array, dtype=float)
        return Operand(table_of(g, known), known, lambda i: float(known[i]))
    array = Array.of(array)
    symbols = [v for v in array if isinstance(v, Symbol)]
    if any(s.node.varies for s in symbols):
        refuse("a table that depends on the state")
    known = np.array([v.node.value if isinstance(v, Symbol) else v for v in array], float)
    name = g.table(array) if symbols else table_of(g, known)
    return Operand(name, known, lambda i: array[i])


def ascending(g, table):
    """Whether the numbers of an Operand never decrease; later solves check parameters again."""
    known = g.kept.get(("ascending", table.name))
    if known is None:
        known = bool(np.all(table.known[1:] >= table.known[:-1]))
        g.kept["ascending", table.name] = known
    slots = g.tables[table.name]
    if known and isinstance(slots, range):
        reads = g.reads
        group = reads.groups[reads.group(slots.start)]
        if reads.rows[group.row].step != "known":
            part = slots.start - group.first, slots.stop - group.first, slots.step
            reads.expect(reads.step(group.row, "entries", part), "ascending")
    return known


def numbers(value):
    """The current numbers of an array, as constants of the code."""
    return np.array([float(v) for v in np.ravel(complete(value))], float)
