"""Parameters of compiled code: the type of a Python value, and its words in a block.

Machine code depends on the type of a value (`parameter_type`): "a float", "a C-contiguous array of
int64 with 2 dimensions", "the constant None".  The type of a number or array does not contain the
value, so that a new value needs no new code.
"""

import types as python
from typing import Any

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.kernels.calls.block import FIRST

from .callables.jitted import is_jitted
from .fingerprint import Constant, frozen

ARRAYS = ("array", "list")
ARRAY_DTYPES = {"f8", "f4", "i8", "i4", "b1", "c16"}
FLOAT, INT, BOOL, COMPLEX = ("float",), ("int",), ("bool",), ("complex",)
CODES = {FLOAT: "d", INT: "q"}  # of `struct`


def is_function(value):
    """Whether a value is a Python function or an `@njit` function."""
    return isinstance(value, python.FunctionType) or is_jitted(value)


def parameter_type(value):
    """The type of a parameter.

    Returns
    -------
    tuple or Constant
        FLOAT, INT, BOOL, COMPLEX, ("array", dtype, ndim), ("tuple", types), ("lanes", width) or
        a Constant.  ("list", dtype, 1) is the type of a list, which is copied.
    """
    cls = value.__class__
    if cls is float:
        return FLOAT
    if cls is int:
        return INT if -(2**63) <= value < 2**63 else _constant(value)
    if cls is bool or isinstance(value, np.bool_):
        return BOOL
    if cls is np.ndarray:
        return _array_type(value)
    if isinstance(value, np.generic | float | int | complex):
        code = np.asarray(value).dtype.kind
        return {"f": FLOAT, "i": INT, "u": INT, "c": COMPLEX}.get(code) or _constant(value)
    if cls is tuple:
        return ("tuple", tuple(map(parameter_type, value)))
    if cls is list and value and not any(isinstance(v, list | tuple | str) for v in value):
        found = _array_type(np.asarray(value))
        return ("list", *found[1:]) if found[0] == "array" else _constant(value)
    return _constant(value)


def _constant(value):
    return Constant(frozen(value), value)


def _array_type(value):
    if value.ndim == 0 and value.dtype.kind == "f":
        return FLOAT
    code = value.dtype.str[1:]
    if value.ndim == 0 or code not in ARRAY_DTYPES or not value.dtype.isnative:
        return _constant(value)
    return ("array", code, value.ndim)


def n_words(parameter_type: Any) -> int:
    """The number of words that a value of this type takes in a block."""
    if isinstance(parameter_type, Constant):
        return 0
    if parameter_type[0] in ARRAYS:
        return 1 + parameter_type[2]
    if parameter_type[0] == "tuple":
        return sum([n_words(k) for k in parameter_type[1]])
    if parameter_type[0] == "lanes":
        return parameter_type[1]
    return 2 if parameter_type == COMPLEX else 1


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
    elif name == "tuple":
        for k, v in zip(parameter_type[1], value, strict=True):
            at = pack(k, v, words, floats, at, keepalive)
        return at
    elif name in ARRAYS:
        array = np.ascontiguousarray(value)
        keepalive.append(array)
        words[at] = address_of(array)
        words[at + 1 : at + 1 + parameter_type[2]] = array.shape
        return at + 1 + parameter_type[2]
    elif name == "lanes":
        return at + parameter_type[1]
    elif name == "complex":
        floats[at : at + 2] = value.real, value.imag
        return at + 2
    else:
        words[at] = value
    return at + 1


def pack_all(parameters, block, keepalive):
    """Write all parameters, given as (type, value), into a block."""
    at, floats = FIRST, block.view(np.float64)
    for k, value in parameters:
        at = pack(k, value, block, floats, at, keepalive)
