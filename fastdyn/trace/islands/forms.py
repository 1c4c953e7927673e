"""The forms of an island's arguments and results: types, shapes and constants, without numbers."""

from typing import Any

import numpy as np

from ..graph.kinds import FLOAT, INT, NUMPY
from ..symbols.arrays import Array
from ..symbols.complex_pair import Pair, is_complex, parts
from ..symbols.layout import laid_out
from ..symbols.lazy import complete
from ..symbols.real import Symbol
from ..symbols.symbolic import BATCHES, Batched, Symbolic, is_symbolic, refuse

PLAIN = type(None), bool, int, float, complex, str, bytes, slice, np.generic, np.dtype, type(...)
NUMBERS = {FLOAT: float, INT: int, NUMPY: np.float64}


class Changed(Exception):
    """Raised if a library returns an object of another type or shape than in its first call."""


class Given:
    """The arguments of a call.

    `numbers` lists the symbols, and the arrays with symbols, in the arguments; `size` is the count
    of real numbers in `numbers`.  `key` identifies everything else in the arguments.
    ``of(values)`` builds the arguments from the values of these numbers.  An array of real numbers
    becomes a view of `values`.  `fixed` tells whether `numbers` has only such arrays, so that one
    call of `of` suffices.
    """

    def __init__(self, args, kwargs):
        self.numbers: list = []
        self.size, self.fixed, self._names = 0, True, tuple(kwargs)
        self._make, key = self._part((tuple(args), tuple(kwargs.values())))
        self.key = key, self._names

    def of(self, values):
        args, named = self._make(values)
        return args, dict(zip(self._names, named, strict=True))

    def _take(self, value, size=1):
        """Append a number, or an array of `size` numbers; return its (begin, end) in the values."""
        self.numbers.append(value)
        self.size += size
        return self.size - size, self.size

    def _part(self, value: Any) -> tuple[Any, Any]:
        """(build, key) of a part: ``build(values)`` makes the part, `key` identifies the part."""
        value = complete(value)
        if isinstance(value, Symbol):
            return self._number(value)
        if isinstance(value, Pair):
            self.fixed = False
            at, _ = [self._take(part)[0] for part in parts(value)]
            return lambda v: np.complex128(complex(v[at], v[at + 1])), ("complex",)
        if isinstance(value, Symbolic):
            refuse("a condition that depends on the state is given to a library")
        if isinstance(value, Batched):
            array: Any = value
            if array.dtype.kind == "c":
                return self._complex_array(array.real, array.imag, array.ids)
            return self._real_array(value, array.ids, array.dtype)
        if isinstance(value, np.ndarray):
            return self._array(value)
        if type(value) in (list, tuple):
            return self._sequence(value)
        if isinstance(value, PLAIN):
            return lambda _: value, (type(value), repr(value))
        if isinstance(value, type):
            value = getattr(value, "plain", value)
            return lambda _: value, ("type", value)
        return refuse(f"an object of type {type(value).__name__} is given to a library")

    def _number(self, value):
        kind, self.fixed = NUMBERS[value.kind], False
        at, _ = self._take(value)
        return lambda v: kind(v[at]), ("number", kind)

    def _sequence(self, value):
        kind, made = type(value), [self._part(v) for v in value]
        reads, keys = [read for read, _ in made], tuple(key for _, key in made)
        return lambda v: kind([read(v) for read in reads]), (kind, keys)

    def _array(self, value):
        shape = value.shape
        if value.dtype != object:
            plain = np.array(value)
            return lambda _: plain, ("plain", shape, plain.dtype.str, plain.tobytes())
        flat = value.view(np.ndarray).reshape(-1).tolist()
        if any(isinstance(v, Symbolic) and not isinstance(v, Symbol | Pair) for v in flat):
            refuse("truth values that depend on the state are given to a library")
        if not is_symbolic(flat):
            return self._array(np.array(flat).reshape(shape))
        if not any(map(is_complex, flat)):
            return self._real_array(flat, value, np.dtype(float))
        pairs = list(map(parts, flat))
        return self._complex_array([a for a, _ in pairs], [b for _, b in pairs], value)

    def _real_array(self, numbers, like, dtype):
        """An array of numbers that lies in memory as `like`."""
        at, end = self._take(numbers, like.size)
        shape, key = like.shape, ("array", like.shape, dtype.str, order_of(like))
        if dtype.kind == "f" and like.flags.c_contiguous:
            return lambda v: v[at:end].reshape(shape), key
        self.fixed = False
        return lambda v: laid_out(v[at:end].reshape(shape).astype(dtype), like), key

    def _complex_array(self, real, imag, like):
        self.fixed, size, shape = False, like.size, like.shape
        at, middle = self._take(real, size)
        self._take(imag, size)  # the imaginary parts follow all real parts

        def of_complexes(v):
            found = np.empty(size, complex)
            found.real, found.imag = v[at:middle], v[middle : middle + size]
            return laid_out(found.reshape(shape), like)

        return of_complexes, ("complex array", shape, order_of(like))


def order_of(array):
    """The order of an array in memory, for a key; None for C order."""
    return None if array.flags.c_contiguous else np.empty_like(array.view(np.ndarray), bool).strides


class Result:
    """The form of a library's result: `size` numbers, and constants that no call may change.

    `is_view` tells whether the result shares memory with an argument.

    ``store(value, numbers)`` copies the numbers of a result, or raises Changed.  ``of(found)``
    builds the result from an array of symbols.
    """

    def __init__(self, value, is_view=False):
        self.size, self.is_view = 0, is_view
        self.store, self.of = self._part(value)

    def _part(self, value) -> tuple[Any, Any]:
        at = self.size
        if type(value) in (float, np.float64):
            return self._number(value, at)
        if type(value) is np.complex128 or type(value) is complex:
            return self._complex_number(type(value), at)
        if type(value) is np.ndarray and value.dtype in (float, complex):
            return self._array(value, at)
        if isinstance(value, list | tuple):
            return self._sequence(value)
        if isinstance(value, bool | int | np.bool_ | np.integer | str | None):
            return self._constant(value)
        what = f"{value.dtype} array" if isinstance(value, np.ndarray) else type(value).__name__
        return refuse(f"a library gives an object of type {what}")

    def _number(self, value, at):
        kind = type(value)
        self.size += 1

        def store(value, numbers):
            if type(value) is not kind:
                raise Changed
            numbers[at] = value

        def of(found):
            number = found[at]
            return Symbol(number.g, number.node, FLOAT if kind is float else NUMPY)

        return store, of

    def _complex_number(self, kind, at):
        self.size += 2

        def store(value, numbers):
            if type(value) is not kind:
                raise Changed
            numbers[at : at + 2] = value.real, value.imag

        return store, lambda found: Pair(found[at], found[at + 1])

    def _array(self, value, at):
        shape, size, dtype = value.shape, value.size, value.dtype
        of_complexes = dtype.kind == "c"
        end = self.size = at + size * (2 if of_complexes else 1)

        def store(value, numbers):
            if type(value) is not np.ndarray or value.shape != shape or value.dtype != dtype:
                raise Changed
            if of_complexes:
                flat: Any = value.reshape(-1)
                numbers[at : at + size], numbers[at + size : end] = flat.real, flat.imag
            else:
                numbers[at:end] = value.reshape(-1)

        def of(found):
            part = found[at:end].copy()
            if not of_complexes:
                return laid_out(part.reshape(shape), value)
            if isinstance(found, Batched):
                both: Any = part
                whole = BATCHES["joint"](both[:size].reshape(shape), both[size:].reshape(shape))
                return laid_out(whole, value)
            pairs = np.empty(size, dtype=object)
            pairs[:] = [Pair(a, b) for a, b in zip(part[:size], part[size:], strict=True)]
            return laid_out(pairs.view(Array).reshape(shape), value)

        return store, of

    def _sequence(self, value):
        kind: Any = type(value)
        if kind not in (list, tuple) and not hasattr(kind, "_make"):
            refuse(f"a library gives an object of type {kind.__name__}")
        made = [self._part(v) for v in value]

        def store(value, numbers):
            if type(value) is not kind or len(value) != len(made):
                raise Changed
            for (store_one, _), each in zip(made, value, strict=True):
                store_one(each, numbers)

        def of(found):
            parts = [of_one(found) for _, of_one in made]
            make: Any = getattr(kind, "_make", kind)
            return make(parts)

        return store, of

    def _constant(self, value):
        def store(now, _):
            if type(now) is not type(value) or now != value:
                raise Changed

        return store, lambda *_: value
