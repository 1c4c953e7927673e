"""Copies of long arrays and lists, shared by all runs that do not write to them."""

import numpy as np

from ..numpy.constants import Constants
from ..numpy.tables import Elements, Table
from ..reads.table_reads import Nature, held
from ..symbols.symbolic import refuse
from .table_lists import Items, LongList, LongTuple

MOST = 4_000_000  # limit of an array's length
SMALL = 16  # arrays and lists up to this length become symbols


def _check(count):
    if count > MOST:
        refuse(f"an array of {count} numbers", final=True, said=False)


def _shared(g, value, make):
    """The copy of an earlier run, reset; a new copy if there is none, or a run may have written."""
    key = "copy", id(value)
    copy, anew = g.kept.get(key) or (None, None)
    copy = copy is not None and copy.reset()
    if copy is None or copy is False:
        anew = anew or make()
        copy = anew()
        g.kept[key] = copy, anew
    return copy


def _noting(reads, row, content):
    """A function ``constants()`` that makes the content of a row a constant of the code."""

    def constants():
        if reads.root_of(row) in reads.varying:
            refuse("a long array that varies")
        reads.expect(reads.step(row, "itself"), "content", content)

    return constants


def long_array(g, value, row):
    """A copy of an array of floats whose elements compiled code loads from memory."""
    _check(value.size)

    def make():
        slots, content = g.reads.parameters(row, value), value.copy(order="C")
        noting = _noting(g.reads, row, content)
        return lambda: Table.made(Elements(g, slots, content, noting), value)

    return _shared(g, value, make)


def constant_array(g, value, row):
    """A copy of an array whose content is a constant of the code."""
    _check(value.size)

    def make():
        content = value.copy(order="K")
        g.reads.expect(row, "content", content)
        if value.dtype != float:
            return lambda: Constants.made(content)
        slots, content = held(g.reads, content), np.ascontiguousarray(content)
        return lambda: Table.made(Elements(g, slots, content, None), value)

    return _shared(g, value, make)


def long_list(g, value, row, whole=True):
    """A copy of a list or tuple of numbers; None for a short one, or for other items.

    `whole` tells whether whole numbers may be parameters.
    """
    if not value or (len(value) <= SMALL and not isinstance(value[0], list | tuple)):
        return None
    reads = g.reads

    def make():
        nature = Nature.of(value)
        if nature is None or nature.size <= SMALL:
            return None
        content = nature.numbers(value)
        reads.expect(row, "type", type(value))
        at = reads.step(row, "numbers", nature)
        noting = _noting(reads, at, content)
        items = g, reads.parameters(at, content), content, nature, noting, whole
        kind = LongList if type(value) is list else LongTuple
        return lambda: kind.made(Items(*items))

    if ("short", id(value)) in g.kept:
        return None
    if ("copy", id(value)) not in g.kept:
        again = make()
        if again is None:
            g.kept["short", id(value)] = True
            return None
        return _shared(g, value, lambda: again)
    return _shared(g, value, None)
