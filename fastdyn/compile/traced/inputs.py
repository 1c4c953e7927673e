"""The inputs of a trace's machine code: the state, and the block of parameters."""

import itertools
import math

from llvmlite import ir

from fastdyn.kernels.calls.block import FIRST
from fastdyn.kernels.vector.instructions import splat
from fastdyn.trace.emit.numbers import INDEX, REAL, WORD, number_at

from ..parameters import n_words

OF_DTYPE = {"f8": REAL, "i8": WORD, "b1": ir.IntType(8)}


def places_of(kinds):
    """The places in a block of groups of parameters, and the end of the last group."""
    return list(itertools.accumulate(map(n_words, kinds), initial=FIRST))


def array_of(reads, kinds):
    """A function of a parameter's slot: returns (array of the parameter, place in the array).

    The array is ("array", slots) for an element of an array, and ("block", words) for a number.
    """
    *places, end = places_of(kinds)

    def of_slot(slot):
        i = reads.group(slot)
        group = reads.groups[i]
        if group.shape is None:
            return ("block", end), places[i]
        slots = range(group.first, group.first + math.prod(group.shape))
        return ("array", slots), slot - group.first

    return of_slot


class Source:
    """The inputs of the pointer form."""

    def __init__(self, builder, traced, t, y, block, kinds):
        self.builder = builder
        self.t = t
        self._y = y
        self._block = block
        self.reads = traced.trace.reads
        self.kinds = kinds
        *self.places, _ = places_of(kinds)

    def y(self, i):
        return self.builder.load(self.builder.gep(self._y, [INDEX(i)]))

    def parameter(self, slot):
        """The value of a parameter."""
        b = self.builder
        i = self.reads.group(slot)
        group = self.reads.groups[i]
        place = self._word(i)
        if group.shape is not None:
            return number_at(b, self.table(group.first), INDEX(slot - group.first))
        return b.load(b.bitcast(place, REAL.as_pointer()))

    def table(self, slot):
        """The address of a parameter in its array."""
        i = self.reads.group(slot)
        b = self.builder
        group = self.reads.groups[i]
        address = b.inttoptr(b.load(self._word(i)), OF_DTYPE[group.dtype].as_pointer())
        return address if slot == group.first else b.gep(address, [WORD(slot - group.first)])

    def array(self, name):
        """The address of an array of doubles: "y", or the "block" of parameters."""
        if name == "y":
            return self._y
        return self.builder.bitcast(self._block, REAL.as_pointer())

    def _word(self, i):
        return self.builder.gep(self._block, [INDEX(self.places[i])])


class VectorSource(Source):
    """The inputs of the form on vectors."""

    def y(self, i):
        return self.builder.extract_value(self._y, i)

    def parameter(self, slot):
        kind = self.kinds[self.reads.group(slot)]
        vector = self.t.type
        if kind[0] != "lanes":
            return splat(self.builder, super().parameter(slot), vector.count)
        place = self._word(self.reads.group(slot))
        value = self.builder.load(self.builder.bitcast(place, vector.as_pointer()))
        value.align = 8
        return value
