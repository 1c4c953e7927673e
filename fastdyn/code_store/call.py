"""Calls of kernels from Python, with arguments laid out once, in words."""

import ctypes
import struct
from array import array
from typing import Any

import numpy as np

from fastdyn.kernels.calls.block import FAILED

KERNEL = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)  # releases the interpreter lock
_as_float = struct.Struct("d").pack
_as_word = struct.Struct("q").unpack
_pointer_at = ctypes.c_void_p.from_address
_HEAD = object.__basicsize__


def address_of(a):  # pyright: ignore
    """The address of an array's data, in a tenth of the time of ``a.ctypes.data``."""
    return _pointer_at(id(a) + _HEAD).value or 0  # behind the head of the object


def _first_field_is_data():
    probe = np.zeros(3)
    return address_of(probe) == probe.ctypes.data


if not _first_field_is_data():  # an interpreter with another layout of objects

    def address_of(a):  # pyright: ignore
        """The address of an array's data."""
        return a.ctypes.data


class Argument:
    """The place of one argument, from word `at` on; kinds: "int64", "float64", "dtype:ndim"."""

    __slots__ = ("at", "dtype", "index", "is_array", "kind", "name", "ndim", "none")

    def __init__(self, name, kind, index, at):
        self.name = name
        self.kind = kind
        self.index = index
        self.at = at
        self.dtype = None
        self.is_array, self.ndim = ":" in kind, int(kind.partition(":")[2] or 0)
        self.none = (0,) * (1 + self.ndim)

    def check(self, value):
        """Raise TypeError for an array that the kernel does not take."""
        given = f"{value.dtype.str}:{value.ndim}"
        if given != self.kind or not value.flags.c_contiguous:
            raise TypeError(
                f"`{self.name}` must be a C-contiguous array of {self.kind}; got {given}"
            )
        self.dtype = value.dtype  # for the next comparison by identity


def laid_out(arguments):
    """{name: Argument} of (name, kind) pairs."""
    layout = {}
    at = 0
    for index, (name, kind) in enumerate(arguments):
        layout[name] = argument = Argument(name, kind, index, at)
        at += 1 + argument.ndim
    return layout


def _words(arguments, values):
    """The words of values, one for each Argument."""
    words = []
    for argument, a in zip(arguments, values, strict=True):
        if a is None:
            words += argument.none
        elif argument.is_array:
            shape = a.shape
            if (
                a.dtype is not argument.dtype
                or len(shape) != argument.ndim
                or not a.flags.c_contiguous
            ):
                argument.check(a)
            words.append(address_of(a))
            words += shape
        elif argument.kind == "int64":
            words.append(a)
        else:
            words += _as_word(_as_float(a))
    return words


class Call:
    """A kernel with its arguments.  A call costs 0.2 us, and returns the status of the kernel.

    Parameters
    ----------
    code : Code
        Of a kernel.
    *values : int, float, ndarray or None
        The arguments in order, the fields of a named tuple one by one.  Arrays are used in place
        and kept alive; None is an empty array.  ``call[name] = value`` changes one argument; a
        field of a named tuple is "name.field".

    Raises
    ------
    TypeError
        An array of another dtype or number of dimensions, or one that is not C-contiguous.
    """

    __slots__ = ("_at", "_code", "_kernel", "_layout", "_values", "words")

    def __init__(self, code, *values):
        self._code = code
        self._layout = code.layout
        self._values = list(values)  # keeps the arrays alive
        self.words = array("q", _words(self._layout.values(), values))
        self._at = self.words.buffer_info()[0]
        self._kernel: Any = KERNEL(code.address)

    def __setitem__(self, name, value):
        argument = self._layout[name]
        if self._values[argument.index] is not value:
            words = array("q", _words((argument,), (value,)))
            self.words[argument.at : argument.at + len(words)] = words
            self._values[argument.index] = value

    def place(self, name):
        """The index in `words` of an argument: an address, and behind it the shape of an array.

        Whoever writes there sees to the type of the array, and keeps it alive.
        """
        return self._layout[name].at

    def __call__(self):
        status = self._kernel(self._at)
        if status == FAILED:
            raise MemoryError("a kernel had no memory left")
        return status
