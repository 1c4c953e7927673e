"""The arrays in the room of a series, and the rows of the work array: see `description.py`."""

from ...calls.block import RAISED_WORD
from ...calls.user_function import address_of, call_function
from ...jit_options import INLINED, INTERNAL, njit
from ...state.record import STAGE, Y_OLD, K, Y
from ...state.rows import slot
from ...state.series import HIGHEST
from .description import ARRAYS, BEFORE, GIVEN, N_VECTORS, NOW, STRIDE, TABLES, WIDTH


@njit(**INLINED)
def array(words, name):
    """The place of an array."""
    return words[ARRAYS] + name * words[N_VECTORS] * words[WIDTH]


@njit(**INLINED)
def place_of(words, name, u):
    """The place of a vector of an array; the state NOW is order 0 of the series."""
    return words[TABLES + u] if name == NOW else array(words, name) + u * words[WIDTH]


@njit(**INTERNAL)
def read(work, row, room, words, name):
    """Copy a row of `work` into an array."""
    lanes = TABLES + words[N_VECTORS]
    for u in range(words[N_VECTORS]):
        place = place_of(words, name, u)
        for lane in range(words[WIDTH]):
            i = words[lanes + u * words[WIDTH] + lane]
            room[place + lane] = work[row, i] if i >= 0 else 0.0


@njit(**INTERNAL)
def write(room, words, name, work, row):
    """Copy an array into a row of `work`."""
    lanes = TABLES + words[N_VECTORS]
    for u in range(words[N_VECTORS]):
        place = place_of(words, name, u)
        for lane in range(words[WIDTH]):
            i = words[lanes + u * words[WIDTH] + lane]
            if i >= 0:
                work[row, i] = room[place + lane]


@njit(**INTERNAL)
def write_series(room, words, work, order):
    """Copy the series from the state BEFORE into rows of `work`."""
    write(room, words, BEFORE, work, Y_OLD)
    write(room, words, BEFORE, work, K)
    lanes = TABLES + words[N_VECTORS]
    for u in range(words[N_VECTORS]):
        for lane in range(words[WIDTH]):
            i, place = words[lanes + u * words[WIDTH] + lane], words[TABLES + u] + lane
            if i >= 0:
                for k in range(1, order + 1):
                    work[K + k, i] = room[place + k * words[STRIDE]]
                for k in range(order + 1, HIGHEST + 1):
                    work[K + k, i] = 0.0


@njit(**INTERNAL)
def asked(block, t, room, words, work, name):
    """Call the function at a state; whether the function raises.  The derivative goes to GIVEN."""
    write(room, words, name, work, Y)
    call_function(address_of(block), t, slot(None, work, Y), slot(None, work, STAGE))
    read(work, STAGE, room, words, GIVEN)
    return block[RAISED_WORD] != 0


@njit(**INTERNAL)
def copy(room, words, source, target):
    """Copy an array."""
    for u in range(words[N_VECTORS]):
        for lane in range(words[WIDTH]):
            room[place_of(words, target, u) + lane] = room[place_of(words, source, u) + lane]
