"""The checks that a later call applies to the objects that a traced function reads."""

import operator
from typing import Any

import numpy as np

from ..written import function_of
from . import table_reads

MISSING = object()
FLOATS = {float, np.float64, np.float32, np.float16, np.longdouble}
INEXACT = FLOATS | {complex, np.complex128, np.complex64}
NESTED = INEXACT - FLOATS | {tuple, set, frozenset, slice}


def _equal(value, expected):
    """Whether two constants are equal, also in types of their parts and in signs of zeros."""
    if type(value) is not type(expected) or value != expected:
        return False
    return value is expected or _unseen(value) == _unseen(expected)


def _unseen(value):
    """The properties of a constant that == does not compare: 1 == 1.0 == True, and 0.0 == -0.0."""
    if isinstance(value, set | frozenset):
        return frozenset((each, _unseen(each)) for each in value)
    if isinstance(value, slice):
        value = value.start, value.stop, value.step
    if isinstance(value, tuple):
        kinds = tuple(map(type, value))
        if NESTED.isdisjoint(kinds) and (FLOATS.isdisjoint(kinds) or 0.0 not in value):
            return type(value), kinds  # 0.5 ms for 10 000 labels of a table
        return type(value), tuple(map(_unseen, value))
    return type(value), repr(value) if type(value) in INEXACT else None


def _has_keys(value, expected):
    """Whether a dict of a type has the expected keys, in order."""
    kind, keys = expected
    found = list(value)
    if type(value) is not kind or found != keys:
        return False
    return all(map(operator.is_, found, keys)) or _unseen(tuple(found)) == _unseen(tuple(keys))


def laid(value):
    """(shape, strides) of an array, by which a later array must lie in memory; None for a row."""
    return value.shape, value.strides if value.ndim > 1 else None


# Checks that one expression says; `compile.traced.reader` writes the expressions out.
WRITTEN = {
    "same": "{value} is {expected}",
    "number": "type({value}) is {expected}",
    "type": "type({value}) is {expected}",
}
CHECKS: dict[str, Any] = {
    name: function_of(
        f"def check(value, expected): return {text.format(value='value', expected='expected')}",
        "check",
        name,
        {},
    )
    for name, text in WRITTEN.items()
} | {
    "equal": _equal,
    "array": lambda value, expected: (
        type(value) is np.ndarray
        and value.shape == expected[0]
        and value.dtype == float
        and (expected[1] is None or value.strides == expected[1])
    ),
    "complex array": lambda value, expected: (
        type(value) is np.ndarray and value.dtype == complex and laid(value) == expected
    ),
    "real values": lambda value, expected: (
        CHECKS["complex array"](value, expected) and not value.imag.any()
    ),
    "size": lambda cls, expected: len(vars(cls)) == expected,
    "absent": lambda value, _: value is MISSING,
    "code": lambda value, expected: (
        getattr(value, "__code__", None) is expected[0]
        and value.__globals__ is expected[1]
        and (len(value.__defaults__ or ()), len(value.__kwdefaults__ or ())) == expected[2:]
    ),
    "length": lambda value, expected: type(value) is expected[0] and len(value) == expected[1],
    "keys": _has_keys,
    **table_reads.CHECKS,
}
