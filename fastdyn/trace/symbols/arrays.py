"""Arrays that can hold symbols, and that symbols can index."""

import functools
from typing import Any

import numpy as np

from ..graph.kinds import FLOAT, INT, NUMPY
from .complex_pair import Pair, is_complex, parts
from .conditions import Condition, both, cast, either, kind_of_number, select
from .layout import laid_out, like_a_ufunc
from .lazy import complete
from .masks import WHY, Masked, chosen
from .operators import by_function
from .real import Symbol, as_python
from .symbolic import (
    BATCHES,
    NOW,
    AnswersNumPy,
    Batched,
    in_batches,
    is_symbolic,
    kind_of,
    refuse,
)  # fmt: skip
from .symbolic_indices import by_elements, check_bounds, entry, index_of, table_of, without_dots

OF_TYPES = {float: FLOAT, int: INT, bool: bool}
MAX_CHOICES = 64  # most elements that a symbolic index selects from by comparisons


def _of_truths(function, start):
    def method(self, axis=None, out=None, keepdims=False, where: Any = True):
        if where is not True:
            refuse("any or all of chosen elements")
        fold = functools.partial(functools.reduce, function)
        return stored(reduced(lambda row: fold(row, start), self, axis, keepdims), out)

    return method


class Array(AnswersNumPy, np.ndarray):
    """An array of objects, numbers and symbols; NumPy's calls on it go to `numpy.calls`."""

    @classmethod
    def of(cls, value):
        """Convert an array or a nested list to an Array; an Array stays."""
        value = complete(value)
        if isinstance(value, cls):
            return value
        if isinstance(value, np.ndarray):
            return (value if value.dtype == object else value.astype(object)).view(cls)
        return np.array(value, dtype=object).view(cls)

    @classmethod
    def scalar(cls, value):
        array = np.empty((), dtype=object)
        array[()] = value
        return array.view(cls)

    def watch(self):
        """(kind of object, array, elements before the run), to find writes."""
        return "an array", self, list(self.flat)

    def __reduce__(self):
        refuse("an array that depends on the state is pickled")

    def dump(self, file):
        refuse("it writes to a file", effect=True)

    def astype(self, dtype=None, order: Any = "K", casting="unsafe", subok=True, copy: Any = True):
        if dtype is object:
            return self.copy(order)
        kind = max(_kinds(self), key="bifc".find, default="")
        if not copy and order == "K" and kind == kind_of(dtype):
            return self
        found = elementwise(lambda v: cast(v, dtype), self)
        return found if order == "K" else found.copy(order)

    def __getitem__(self, key) -> Any:
        key = complete(key)
        if is_symbolic(key):
            return _at(self, key)
        return super().__getitem__(_plain_key(key))

    def __setitem__(self, key, value):
        key, value = complete(key), complete(value)
        is_mask = is_symbolic(key) and _is_mask(key)
        if is_mask:
            value = chosen(key, value)
        elif isinstance(value, Masked):
            refuse(WHY)
        if isinstance(value, np.ndarray) and value.ndim == 0:
            value = value.item()
        if _are_whole(self.flat) and not {"f", "c"}.isdisjoint(_kinds(value)):
            refuse("a number is stored in an array of whole numbers, or of truth values")
        if not is_symbolic(key):
            return super().__setitem__(_plain_key(key), value)
        if isinstance(key, Symbol) and self.ndim == 1:
            look_up(list(self), key)  # raises IndexError for an index out of bounds
            for i in range(len(self)):
                here = (key == i) | (key == i - len(self))
                super().__setitem__(i, select(here, value, super().__getitem__(i)))
            return None
        if not is_mask or key.shape != self.shape:
            refuse("a store at an index that depends on the state")
        new = np.broadcast_to(Array.of(value), self.shape)
        for i in np.ndindex(self.shape):
            super().__setitem__(i, select(key[i], new[i], super().__getitem__(i)))

    flat: Any = property(
        lambda self: self.view(np.ndarray).flat, lambda *_: refuse("it writes to `flat`")
    )
    any: Any = _of_truths(either, False)
    all: Any = _of_truths(both, True)

    def mean(self, axis=None, dtype=None, out=None, where: Any = True, **more):
        result = np.add.reduce(self, axis=axis, dtype=dtype, where=where, **more)
        count: Any = self.size // max(1, np.size(result))
        if where is not True:
            ones = elementwise(lambda chosen: select(chosen, 1.0, 0.0), where)
            count = np.add.reduce(np.broadcast_to(ones, self.shape), axis=axis, **more)
        return stored(result / count, out)

    def __round__(self, digits=None):
        return round(self.item(), digits)

    def tolist(self):
        found: Any = elementwise(as_python, self)
        return found.view(np.ndarray).tolist() if self.ndim else found

    def item(self, *at):
        return as_python(self.view(np.ndarray).item(*at))

    def _memory(self, *_, **__) -> Any:
        refuse("the memory of an array that depends on the state is used")

    tobytes = tofile = byteswap = _memory
    data = base = ctypes = property(_memory)  # type: ignore

    def _real(self) -> Any:
        """The array itself if all elements are real; else a read-only array of real parts."""
        if not any(map(is_complex, self.flat)):
            return self
        return _only_read(elementwise(lambda v: v.real, self))

    def _imag(self) -> Any:
        return _only_read(elementwise(lambda v: v.imag if is_complex(v) else 0.0, self))

    real: Any = property(_real)
    imag: Any = property(_imag)


for _name in "max min dot clip searchsorted conj conjugate".split():
    setattr(Array, _name, by_function(_name))


def _is_mask(key):
    if not isinstance(key, np.ndarray):
        return False
    return key.dtype == bool or (key.ndim > 0 and _kinds(key) == {"b"})


def _are_whole(values):
    """Whether values are the elements of an array of whole numbers, or of truth values.

    An array of Python's whole numbers alone may be one of floats.
    """
    known = False
    for v in values:
        if kind_of_number(v) in "fc":
            return False
        known = known or isinstance(v, Symbol | Condition | bool | np.bool_)
    return known


def _kinds(value):
    """The kinds of the numbers in a value."""
    if isinstance(value, Batched):
        return {value.dtype.kind}
    return set(map(kind_of_number, np.asarray(value, object).flat))


def _only_read(part):
    if isinstance(part, np.ndarray):
        part.flags.writeable = False
    return part


def stored(result, out) -> Any:
    """Store a result in `out`, if `out` is given, and return it."""
    if isinstance(out, tuple):
        (out,) = out
    if out is None:
        return result
    if out.dtype != object and not isinstance(out, Batched) and is_symbolic(result):
        refuse("a result that depends on the state is stored in an array from outside")
    if np.ndim(result) and np.shape(result) != out.shape:
        refuse("a result is stored in an array of another shape")
    of_numbers = result if isinstance(result, Batched) else np.empty(0)
    if isinstance(out, Batched) and not np.can_cast(of_numbers.dtype, out.dtype, "same_kind"):
        refuse(f"numbers are stored in an array of {out.dtype}", typed=True)
    out[...] = result
    return out


def _plain_key(key):
    """Convert the arrays of objects in a key without symbols to integers or truth values."""
    if isinstance(key, tuple):
        return tuple(map(_plain_key, key))
    if isinstance(key, Array) and key.size:
        return np.array(key.tolist())
    return key


def elementwise(function, *values) -> Any:
    """Apply a function of numbers to the elements of broadcast arrays."""
    if any(isinstance(v, Masked) for v in values):
        refuse(WHY)
    if in_batches(values):
        return BATCHES["elementwise"](NOW.table, function, values)
    arrays = [
        Array.of(v) if isinstance(v, np.ndarray | list | tuple) else Array.scalar(v) for v in values
    ]
    many = np.broadcast_arrays(*[a.view(np.ndarray) for a in arrays])
    result = np.empty(many[0].shape, dtype=object)
    flat = result.reshape(-1)
    for i, row in enumerate(zip(*(m.reshape(-1) for m in many), strict=True)):
        flat[i] = function(*row)
    return laid_out(result.view(Array), like_a_ufunc(arrays)) if result.ndim else result[()]


def reduced(function, array, axis=None, keepdims=False) -> Any:
    """Apply a function of a list of numbers along axes."""
    array = np.asarray(array, dtype=object).view(np.ndarray)
    axes = range(array.ndim) if axis is None else np.atleast_1d(axis)
    axes = [int(a) % array.ndim for a in axes]
    kept = [i for i in range(array.ndim) if i not in axes]
    rows = array.transpose(kept + axes).reshape([array.shape[i] for i in kept] + [-1])
    result = np.empty(rows.shape[:-1], dtype=object)
    for i in np.ndindex(result.shape):
        result[i] = function(list(rows[i]))
    if keepdims:
        result = result.reshape([1 if i in axes else s for i, s in enumerate(array.shape)])
    return result.view(Array) if result.ndim else result[()]


# -- an index that depends on t, y or parameters


def _at(array, key):
    """``array[key]`` for a key with symbols: a table lookup, a choice, or a Masked."""
    if _is_mask(key):
        return Masked(array, key)
    found = by_elements(array, key)
    if found is not None:
        return found.view(Array)
    key = without_dots(key, array.ndim)
    where = [i for i, k in enumerate(key) if is_symbolic(k)]
    if any(k is None for k in key):
        refuse("an array is indexed by None and numbers that depend on the state")
    i = where[0]
    if not isinstance(key[i], Symbol):
        refuse("an array is indexed by an array that depends on the state")
    rows = [array[(*key[:i], j, *key[i + 1 :])] for j in range(array.shape[i])]
    return look_up(rows, key[i])


def look_up(rows, index):
    """``rows[index]``; an index out of bounds raises IndexError."""
    index = index_of(index)
    if not isinstance(index, Symbol):
        return rows[index]
    check_bounds(index, len(rows))
    if isinstance(rows[0], np.ndarray):
        return elementwise(lambda *column: _choice(column, index), *rows)
    if all(type(row) in (list, tuple) or isinstance(row, list) for row in rows):
        columns = zip(*rows, strict=True)
        return type(rows[0])(_choice(column, index) for column in columns)
    return _choice(rows, index)


def _choice(values, index):
    values, g = list(values), index.g
    if any(map(is_complex, values)):
        return Pair(*(_choice(part, index) for part in zip(*map(parts, values), strict=True)))
    if all(isinstance(v, Symbol) and v.node.op == "par" for v in values) and len(values) > 4:
        return entry(g, g.table(values), index.node, values[0].kind)
    if not is_symbolic(values):
        if any(not isinstance(v, int | float | np.number) for v in values):
            refuse("a list of other things than numbers, at an index that depends on the state")
        kinds = set(map(type, values))
        kind = OF_TYPES.get(kinds.pop(), NUMPY) if len(kinds) == 1 else NUMPY
        return entry(g, table_of(g, np.array(values, float)), index.node, kind)
    if len(values) > MAX_CHOICES:
        refuse("a long list of parameters, at an index that depends on the state")
    result = values[0]
    for i in range(1, len(values)):
        result = select((index == i) | (index == i - len(values)), values[i], result)
    return result
