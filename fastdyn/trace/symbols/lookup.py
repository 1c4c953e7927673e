"""Indices that depend on t, y or parameters: masks, and entries of tables."""

from typing import Any

import numpy as np

from .arithmetic import call, where
from .lift import index, joint, symbol
from .masks import Masked, chosen
from .symbol import HANDLERS, Symbol, is_plain, parts_of, refuse, wrap

MAX_CHOICES = 64  # most elements that a symbolic index selects from by comparisons


def item(array, key) -> Any:
    """``array[key]`` for a key with symbols."""
    key = _plain(array, key)
    if is_plain(key):
        return array[key]
    if type(key) is Symbol and key.kind == "b" and key.many:
        return Masked(array, key)
    keys = _spread(key, array.ids.ndim)
    at = [i for i, k in enumerate(keys) if type(k) is Symbol]
    if any(keys[i].kind == "b" for i in at):
        refuse("a selection by a mask of the state beside other indices")
    if any(keys[i].kind != "i" for i in at):
        raise IndexError("arrays used as indices must be of integer (or boolean) type")
    if any(keys[i].many for i in at):
        return _by_elements(array, keys)
    return _chosen(array, keys, at)


def _plain(array, key) -> Any:
    """A key with plain numbers in place of symbols that parameters alone determine."""
    if isinstance(key, tuple):
        return tuple([_plain(array, k) for k in key])
    if isinstance(key, list):
        key = symbol(array.g, key)
    if isinstance(key, slice):
        return slice(*[v if v is None else index(v) for v in (key.start, key.stop, key.step)])
    if type(key) is not Symbol or key.varies:
        return key
    return key.plain() if key.many or key.kind in "bi" else index(key)


def _spread(key, ndim):
    """A key as a tuple, one part for each axis."""
    key = key if isinstance(key, tuple) else (key,)
    if any(k is None or isinstance(k, bool | np.bool_) for k in key):
        refuse("an array is indexed by None and numbers that depend on the state")
    at = next((i for i, k in enumerate(key) if k is Ellipsis), None)
    if at is not None:
        key = (*key[:at], *[slice(None)] * (ndim - len(key) + 1), *key[at + 1 :])
    if len(key) > ndim:
        raise IndexError("too many indices for array")
    return (*key, *[slice(None)] * (ndim - len(key)))


def check_bounds(i, n):
    """Raise IndexError where an index is outside -n, ..., n - 1."""
    g = i.g
    beyond = g.map("le", g.const(float(n)).key, i.ids)
    below = g.map("lt", i.ids, g.const(-float(n)).key)
    g.raises_if(g.map("or", beyond, below), lambda: ()[n])


def _chosen(array, keys, at):
    """The entry, or the entries, at indices of which some are single symbols."""
    counts = [array.ids.shape[axis] for axis in at]
    for axis, n in zip(at, counts, strict=True):
        check_bounds(keys[axis], n)
    place = keys[at[0]]
    if len(at) > 1:  # several indices are one index into the rows of all their entries
        place = 0
        for axis, n in zip(at, counts, strict=True):
            from_end = call("less", keys[axis], 0)
            place = place * n + where(from_end, keys[axis] + n, keys[axis])
    rest = tuple([slice(None) if axis in at else k for axis, k in enumerate(keys)])
    lead = array.ids[rest]
    before = [sum(not isinstance(k, slice) for k in rest[:axis]) for axis in at]
    lead = np.moveaxis(lead, [x - y for x, y in zip(at, before, strict=True)], range(len(at)))
    lead = lead.reshape(-1, *lead.shape[len(at) :])
    found = np.empty(lead.shape[1:], lead.dtype)
    for one in np.ndindex(found.shape):
        found[one] = _entry(array, lead[(slice(None), *one)], place).ids
    return wrap(array.g, found[()], array.kind)


def _entry(array, ids, i):
    """The number at index i among the numbers `ids`, none of which the index is beyond."""
    g = array.g
    if array.kind == "c":
        parts = [_entry(Symbol(g, p), p, i) for p in parts_of(ids)]
        return joint(*parts)
    if array.kind == "b" and (known := g.known(ids)) is not None:
        name = g.constant_table(np.asarray(known, float))
        return symbol(g, call("not_equal", Symbol(g, g.map("table", i.ids, data=name)), 0.0))
    name = g.table_name(ids) if array.kind != "b" else None
    if name is not None:
        return Symbol(g, g.map("table", i.ids, data=name), array.kind)
    if len(ids) > MAX_CHOICES and array.kind == "f":
        return _of_many(g, np.ascontiguousarray(ids), i)
    if len(ids) > MAX_CHOICES:
        refuse("an index that depends on the state, of a long array")
    each = [Symbol(g, int(j), array.kind) for j in ids]
    return _selected(each, i)


def _of_many(g, ids, i):
    """The number at index i: the largest where all others are taken for the least number."""
    n = float(len(ids))
    place = g.map("select", g.map("lt", i.ids, g.const(0.0).key),
                  g.map("add", i.ids, g.const(n).key), i.ids)  # fmt: skip
    here = g.map("eq", g.constants(np.arange(n)), place)
    kept = g.map("select", here, ids, g.const(-np.inf).key)
    return Symbol(g, g.reduce("top", kept))


def _selected(values, i) -> Any:
    found = values[0]
    n = len(values)
    for k in range(1, n):
        here = call("logical_or", call("equal", i, k), call("equal", i, k - n))
        found = where(here, values[k], found)
    return found


def look_up(rows, i, checked=False) -> Any:
    """``rows[i]`` of a list of numbers, arrays or rows, at an index that depends on the state."""
    if not i.varies:
        return rows[index(i)]
    if i.kind != "i":
        raise TypeError("list indices must be integers or slices, not float")
    if not checked:
        check_bounds(i, len(rows))
    kind = type(rows[0])
    if isinstance(rows[0], list | tuple):
        if any(type(row) is not kind or len(row) != len(rows[0]) for row in rows):
            refuse("a list of rows of several kinds, at an index that depends on the state")
        return kind([look_up(list(column), i, True) for column in zip(*rows, strict=True)])
    if any(not isinstance(v, int | float | complex | np.number | np.ndarray) for v in rows):
        refuse("a list of other things than numbers, at an index that depends on the state")
    g = i.g
    each = [symbol(g, v) for v in rows]
    if not any(s.many for s in each):
        array = symbol(g, list(rows))
        found = _entry(array, array.ids, i)
        return wrap(g, found.ids, found.kind, all(s.py for s in each))
    if len(rows) > MAX_CHOICES:
        refuse("a long list of parameters, at an index that depends on the state")
    return _selected(each, i)


def _by_elements(array, keys):
    """The entries at an array of indices; the axes of the result lie where NumPy puts them."""
    of_arrays = [i for i, k in enumerate(keys) if not isinstance(k, slice)]
    g = array.g
    places = np.broadcast_arrays(*[symbol(g, keys[i]).ids for i in of_arrays])
    shape = places[0].shape
    found = []
    for element in zip(*[p.flat for p in places], strict=True):
        one: list[Any] = list(keys)
        for i, k in zip(of_arrays, element, strict=True):
            one[i] = Symbol(g, int(k), "i", True)
        found.append(array[tuple([k if not isinstance(k, Symbol) or k.varies else index(k)
                                  for k in one])])  # fmt: skip
    if not found:
        refuse("an array is indexed by nothing")
    rest = found[0].ids.shape if found[0].many else ()
    ids = np.array([s.ids for s in found], array.ids.dtype).reshape(*shape, *rest)
    together = of_arrays[-1] - of_arrays[0] == len(of_arrays) - 1
    at = of_arrays[0] if together else 0
    axes = range(len(shape))
    return wrap(g, np.moveaxis(ids, axes, range(at, at + len(shape))), array.kind)


def store(array, key, value):
    """``array[key] = value`` for a key with symbols."""
    key = _plain(array, key)
    if type(key) is Symbol and key.kind == "b":
        if key.many and key.ids.shape != array.ids.shape:
            refuse("a mask of the state of another shape than the array")
        given = where(key, chosen(key, value), array.copy())
        array.put(..., HANDLERS["cast"](array.g, given, array.kind, "unsafe"))
        return
    keys = key if isinstance(key, tuple) else (key,)
    if any(type(k) is Symbol and (k.many or k.kind == "b") for k in keys):
        refuse("a store at an index that depends on the state")
    array[tuple([index(k) if type(k) is Symbol else k for k in keys])] = value


class Flat:
    """The elements of an array in C's order."""

    def __init__(self, array):
        self._array = array

    def __len__(self):
        return self._array.ids.size

    def __getitem__(self, key):
        return self._array.flatten()[key]

    def __setitem__(self, key, value):
        a = self._array
        ids = np.array(HANDLERS["cast"](a.g, value, a.kind, "unsafe"), a.ids.dtype)
        at = np.arange(a.ids.size)[key]
        a.put(np.unravel_index(at, a.ids.shape), np.resize(ids, np.shape(at)))

    def _refused(self, *_) -> Any:
        refuse("`flat` of an array that depends on the state")

    __array__ = __getattr__ = _refused


HANDLERS.update(item=item, store=store, flat=Flat)
