"""Indices that depend on t, y or parameters: bounds checks, and entries of tables."""

import contextlib
import itertools
import operator
from typing import Any

import numpy as np

from ..graph.kinds import INT
from .conditions import Condition
from .real import Symbol
from .symbolic import Batched, Symbolic, is_symbolic, refuse

LONG = 64  # a constant table with more numbers is stored beside the code


def index_of(key) -> Any:
    """Check a symbol as an index; if parameters alone determine the symbol, return its integer."""
    if not isinstance(key, Symbol):
        return key
    if not key.node.varies:
        return key.__index__()
    if key.kind != INT:
        raise TypeError("indices must be integers")
    return key


def check_bounds(index, n):
    """Raise IndexError where an index is outside -n, ..., n - 1."""
    g = index.g
    below = g.compare(index.node, g.const(float(n)), "lt")
    above = g.compare(g.const(float(-n)), index.node, "le")
    g.raises_if(g.negation(g.both(below, above)), _out_of_range)


def _out_of_range():
    raise IndexError("index out of range")


def entry(g, name, node, kind):
    """The element of a table at the index `node`; a truth value if `kind` is bool."""
    found = g.make("table", (node,), name)
    if kind is bool:
        return g.condition(g.negation(g.compare(found, g.const(0.0), "eq")))
    return Symbol(g, found, kind)


def table_of(g, content):
    """The name of a table of constants; a long table is stored beside the code."""
    return namer(g, content)(range(len(content)))


def namer(g, content):
    """A function ``name_of(places)``, which names a table of the constants at a range of places."""
    content = np.ascontiguousarray(content)
    if content.size <= LONG:
        numbers = content.astype(float)
        return lambda places: g.table(numbers[places.start : places.stop : places.step])
    key = "constants", content.__array_interface__["data"][0], content.shape, content.dtype
    slots, known, _ = g.kept.get(key) or (None, None, None)
    if slots is None or (content.flags.writeable and known != content.tobytes()):
        slots = g.reads.held(content)
        # the array is kept, so that its address stays unique
        g.kept[key] = slots, content.flags.writeable and content.tobytes(), content
    return lambda places: name_of_slots(g, part_of(slots, places))


def part_of(slots, places):
    """The slots, as a range, of the elements at the range `places` of an array."""
    first = slots[0]
    return range(first + places.start, first + places.stop, places.step)


def name_of_slots(g, slots):
    """The name of a table of parameters."""
    name = f"{slots}"
    g.tables[name] = slots
    return name


def chosen(at, key, name_of, kind) -> Any:
    """The entries of a table at a key with symbols.

    Parameters
    ----------
    at : ndarray of int
        The places in the table of the elements of an array, evenly spaced along each axis.
    key : tuple
        Plain keys and symbols, one for each axis.
    name_of : callable
        ``name_of(places)`` is the name of the table of the elements at a range of places.
    kind : int or type
        The kind of the entries; bool for truth values.

    Returns
    -------
    Symbol, Condition, array of objects or None
        None if the places are not in ascending order.
    """
    moving = [i for i, k in enumerate(key) if isinstance(k, Symbol)]
    g = key[moving[0]].g
    if 0 in at.shape:
        return None
    steps, counts = [step_along(at, i) for i in moving], [at.shape[i] for i in moving]
    if min(steps) <= 0:
        return None
    for i, n in zip(moving, counts, strict=True):
        check_bounds(key[i], n)
    plain = tuple(0 if i in moving else k for i, k in enumerate(key))
    firsts = np.asarray(at[plain])
    if len(moving) == 1:
        index, step, count = key[moving[0]].node, steps[0], counts[0]
    else:  # combines several symbols to one index from the first place
        index, step, count = _place(g, [key[i].node for i in moving], steps, counts), 1, 0
        count = 1 + sum(s * (n - 1) for s, n in zip(steps, counts, strict=True))
    result = np.empty(firsts.shape, dtype=object)
    for i in np.ndindex(firsts.shape):
        first = int(firsts[i])
        result[i] = entry(g, name_of(range(first, first + step * count, step)), index, kind)
    return result if result.ndim else result[()]


def step_along(at, axis):
    """The step between places, evenly spaced along an axis of `at`; 1 for a single place."""
    line = np.moveaxis(at, axis, 0).reshape(at.shape[axis], -1)[:2, 0]
    return int(line[-1] - line[0]) if len(line) > 1 else 1


def _place(g, nodes, steps, counts):
    terms = []
    for node, step, n in zip(nodes, steps, counts, strict=True):
        from_end = g.compare(node, g.const(0.0), "lt")
        node = g.select(from_end, g.add(node, g.const(float(n))), node)
        terms.append(g.mul(node, g.const(float(step))))
    return g.sum(terms)


def without_dots(key, ndim):
    """A key as a tuple, with slices in place of its first Ellipsis."""
    key = key if isinstance(key, tuple) else (key,)
    at = next((i for i, k in enumerate(key) if k is Ellipsis), None)
    if at is None:
        return key
    return (*key[:at], *itertools.repeat(slice(None), ndim - len(key) + 1), *key[at + 1 :])


def spread(key, ndim):
    """A key as a tuple, one part for each axis; None if a part is no number, symbol or slice."""
    key = without_dots(key, ndim)
    if any(k is None or isinstance(k, list | np.ndarray | bool) for k in key):
        return None
    if len(key) > ndim or any(k is Ellipsis for k in key):
        return None
    return tuple(map(index_of, (*key, *itertools.repeat(slice(None), ndim - len(key)))))


def by_elements(array, key) -> Any:
    """``array[key]`` for a `key` that has arrays of symbols; each element is looked up by itself.

    The axes of the result lie where NumPy puts them.  None if `key` has no array of symbols, or
    contains None.
    """
    key = without_dots(key, array.ndim)
    of_arrays = [i for i, k in enumerate(key) if isinstance(k, np.ndarray | list)]
    if any(k is None for k in key) or not is_symbolic([key[i] for i in of_arrays]):
        return None
    places = np.broadcast_arrays(*[np.asarray(key[i], object).view(np.ndarray) for i in of_arrays])
    numbers = [k for each in places for k in each.flat]
    if not numbers or not all(isinstance(k, Symbol | int) for k in numbers):
        return None
    shape, found = places[0].shape, []
    for element in zip(*[each.flat for each in places], strict=True):
        one = list(key)
        for i, k in zip(of_arrays, element, strict=True):
            one[i] = k
        found.append(array[tuple(one)])
    rest = np.shape(found[0])
    result = np.empty((len(found), *rest), dtype=object)
    for i, one in enumerate(found):
        result[i] = one
    advanced = [i for i, k in enumerate(key) if not isinstance(k, slice)]
    together = advanced[-1] - advanced[0] == len(advanced) - 1
    axes, at = range(len(shape)), advanced[0] if together else 0
    return np.moveaxis(result.reshape(*shape, *rest), axes, range(at, at + len(shape)))


def plain_key(key: Any) -> Any:
    """An index key with plain numbers in place of symbols."""
    if isinstance(key, tuple):
        return tuple(map(plain_key, key))
    if is_symbolic(key) and not isinstance(key, Symbolic):
        with contextlib.suppress(TypeError):
            key = np.array(key.tolist())
    if isinstance(key, Batched) or (isinstance(key, np.ndarray) and key.dtype.kind == "O"):
        refuse("an array is indexed by an array that depends on the state")
    if isinstance(key, Condition):
        return bool(key)
    if isinstance(key, Symbolic):
        number: Any = key
        return operator.index(number)
    return key
