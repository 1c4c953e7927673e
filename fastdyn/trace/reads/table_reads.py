"""Reads tables from outside: lists of numbers as arrays, and constants stored beside the code.

`steps` and `checks` include the tables `STEPS` and `CHECKS` of this file.
"""

import hashlib
import math
import operator
from itertools import chain
from typing import Any

import numpy as np

from ..graph.kinds import FLOAT, INT, NUMPY

LONG = 64  # a constant table with more numbers is stored beside the code
MAX_WHOLE = 2**53  # floats represent all integers up to this absolute value
KINDS = {  # types of a list's items: (dtype of the array, kind of the items)
    frozenset((float,)): (float, FLOAT),
    frozenset((int,)): (np.int64, INT),
    frozenset((bool,)): (bool, bool),
    frozenset((float, int)): (float, FLOAT),
    frozenset((np.float64,)): (float, NUMPY),
}


class Held:
    """A constant array; equal contents compare equal."""

    def __init__(self, content):
        self.array = np.array(content, dtype=float, order="C")
        self._name = self.array.shape, hashlib.sha256(self.array.data).digest()

    def __eq__(self, other):
        return isinstance(other, Held) and self._name == other._name

    def __hash__(self):
        return hash(self._name)


def held(reads, content):
    """The slots of a constant array, which is stored beside the code."""
    row = reads.step(reads.root(0), "held", Held(content))
    return reads.parameters(row, reads.rows[row].key.array)


class Nature:
    """The facts about a list of numbers, or of rows of numbers, that a later list must share."""

    def __init__(self, value):
        self.rows = type(value[0]) if type(value[0]) in (list, tuple) else None
        self.shape: tuple = (len(value), len(value[0])) if self.rows else (len(value),)
        self.size = math.prod(self.shape)
        self.last = None  # (items, array) of the last conversion
        self.types, self.whole = frozenset(map(type, self._flat(value))), None
        if len(self.types) > 1:  # marks the items that are integers
            self.whole = bytes([type(v) is int for v in self._flat(value)])

    @classmethod
    def of(cls, value):
        """The Nature of a list of numbers; None for any other list."""
        try:
            found = cls(value)
            found.numbers(value)
        except ValueError:
            return None
        return found

    def __eq__(self, other):
        return isinstance(other, Nature) and self._facts() == other._facts()

    def __hash__(self):
        return hash(self._facts())

    def _facts(self):
        return self.rows, self.shape, self.types, self.whole

    def _flat(self, value):
        if not self.rows:
            return value
        if {*map(type, value)} != {self.rows} or {*map(len, value)} != {self.shape[1]}:
            raise ValueError("rows that differ")
        return chain.from_iterable(value)

    def numbers(self, value):
        """The items as an array; ValueError if the conversion is not exact."""
        kind = KINDS.get(self.types)
        if kind is None:
            raise ValueError("no numbers")
        try:
            found = np.fromiter(self._flat(value), kind[0], self.size)
        except OverflowError as error:
            raise ValueError("a large whole number") from error
        if int in self.types and np.abs(found).max() > MAX_WHOLE:
            raise ValueError("a large whole number")
        return found.reshape(self.shape)


def numbers_of(value, nature):
    """The numbers of a list as an array; ValueError if the nature of the list has changed."""
    if nature.last is not None and nature.rows is None:
        items, found = nature.last
        if len(value) == len(items) and all(map(operator.is_, value, items)):
            return found
    if Nature(value) != nature:
        raise ValueError("a list of other things")
    found = nature.numbers(value)
    nature.last = list(value), found
    return found


def _equal_arrays(value, expected):
    return (
        type(value) is np.ndarray
        and value.dtype == expected.dtype
        and value.shape == expected.shape
        and (value.ndim < 2 or value.flags.c_contiguous == expected.flags.c_contiguous)
        and _bits_are_equal(value, expected)
    )


def _bits_are_equal(value, expected):
    if value.dtype.itemsize == 8 and value.flags.c_contiguous and expected.flags.c_contiguous:
        return np.array_equal(value.view(np.int64), expected.view(np.int64))
    return value.tobytes() == expected.tobytes()


def _is_ascending(value, _):
    return bool(np.all(value[1:] >= value[:-1]))


STEPS: dict[str, Any] = {
    "held": lambda _, constant: constant.array,
    "numbers": numbers_of,
    "itself": lambda value, _: value,
    "entries": lambda value, part: np.ravel(value)[part[0] : part[1] : part[2]],
}
CHECKS: dict[str, Any] = {
    "content": _equal_arrays,
    "numbers": lambda value, expected: (value.dtype, value.shape) == expected,
    "ascending": _is_ascending,
}
