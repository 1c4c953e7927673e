"""The types of what kernels take."""

import numpy as np
from numba import typeof, types

from fastdyn.kernels.calls.user_function import WORDS
from fastdyn.kernels.output.events import EVENTS
from fastdyn.kernels.output.invariants import INVARIANT, SURVEY
from fastdyn.kernels.output.sampling import OUTPUT
from fastdyn.kernels.state.record import STATE


def _records(dtype):
    return typeof(np.zeros(1, dtype))


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


SURVEYING = types.int64(
    types.int64, STATES, TABLE, WORDS, SURVEYED, STUDIED, ROWS, CUBE, ROWS, TABLE, ROWS, types.int64
)


ENRICH = types.int64(types.float64, types.float64, TABLE, WORDS, TABLE)


WATCH = types.int64(
    types.int64, types.int64, types.int64, STATES, TABLE, WORDS,
    OUTPUTS, ROWS, TABLE, CUBE, TABLE, ROWS, TABLE, types.int64,
    EVENT_TABLE, INTEGERS, ROWS, TABLE, TABLE, types.int64,
)  # fmt: skip
