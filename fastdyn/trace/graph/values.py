"""The values of all parameters, indexed by slot; an array has consecutive slots."""

import numpy as np

from ..operations import OPERATIONS


class Values:
    """An array that grows at its end."""

    def __init__(self):
        self._room = np.empty(16)
        self._n = 0

    def extend(self, numbers):
        numbers = np.ravel(numbers)
        n = self._n + numbers.size
        if n > len(self._room):
            self._room = np.concatenate([self._room, np.empty(max(n, len(self._room)))])
        self._room[self._n : n] = numbers
        self._n = n

    def __len__(self):
        return self._n

    def __array__(self, dtype=None, copy=None):
        return np.array(self._room[: self._n], dtype=dtype, copy=copy)

    def __getitem__(self, slot):
        return float(self._room[: self._n][slot])

    def __setitem__(self, slots, numbers):
        self._room[: self._n][slots] = numbers


def _names(node):
    """The names of an operation's tables."""
    if node.op == "table":
        return (node.data,)
    return node.data[:1] if node.op == "search" else node.data


def ranges_of(node, tables):
    """The slots of each table of parameters that a node reads."""
    found = [tables[name] for name in _names(node)] if OPERATIONS[node.op].tables else ()
    return [table for table in found if isinstance(table, range)]


def contents(node, tables, values):
    """The data of an operation on tables, with each name replaced by the table's content."""
    found = [tables[name] for name in _names(node)]
    found = [entries(values, table) if isinstance(table, range) else table for table in found]
    if node.op == "table":
        return found[0]
    return (found[0], node.data[1]) if node.op == "search" else found


def entries(values, slots):
    """The values of a range of slots."""
    return np.asarray(values)[slots.start : slots.stop : slots.step]
