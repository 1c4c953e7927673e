"""The arrays in the room of a series, and the rows of the work array: see `description.py`."""

from ...calls.block import RAISED_WORD
from ...calls.user_function import address_of, call_function
from ...jit.options import INLINED, INTERNAL, njit
from ...state.layout import Form
from ...state.record import ATOL, RTOL, STAGE, Y_OLD, K, Y
from ...state.rows import keep_vector, numbers_of, slot, vector_at
from ...state.series import LOW
from .description import (
    ABSOLUTE,
    ARRAYS,
    BEFORE,
    GIVEN,
    LOW_NOW,
    N_VECTORS,
    NOW,
    RELATIVE,
    STRIDE,
    TABLES,
    WIDTH,
)

LANES = Form(1, 4)  # the vectors of one trajectory: `compile/taylor/kernel.py`


@njit(**INLINED)
def array(words, name):
    """The place of an array."""
    return words[ARRAYS] + name * words[N_VECTORS] * words[WIDTH]


@njit(**INLINED)
def place_of(words, name, u):
    """The place of a vector of an array; the state NOW is order 0 of the series."""
    return words[TABLES + u] if name == NOW else array(words, name) + u * words[WIDTH]


@njit(**INTERNAL)
def enter(room, words, work):
    """Copy state, rounding error and tolerances from the rows of `work`."""
    n = words[N_VECTORS]
    width = words[WIDTH]
    for u in range(n):
        for lane in range(width):
            i = words[TABLES + n + u * width + lane]
            at = words[ARRAYS] + u * width + lane
            if i >= 0:
                room[words[TABLES + u] + lane] = work[Y, i]
                room[at + LOW_NOW * n * width] = work[LOW, i]
                room[at + RELATIVE * n * width] = work[RTOL, i]
                room[at + ABSOLUTE * n * width] = work[ATOL, i]


@njit(**INTERNAL)
def leave(room, words, work, order, moved):
    """Copy the state into the rows of `work`; if a step was taken, its series and start, too.

    The rows of higher orders stay zero.
    """
    n = words[N_VECTORS]
    width = words[WIDTH]
    stride = words[STRIDE]
    numbers = numbers_of(work)
    m = work.shape[1]
    for u in range(n):
        first = words[TABLES + n + u * width]
        place = words[TABLES + u]
        in_order = moved and first >= 0
        for lane in range(1, width):
            in_order = in_order and words[TABLES + n + u * width + lane] == first + lane
        if in_order:
            for k in range(1, order + 1):
                c = vector_at(LANES, room, place + k * stride)
                keep_vector(LANES, numbers, (K + k) * m + first, c)
        for lane in range(width):
            i = words[TABLES + n + u * width + lane]
            at = words[ARRAYS] + u * width + lane
            place = words[TABLES + u] + lane
            before = at + BEFORE * n * width if moved else place
            if i >= 0:
                work[Y, i], work[Y_OLD, i] = room[place], room[before]
                work[LOW, i] = room[at + LOW_NOW * n * width]
            if i >= 0 and moved:
                work[K, i] = room[before]
                if not in_order:
                    for k in range(1, order + 1):
                        work[K + k, i] = room[place + k * stride]


@njit(**INTERNAL)
def asked(block, t, room, words, work, name):
    """Call the function at a state; whether the function raises.  The derivative goes to GIVEN."""
    n = words[N_VECTORS]
    width = words[WIDTH]
    for u in range(n):
        for lane in range(width):
            i = words[TABLES + n + u * width + lane]
            if i >= 0:
                work[Y, i] = room[place_of(words, name, u) + lane]
    call_function(address_of(block), t, slot(None, work, Y), slot(None, work, STAGE))
    for u in range(n):
        for lane in range(width):
            i = words[TABLES + n + u * width + lane]
            if i >= 0:
                room[array(words, GIVEN) + u * width + lane] = work[STAGE, i]
    return block[RAISED_WORD] != 0


@njit(**INTERNAL)
def copy(room, words, source, target):
    """Copy an array."""
    for u in range(words[N_VECTORS]):
        for lane in range(words[WIDTH]):
            room[place_of(words, target, u) + lane] = room[place_of(words, source, u) + lane]
