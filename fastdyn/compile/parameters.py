"""Parameters of compiled code: the type of a Python value, and its words in a block.

Machine code depends on the type of a value (`parameter_type`): "a float", "a C-contiguous array of
int64 with 2 dimensions", "the constant None".  The type of a number or array does not contain the
value, so that a new value needs no new code.
"""

from typing import Any

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.kernels.calls.block import FIRST

from .callables import Uncompilable
from .fingerprint import Constant, Unknown, frozen

ARRAY_DTYPES = {"f8", "f4", "i8", "i4", "b1", "c16"}
FLOAT = ("float",)
INT = ("int",)
KINDS = {"f": FLOAT, "i": INT, "u": INT}  # of NumPy's dtypes


def parameter_type(value):
    """The type of a parameter of code that Numba makes.

    Returns
    -------
    tuple or Constant
        FLOAT, INT, ("array", dtype, ndim), or a Constant.  Traces also have
        ("lanes", width).

    Raises
    ------
    Uncompilable
        If compiled code cannot hold the value.
    """
    if isinstance(value, np.ndarray):
        code = value.dtype.str[1:]
        if (
            type(value) is np.ndarray
            and value.ndim
            and code in ARRAY_DTYPES
            and value.dtype.isnative
        ):
            return ("array", code, value.ndim)
    elif type(value) in (int, float) or isinstance(value, np.generic):
        kind = KINDS.get(np.asarray(value).dtype.kind)
        if kind:
            return kind
    try:
        return Constant(frozen(value), value)
    except Unknown as reason:
        raise Uncompilable(f"an argument is {reason}") from None


def n_words(parameter_type: Any) -> int:
    """The number of words that a value of this type takes in a block."""
    if isinstance(parameter_type, Constant):
        return 0
    if parameter_type[0] == "array":
        return 1 + parameter_type[2]
    return parameter_type[1] if parameter_type[0] == "lanes" else 1


def pack(parameter_type, value, words, floats, at, keepalive):
    """Write a value into `words` from index `at` on; return the next index.

    `floats` is a view of `words`.  `keepalive` collects the memory that the words point to;
    `keepalive` must live as long as the words.  A contiguous array is passed in place, so that the
    function sees later changes.
    """
    if isinstance(parameter_type, Constant):
        return at
    name = parameter_type[0]
    if name == "float":
        floats[at] = value
    elif name == "array":
        array = np.ascontiguousarray(value)
        keepalive.append(array)
        words[at] = address_of(array)
        words[at + 1 : at + 1 + parameter_type[2]] = array.shape
        return at + 1 + parameter_type[2]
    elif name == "lanes":
        return at + parameter_type[1]
    else:
        words[at] = value
    return at + 1


def pack_all(parameters, block, keepalive):
    """Write all parameters, given as (type, value), into a block."""
    at = FIRST
    floats = block.view(np.float64)
    for k, value in parameters:
        at = pack(k, value, block, floats, at, keepalive)
