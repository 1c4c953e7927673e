"""The checks that a later call applies to the objects that a traced function reads."""

from typing import Any

import numpy as np

from . import table_reads

MISSING = object()
CHECKS: dict[str, Any] = {
    "same": lambda value, expected: value is expected,
    "equal": lambda value, expected: type(value) is type(expected) and value == expected,
    "number": lambda value, expected: type(value) is expected,
    "array": lambda value, shape: (
        type(value) is np.ndarray and value.shape == shape and value.dtype == float
    ),
    "complex array": lambda value, shape: (
        type(value) is np.ndarray and value.shape == shape and value.dtype == complex
    ),
    "real values": lambda value, shape: (
        CHECKS["complex array"](value, shape) and not value.imag.any()
    ),
    "size": lambda cls, expected: len(vars(cls)) == expected,
    "absent": lambda value, _: value is MISSING,
    "type": lambda value, expected: type(value) is expected,
    "code": lambda value, expected: (
        getattr(value, "__code__", None) is expected[0]
        and value.__globals__ is expected[1]
        and (len(value.__defaults__ or ()), len(value.__kwdefaults__ or ())) == expected[2:]
    ),
    "length": lambda value, expected: type(value) is expected[0] and len(value) == expected[1],
    "keys": lambda value, expected: type(value) is expected[0] and list(value) == expected[1],
    **table_reads.CHECKS,
}
