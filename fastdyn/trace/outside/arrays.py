"""Copies of arrays."""

import numpy as np

from ..reads.checks import laid
from ..reads.reads import MAX_ARRAY
from ..symbols.arrays import Array
from ..symbols.real import Symbol
from ..symbols.symbolic import refuse
from .shared_copies import SMALL, constant_array, long_array

FEW = 16  # up to so many complex numbers may be real now and complex in a later call


def array_copy(outside, value, row):
    """Copy an array; its numbers become parameters, or constants of the code."""
    reads = outside.reads
    if value.dtype == float and not outside.fixed(row):
        if value.size > SMALL:
            return outside.watch(value, long_array(outside.graph, value, row))
        g, copy = outside.graph, np.empty_like(value, dtype=object)
        for i, slot in enumerate(reads.parameters(row, value)):
            copy.flat[i] = Symbol(g, g.make("par", (), slot))
    elif value.dtype == complex and not outside.fixed(row) and 2 * value.size <= MAX_ARRAY:
        real = value.size > FEW and not value.imag.any()  # saves half of the products
        reads.expect(row, "real values" if real else "complex array", laid(value))
        copy = np.empty_like(value, dtype=object)
        copy.flat[:] = outside.pairs_of(value, row, real)
    elif value.dtype.kind not in "fiubc":
        refuse(f"an array of {value.dtype}")
    elif value.dtype not in (float, complex) or (value.dtype == float and value.size > MAX_ARRAY):
        return outside.watch(value, constant_array(outside.graph, value, row))
    else:
        reads.expect(row, "content", value.copy())
        copy = Array.of(value)
    return outside.watch(value, copy.view(Array))
