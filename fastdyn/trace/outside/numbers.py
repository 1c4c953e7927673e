"""The seam between values from outside and the numbers of a trace.

These functions, and no others of this folder, make the symbols that a traced function gets for the
slots of parameters.
"""

import numpy as np

from ..graph.kinds import FLOAT, INT, NUMPY
from ..numpy.constants import Constants
from ..numpy.tables import Elements, Table
from ..reads.program import real_numbers
from ..reads.reads import MAX_ARRAY
from ..symbols.arrays import Array
from ..symbols.complex_pair import Pair
from ..symbols.real import Symbol
from ..symbols.symbolic import refuse

FEW = 16  # up to so many complex numbers may be real now and complex in a later call
MOST = 4_000_000  # limit of an array's length
SMALL = 16  # arrays and lists up to this length become symbols at once


def number(graph, slot, value):
    """The symbol of a parameter that is now a float or a whole number."""
    whole = not isinstance(value, float | np.floating)
    kind = INT if whole else FLOAT if type(value) is float else NUMPY
    return Symbol(graph, graph.make("par", (), slot), kind)


def items(graph, slots, like):
    """The symbols of consecutive slots, as numbers of the type of the number `like`."""
    return [number(graph, slot, like) for slot in slots]


def complex_numbers(outside, value, row, real=False):
    """The complex numbers of an array; if `real`, later calls check that imaginary parts are 0."""
    g, reads = outside.graph, outside.reads
    if real:
        reads.expect(reads.step(row, "itself"), "real values")
        parts = np.ascontiguousarray(value.real).reshape(-1)
        slots = reads.parameters(reads.step(row, "real parts"), parts)
        return [Pair(one, 0.0) for one in items(g, slots, np.float64())]
    slots = reads.parameters(reads.step(row, "real numbers"), real_numbers(value))
    found = items(g, slots, np.float64())
    return [Pair(*pair) for pair in zip(found[::2], found[1::2], strict=True)]


def array(outside, value, row):
    """The array that a traced function gets: parameters if possible, else constants of the code."""
    g, reads, fixed = outside.graph, outside.reads, outside.fixed(row)
    if value.dtype.kind not in "fiubc":
        refuse(f"an array of {value.dtype}")
    if value.size > MOST:
        refuse(f"an array of {value.size} numbers", final=True, said=False)
    if value.dtype == complex and not fixed and 2 * value.size <= MAX_ARRAY:
        strides = value.strides if value.ndim > 1 else None
        reads.expect(row, "array", (value.dtype, value.shape, strides))
        real = value.size > FEW and not value.imag.any()  # saves half of the products
        copy = np.empty_like(value, dtype=object)
        copy.flat[:] = complex_numbers(outside, value, row, real)
        return copy.view(Array)
    if value.dtype == complex or (value.dtype == float and fixed and value.size <= MAX_ARRAY):
        reads.expect(row, "content", value.copy())
        return Array.of(value)
    if value.dtype == float and not fixed and value.size <= SMALL:
        copy = np.empty_like(value, dtype=object)
        for i, one in enumerate(items(g, reads.parameters(row, value), np.float64())):
            copy.flat[i] = one
        return copy.view(Array)
    return _shared(g, value, lambda: _long(outside, value, row))


def _shared(g, value, make):
    """The copy of an earlier run, reset; a new copy if there is none, or a run may have written."""
    copy, anew, _ = g.kept.get(("copy", id(value))) or (None, None, None)
    copy = copy is not None and copy.reset()
    if copy is None or copy is False:
        anew = anew or make()
        copy = anew()
        g.kept["copy", id(value)] = copy, anew, value  # alive, so that its id stays unique
    return copy


def _long(outside, value, row):
    """A function that makes copies of a long array, with elements that become symbols on use."""
    g, reads = outside.graph, outside.reads
    content = value.copy(order="K")

    def constants():
        if reads.varies(row):
            refuse("a long array that varies")
        reads.expect(reads.step(row, "itself"), "content", content)

    if value.dtype == float and not outside.fixed(row):
        slots, flat = reads.parameters(row, value), np.ascontiguousarray(content)
        return lambda: Table.made(Elements(g, slots, flat, constants), value)
    reads.expect(row, "content", content)
    if value.dtype != float:
        return lambda: Constants.made(content)
    slots, flat = reads.held(content), np.ascontiguousarray(content)
    return lambda: Table.made(Elements(g, slots, flat, None), value)
