"""Writes the reads of a trace as rows of words, by which C follows the function.

If C cannot follow one of the reads, the function has no rows, and Python follows the function.
"""

import builtins
import math
from typing import NamedTuple

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.compile.parameters import n_words
from fastdyn.compile.traced import met
from fastdyn.compile.traced.follow import NO_ATTRIBUTES
from fastdyn.kernels.calls.block import FIRST

from . import words as c

NUMBERS = {float: c.FLOAT, np.float64: c.FLOAT, int: c.WHOLE, bool: c.WHOLE}
STEPS = {"global": c.GLOBAL, "builtin": c.BUILTIN, "cell": c.CELL, "default": c.DEFAULT}
ITEMS = {tuple: (c.IN_TUPLE, c.TUPLE), list: (c.IN_LIST, c.LIST)}


class Rows(NamedTuple):
    """The rows as words, and the number of rows.

    `arrays` has the offsets, in bytes, of arrays among the objects that C finds.  `held` keeps the
    objects alive that the words point to.
    """

    words: list
    n_rows: int
    arrays: list
    held: tuple


class _NotInC(Exception):
    """Raised for a read that C cannot follow."""


def rows_of(bound, fun, args):
    """The Rows of a bound function with its present trace; None if C cannot follow the function."""
    function = bound.function
    if function is None or function.traced is None or not bound.mode.compared:
        return None
    batches = met.in_batches(function)
    known = met.known_trace(fun, args, bound.mode, bound.n, batches=batches)
    if known is None or known[0].function is not function:
        return None
    try:
        return _Writer(known[0], bound, len(args)).rows()
    except _NotInC:
        return None


class _Writer:
    """Writes the rows of one trace."""

    def __init__(self, known, bound, n_args):
        self._reads = reads = known.traced.trace.reads
        self._zeros = set(known.zeros.tolist())
        if reads.identities or reads.assumed or not reads.lasting:
            raise _NotInC
        self._needed = [i for i in known.follow.needed() if reads.rows[i].step != "held"]
        self._place = {row: 1 + n_args + j for j, row in enumerate(self._needed)}
        self._same = {max(pair): self._place[min(pair)] for pair in reads.aliases}
        if len(self._same) < len(reads.aliases):
            raise _NotInC
        at, address = FIRST, address_of(bound.block)
        self._groups = {}
        for group, kind in zip(reads.groups, known.traced.kinds, strict=True):
            self._groups[group.row] = group, address + 8 * at
            at += n_words(kind)
        self._held, self._words, self._arrays = [], [], []

    def rows(self):
        for i in self._needed:
            self._words += self._row(i)
        return Rows(self._words, len(self._needed), self._arrays, tuple(self._held))

    def _address(self, thing):
        self._held.append(thing)
        return id(thing)

    def _address_of(self, words):
        self._held.append(words)
        return address_of(words)

    def _row(self, i):
        row, fields = self._reads.rows[i], dict.fromkeys(c.FIELDS, 0)
        self._step(row, fields)
        self._check(i, row, fields)
        fields["same"] = self._same.get(i, 0)
        return fields.values()

    def _step(self, row, fields):
        """Fill the fields of the step to a row."""
        if row.parent < 0:
            if row.step != "root":
                raise _NotInC
            fields["parent"], fields["step"] = row.key, c.ITSELF
            return
        parent = self._reads.rows[row.parent]
        fields["parent"] = self._place[row.parent]
        if row[1:] == NO_ATTRIBUTES and parent.check == "code":
            fields["step"] = c.OWN
        elif row.step in STEPS and parent.check == "code":
            fields["step"], key = STEPS[row.step], row.key
            if row.step == "default" and not 0 <= key < parent.expected[2]:
                raise _NotInC
            if row.step == "builtin":
                fields["scope"] = id(vars(builtins))
            fields["key"] = self._address(key) if isinstance(key, str) else key
        elif row.step == "item" and parent.check == "keys" and type(row.key) is str:
            fields["step"], fields["key"] = c.IN_DICT, self._address(row.key)
        elif row.step == "item" and parent.check == "length" and parent.expected[0] in ITEMS:
            if type(row.key) is not int or not 0 <= row.key < parent.expected[1]:
                raise _NotInC
            fields["step"], fields["key"] = ITEMS[parent.expected[0]][0], row.key
        else:
            raise _NotInC

    def _check(self, i, row, fields):
        """Fill the fields of the check of a row, and of the numbers that the row holds."""
        check, expected = row.check, row.expected
        group, place = self._groups.get(i, (None, 0))
        if group is not None and check not in ("number", "array"):
            raise _NotInC
        if check is None:
            fields["check"] = c.ANY
        elif row[1:] == NO_ATTRIBUTES:
            fields["check"] = c.EMPTY
        elif check == "same":
            fields["check"], fields["expected"] = c.SAME, self._address(expected)
        elif check == "absent" and row.step in ("global", "builtin"):
            fields["check"] = c.ABSENT
        elif check == "code" and not expected[3]:
            code, scope, fields["count"], _ = expected
            fields["check"], fields["expected"] = c.CODE, self._address(code)
            fields["scope"] = self._address(scope)
        elif check == "length" and expected[0] in ITEMS:
            fields["check"], fields["count"] = ITEMS[expected[0]][1], expected[1]
        elif check == "keys" and expected[0] is dict and {*map(type, expected[1])} <= {str}:
            self._held.append(expected[1])
            names = np.array([*map(id, expected[1])], np.int64)
            fields["check"], fields["count"] = c.KEYS, len(names)
            fields["scope"] = self._address_of(names)
        elif check == "number" and expected in NUMBERS:
            self._number(group, place, expected, fields)
        elif check == "array":
            self._array(group, place, fields)
        else:
            raise _NotInC

    def _number(self, group, place, kind, fields):
        fields["check"], fields["expected"], fields["place"] = NUMBERS[kind], id(kind), place
        if group is None:
            return
        if group.whole != (NUMBERS[kind] == c.WHOLE):
            raise _NotInC
        for _, value in self._fixed(group.first, 1):
            fields["fixed"], fields["value"] = 1, _bits(value)

    def _fixed(self, first, count):
        """(index, value) of the parameters that must keep their values.

        The code holds for the present values only, or was compared with the function only at 0.
        """
        known = self._reads.graph.values
        values = {slot: known[slot] for slot in self._reads.fixed}
        values = dict.fromkeys(self._zeros, 0.0) | values
        return [(i, values[first + i]) for i in range(count) if first + i in values]

    def _array(self, group, place, fields):
        if group is None or not group.shape or group.dtype != "f8":
            raise _NotInC
        found = self._fixed(group.first, math.prod(group.shape))
        pairs = np.array([(8 * i, _bits(value)) for i, value in found], np.int64)
        fields["fixed"], fields["value"] = len(pairs), self._address_of(pairs)
        fields["check"], fields["place"] = c.ARRAY, place
        fields["count"] = len(group.shape)
        self._arrays.append(8 * self._place[group.row])


def _bits(value):
    """A float's pattern of bits, as a word."""
    return int(np.float64(value).view(np.int64))
