"""Long arrays from outside: compiled code loads an element from the array's address."""

from typing import Any

import numpy as np

from ..graph.kinds import NUMPY
from ..reads.reads import MAX_ARRAY
from ..symbols.arrays import Array
from ..symbols.layout import laid_out
from ..symbols.lazy import Unasked, complete
from ..symbols.masks import Masked
from ..symbols.real import Symbol
from ..symbols.symbolic import BATCHES, NOW, Batched, Lazy, is_symbolic
from ..symbols.symbolic_indices import (
    by_elements,
    chosen,
    name_of_slots,
    part_of,
    spread,
    step_along,
)  # fmt: skip


class Asked:
    """The elements of a Table that a run has used; `before` keeps their original content."""

    def __init__(self, memory):
        self.memory, self.places, self.before = memory.flat, [], []

    def __iter__(self):
        return (self.memory[i] for i in self.places)

    def forget(self, unasked):
        self.memory[self.places] = unasked
        self.places.clear()
        self.before.clear()

    def untouched(self):
        return all(a is b for a, b in zip(self, self.before, strict=True))


class Elements:
    """The elements of an array from outside: symbols up to MAX_ARRAY used elements, then constants.

    Parameters
    ----------
    graph : Graph
    slots : range
        The slots of the array.
    content : ndarray
        The current numbers.
    constants : callable or None
        Called when elements become constants; None if all elements are constants already.
    """

    def __init__(self, graph, slots, content, constants):
        self.graph, self.slots, self.constants = graph, slots, constants
        self.content, self.count = content.reshape(-1), 0

    def at(self, places):
        g = self.graph
        single = len(places) == 1
        if self.constants is None or (not single and self.count + len(places) > MAX_ARRAY):
            if self.constants is not None:
                self.constants()
            return self.content[places].tolist()
        self.count += len(places)
        return [Symbol(g, g.make("par", (), self.slots[i])) for i in places]

    def name_of(self, places):
        """The name of a table that consists of elements at these places."""
        return name_of_slots(self.graph, part_of(self.slots, places))


class Table(Lazy, Array):
    """A long array whose elements become symbols only where a run uses them.

    The memory, which views share, holds `Unasked` objects at first.  `_at` has the places of the
    elements in the array from outside.  An array that NumPy computes from a Table has no `_at`, and
    acts as a plain Array.
    """

    _at: Any = None
    _elements: Any = None
    _asked: Any = None
    _unasked: Any = None

    @classmethod
    def made(cls, elements, like):
        """The Table of an array that lies in memory as the array `like`."""
        memory, one = np.empty_like(like, object, subok=False), np.empty((), dtype=object)
        one[()] = Unasked(elements.graph)
        memory[...] = one
        at = laid_out(np.arange(memory.size).reshape(memory.shape), memory)
        table = cls._over(memory, at, elements, Asked(memory))
        table._unasked = one
        return table

    @classmethod
    def _over(cls, memory, at, elements, asked):
        table = memory.view(cls)
        table._at, table._elements, table._asked = at, elements, asked
        return table

    def watch(self):
        """(kind of object, used elements now, used elements before the run), to find writes."""
        return "an array", self._asked, self._asked.before

    def reset(self):
        """The table itself, reset for another run."""
        self._asked.forget(self._unasked)
        self._elements.count = 0
        return self

    def copy(self: Any, order: Any = "C") -> Any:
        if self._at is None or self._asked.places or self.size != self._elements.content.size:
            return self.filled().copy(order)
        if (self._at.reshape(-1) != np.arange(self.size)).any():  # a view in another order
            array = self.filled() if NOW.table is None else BATCHES["raised"](NOW.table, self)
            return array.copy(order)
        return Table.made(self._elements, np.empty_like(self._at, order=order))

    __copy__ = copy

    def __deepcopy__(self, memo):
        return self.copy()

    def filled(self):
        bare = self.view(Array)
        if self._at is not None:
            memory, places = self.view(np.ndarray), self._at
            missing = np.array([type(v) is Unasked for v in memory.flat]).reshape(memory.shape)
            self._ask(places[missing])
        return bare

    def _ask(self, places):
        if len(places):
            found = self._elements.at(places)
            self._asked.memory[places] = np.array(found, dtype=object)
            self._asked.places += places.tolist()
            self._asked.before += found

    def table(self):
        """(name, numbers) of this array as a table of the graph; None after a write.

        None also for several axes, and for a step that is not positive.
        """
        if self._at is None or self._at.ndim != 1 or not self.size or not self._asked.untouched():
            return None
        step = step_along(self._at, 0)
        if step <= 0:
            return None
        first = int(self._at[0])
        places = range(first, first + step * self.size, step)
        return self._elements.name_of(places), self._elements.content[self._at]

    def __getitem__(self, key) -> Any:
        key = complete(key)
        if self._at is None:
            return super().__getitem__(key)
        if is_symbolic(key):
            return self._by_symbol(key)
        parts = key if isinstance(key, tuple) else (key,)
        if any(isinstance(k, list | np.ndarray | bool | np.bool_) for k in parts):
            return self.filled()[key]
        at = self._at[key]
        if not isinstance(at, np.ndarray):
            if type(self._asked.memory[at]) is Unasked:
                self._ask(np.array([at]))
            return self._asked.memory[at]
        return Table._over(self.view(np.ndarray)[key], at, self._elements, self._asked)

    def _by_symbol(self, key):
        if isinstance(key, Batched) and key.truth:
            return Masked(self, key)
        found = by_elements(self, key)
        if found is not None:
            return found.view(Array)
        parts = spread(key, self.ndim) if self._asked.untouched() else None
        if parts is not None:
            if not is_symbolic(parts):
                return self[parts]
            found = chosen(self._at, parts, self._elements.name_of, NUMPY)
            if found is not None:
                return found.view(Array) if isinstance(found, np.ndarray) else found
        return self.filled()[key]

    def __setitem__(self, key, value):
        self.filled()[complete(key)] = complete(value)

    def __iter__(self):
        return iter(self.filled())

    flat: Any = property(lambda self: self.filled().flat)
    real: Any = property(lambda self: self.filled().real)
    imag: Any = property(lambda self: self.filled().imag)
    T: Any = property(lambda self: self.transpose())


BY_FUNCTION = {"dot", "sum", "mean", "max", "min", "clip", "repeat", "take"}


def _of_all(name):
    def method(self, *args, **kwargs):
        if NOW.table is not None and self._at is not None and name in BY_FUNCTION:
            return getattr(np, name)(self, *args, **kwargs)
        return getattr(self.filled(), name)(*args, **kwargs)

    return method


def _of_places(name):
    """A method that returns a view where NumPy's method does."""

    def method(self, *args, **kwargs):
        if self._at is not None:
            memory = getattr(self.view(np.ndarray), name)(*args, **kwargs)
            at = getattr(self._at, name)(*args, **kwargs)
            if np.may_share_memory(memory, self):
                return Table._over(memory, at, self._elements, self._asked)
        return getattr(self.filled(), name)(*args, **kwargs)

    return method


_OWN = {"view", "copy", "searchsorted"}
_VIEWS = {"reshape", "ravel", "transpose", "squeeze", "swapaxes"}
for _name in dir(np.ndarray):
    if _name[0] != "_" and callable(getattr(np.ndarray, _name)) and _name not in _OWN:
        setattr(Table, _name, (_of_places if _name in _VIEWS else _of_all)(_name))
Table.__contains__ = _of_all("__contains__")
