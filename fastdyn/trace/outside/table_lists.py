"""Long lists and tuples of numbers from outside, each stored as one array with an address."""

from typing import Any

import numpy as np

from ..graph.kinds import INT, NUMPY
from ..numpy.stand_ins import List
from ..reads.reads import MAX_ARRAY
from ..reads.table_reads import KINDS
from ..symbols.lazy import Unasked
from ..symbols.real import Symbol
from ..symbols.symbolic import Lazy, Symbolic
from ..symbols.symbolic_indices import chosen, index_of, name_of_slots, part_of


class Items:
    """The items of a list of numbers, or of a list of rows.

    Parameters
    ----------
    graph : Graph
    slots : range
        The slots of the numbers.
    content : ndarray
        The current numbers.
    nature : Nature
    constants : callable
        Called when items become constants.
    whole : bool
        Whether whole numbers may be parameters.
    """

    def __init__(self, graph, slots, content, nature, constants, whole):
        self.graph, self.slots, self.content = graph, slots, content
        self.nature, self.constants, self.whole = nature, constants, whole
        self.kind = KINDS[nature.types][1]

    def at(self, i, constant=False):
        """Item i, or row i."""
        if not self.nature.rows:
            return self._number(i, constant)
        m = self.nature.shape[1]
        row = [self._number(i * m + j, constant) for j in range(m)]
        if self.nature.rows is tuple:
            return tuple(row)
        return List(row)

    def _number(self, place, constant):
        whole = self.kind == INT or bool(self.nature.whole and self.nature.whole[place])
        if constant or self.kind is bool or (whole and not self.whole):
            self.constants()
            value = self.content.reshape(-1)[place]
            return int(value) if whole else value if self.kind == NUMPY else value.item()
        g = self.graph
        return Symbol(g, g.make("par", (), self.slots[place]), INT if whole else self.kind)

    def entry(self, index):
        """The item, or the row, at a symbolic index."""
        at = np.arange(self.content.size).reshape(self.content.shape)
        key = (index,) + (slice(None),) * (at.ndim - 1)
        found = chosen(at, key, self.name_of, self.kind)
        if not self.nature.rows:
            return found
        return tuple(found) if self.nature.rows is tuple else List(found)

    def name_of(self, places):
        return name_of_slots(self.graph, part_of(self.slots, places))

    def table(self):
        """The (name, numbers) of the list as a table; None for a list of rows."""
        if self.nature.rows or self.kind is bool:
            return None
        return self.name_of(range(self.content.size)), self.content


class Rows(list):
    """The lists that a run got and may write to; iterated as one list of all their items."""

    def __init__(self):
        self.lists, self.before = [], []

    def __iter__(self):
        return (v for one in self.lists for v in list.__iter__(one))

    def add(self, one, items):
        self.lists.append(one)
        self.before += items


class _Long(Lazy):
    """The common part of LongList and LongTuple; `_items` is None once all items are filled in."""

    _items: Any = None
    _asked: Any
    _rows: Any

    @classmethod
    def made(cls, items):
        new: Any = cls([Unasked(items.graph)] * len(items.content))  # pyright: ignore
        new._items, new._asked, new._rows = items, {}, Rows()
        return new

    @property
    def graph(self):
        return self._items and self._items.graph

    def table(self):
        return self._items and self._items.table()

    def content(self):
        """(slots, numbers, kind, constants) of the Items; None after all items were filled in."""
        items = self._items
        return items and (items.slots, items.content, items.kind, items.constants)

    def watch(self):
        return "a list", self._rows, self._rows.before

    def reset(self):
        """The list itself, reset for another run; None if all items were filled in."""
        if self._items is None:
            return None
        self._asked, self._rows = {}, Rows()
        return self

    def _all(self):
        items = self._items
        constant = items.content.size > MAX_ARRAY
        found = [self._asked.get(i) or items.at(i, constant) for i in range(len(items.content))]
        for row in found:
            if type(row) is List and not any(row is one for one in self._asked.values()):
                self._rows.add(row, list(row))
        return found

    def _at(self, key):
        key = index_of(key)
        if isinstance(key, Symbolic):
            return self._items.entry(key)
        place = key.__index__()
        n = len(self._items.content)
        if not -n <= place < n:
            raise IndexError("index out of range")
        place %= n
        if place not in self._asked:
            found = self._asked[place] = self._items.at(place)
            if type(found) is List:
                self._rows.add(found, list(found))
        return self._asked[place]


class LongList(_Long, List):
    def filled(self):
        if self._items is not None:
            found = self._all()
            self._items = None
            list.__setitem__(self, slice(None), found)
            self._rows.add(self, found)
        return self

    def __getitem__(self, i) -> Any:
        if self._items is None or isinstance(i, slice):
            return List.__getitem__(self.filled(), i)
        return self._at(i)

    def __radd__(self, other):
        return List([*other, *self.filled()]) if isinstance(other, list) else NotImplemented


class LongTuple(_Long, tuple):
    def filled(self):
        return tuple(self._all())

    def __getitem__(self, i) -> Any:
        return self.filled()[i] if isinstance(i, slice) else self._at(i)

    def __radd__(self, other):
        return (*other, *self.filled()) if isinstance(other, tuple) else NotImplemented


def _of_all(plain, name):
    function = getattr(plain, name)

    def method(self, *args):
        return function(self.filled(), *map(_filled, args))

    return method


def _filled(value):
    return value.filled() if isinstance(value, _Long) else value


_OWN = {"__new__", "__init__", "__getitem__", "__len__", "__class__", "__getattribute__"}
_OWN |= {"__setattr__", "__delattr__", "__init_subclass__", "__subclasshook__", "__dir__"}
for _cls, _plain in ((LongList, list), (LongTuple, tuple)):
    for _name in dir(_plain):
        if callable(getattr(_plain, _name)) and _name not in _OWN and _name != "__hash__":
            setattr(_cls, _name, _of_all(_plain, _name))
LongList.__hash__ = None  # pyright: ignore
