"""The types of what kernels take."""

from typing import Any

import numpy as np
from numba import from_dtype, typeof, types

from fastdyn.kernels.calls.user_function import WORDS
from fastdyn.kernels.output.arguments import OUTPUT, Kernels, Output
from fastdyn.kernels.output.events import EVENTS, Events
from fastdyn.kernels.output.invariants import INVARIANT, SURVEY, Bins
from fastdyn.kernels.state.record import STATE, Solve


def _records(dtype):
    return typeof(np.zeros(1, dtype))


def _named(cls, *fields) -> Any:
    return types.BaseTuple.from_types(fields, cls)


def type_of(sample) -> Any:
    """The type of an argument like this one; arrays are C-contiguous, as `Call` makes sure."""
    if isinstance(sample, tuple):
        return _named(type(sample), *map(type_of, sample))
    if isinstance(sample, np.ndarray):
        return types.Array(from_dtype(sample.dtype), sample.ndim, "C")
    return typeof(sample)


ROWS = types.Array(types.float64, 1, "C")
TABLE = types.Array(types.float64, 2, "C")
CUBE = types.Array(types.float64, 3, "C")
INTEGERS = types.Array(types.int64, 1, "C")
STATES, OUTPUTS, EVENT_TABLE = _records(STATE), _records(OUTPUT), _records(EVENTS)
ADVANCE = types.int64(STATES, TABLE, WORDS, types.int64)
START = types.int64(STATES, TABLE, WORDS, types.float64, types.int64)
OPEN = types.int64(EVENT_TABLE, types.float64, ROWS, ROWS)
STUDIED, SURVEYED = _records(INVARIANT), _records(SURVEY)
OPEN_SURVEY = types.int64(STUDIED, types.float64, ROWS, ROWS)
ENRICH = types.int64(types.float64, types.float64, TABLE, WORDS, TABLE)
SOLVE = _named(Solve, STATES, TABLE, WORDS)
OUTPUT_TYPE = _named(Output, OUTPUTS, ROWS, TABLE, CUBE, TABLE, ROWS, TABLE)
EVENTS_TYPE = _named(Events, EVENT_TABLE, INTEGERS, ROWS, TABLE)
WATCH = types.int64(
    _named(Kernels, *[types.int64] * 4),
    SOLVE,
    OUTPUT_TYPE,
    EVENTS_TYPE,
    TABLE,
    types.int64,
)
SURVEYING = types.int64(
    types.int64, SOLVE, SURVEYED, STUDIED, _named(Bins, ROWS, CUBE, ROWS, TABLE), ROWS, types.int64
)
