"""The types of the arguments of kernels, from samples."""

from typing import Any

import numpy as np
from numba import from_dtype, typeof, types

from fastdyn.kernels.calls.user_function import FORM
from fastdyn.kernels.output.arguments import (
    EVENTS,
    OUTPUT,
    SCHEDULES,
    Begin,
    Events,
    Kernels,
    Launch,
    Output,
)
from fastdyn.kernels.output.invariants import INVARIANT, SURVEY, Bins
from fastdyn.kernels.state.record import STATE, Solve


def type_of(sample) -> Any:
    """The type of an argument like the sample; arrays are C-contiguous, as `Call` checks."""
    if isinstance(sample, tuple):
        return types.BaseTuple.from_types([type_of(field) for field in sample], type(sample))
    if isinstance(sample, np.ndarray):
        return types.Array(from_dtype(sample.dtype), sample.ndim, "C")
    return typeof(sample)


def kernel_of(*samples):
    """The signature of a kernel with arguments like the samples; the result is a status."""
    return types.int64(*map(type_of, samples))


ROW = np.empty(0)
TABLE = np.empty((0, 0))
CUBE = np.empty((0, 0, 0))
WORDS = np.empty(0, np.int64)
PAIRS = np.empty((0, 0), np.int64)
STATES = np.empty(0, STATE)
EVENT_TABLE = np.empty(0, EVENTS)
OUTPUTS = np.empty(0, OUTPUT)
STUDIED = np.empty(0, INVARIANT)
SOLVE = Solve(STATES, TABLE, WORDS)
KERNELS = Kernels(0, 0, 0, 0, 0, 0.0, 0, 0, 0, 0)

FUNCTION = types.none(*FORM)  # the form of a user's function
ADVANCE = kernel_of(*SOLVE, 0)
FILTER = kernel_of(*SOLVE, 0.0, TABLE)  # of residuals
SERIES = kernel_of(*SOLVE, 0, 0, ROW, WORDS)
SERIES_IN_LANES = kernel_of(STATES, TABLE, TABLE, WORDS, 0, 0, 0, ROW, WORDS)
ADVANCE_VECTORS = kernel_of(STATES, TABLE, TABLE, WORDS, 0)
START = kernel_of(*SOLVE, 0.0, 0)
OPEN = kernel_of(EVENT_TABLE, 0.0, ROW, ROW)
DENSE_ROWS = kernel_of(0.0, 0.0, TABLE, WORDS, TABLE)
FACTORS = kernel_of(ROW, ROW, 0)
SOLUTION = kernel_of(ROW, ROW, ROW, 0)
PAST = kernel_of(ROW, 0, 0.0, 0.0, 0, 0, ROW)
EVALUATE = kernel_of(WORDS, 0.0, ROW, ROW)
WATCHING = (
    KERNELS,
    SOLVE,
    Output(OUTPUTS, ROW, TABLE, CUBE, TABLE, ROW, TABLE, TABLE, ROW, ROW, STATES),
    Events(EVENT_TABLE, np.empty(0, SCHEDULES), WORDS, ROW, TABLE),
    TABLE,
    0,
)
WATCH = kernel_of(*WATCHING)
FIND = kernel_of(*WATCHING[:-1], 0.0, 0, 0, TABLE)
LAUNCH = kernel_of(Launch(0, 0, 0, 0, WORDS, PAIRS))
IN_MATRICES = STATES, TABLE, WORDS, 0, 0, 0
OTHER_JACOBIAN = kernel_of(STATES, 0.0, TABLE, 0, 0, WORDS, 0, 0)
OTHER_FACTORS = kernel_of(*IN_MATRICES, 0.0, 0.0)
OTHER_COMPLEX_FACTORS = kernel_of(*IN_MATRICES, 0.0, 0.0, 0.0)
OTHER_SOLUTION = kernel_of(*IN_MATRICES, 0, 0)
INTERPOLANT = kernel_of(KERNELS, SOLVE, TABLE)
WHOLE_SOLVE = kernel_of(Begin(0, 0, 0, ROW, 0), *WATCHING)
OPEN_SURVEY = kernel_of(STUDIED, 0.0, ROW, ROW)
SURVEYING = kernel_of(0, SOLVE, np.empty(0, SURVEY), STUDIED, Bins(ROW, CUBE, ROW, TABLE), ROW, 0)
