"""The arrays in the room of a series, and the rows of the work array: see `description.py`."""

from ...calls.block import RAISED_WORD
from ...calls.user_function import address_of, call_function
from ...jit_options import INLINED, INTERNAL, njit
from ...state.record import STAGE, Y_OLD, K, Y
from ...state.rows import slot
from ...state.series import HIGHEST
from .description import ARRAYS, GIVEN, N_VECTORS, STRIDE, TABLES, WIDTH


@njit(**INLINED)
def array(words, name):
    """The place of an array."""
    return words[ARRAYS] + name * words[N_VECTORS] * words[WIDTH]


@njit(**INTERNAL)
def read(work, row, room, words, name):
    """Copy a row of `work` into an array."""
    for lane in range(words[N_VECTORS] * words[WIDTH]):
        i = words[TABLES + words[N_VECTORS] + lane]
        room[array(words, name) + lane] = work[row, i] if i >= 0 else 0.0


@njit(**INTERNAL)
def write(room, words, name, work, row):
    """Copy an array into a row of `work`."""
    for lane in range(words[N_VECTORS] * words[WIDTH]):
        i = words[TABLES + words[N_VECTORS] + lane]
        if i >= 0:
            work[row, i] = room[array(words, name) + lane]


@njit(**INTERNAL)
def write_series(room, words, work, order):
    """Copy all coefficients into rows of `work`."""
    n, width, stride = words[N_VECTORS], words[WIDTH], words[STRIDE]
    for lane in range(n * width):
        i, place = words[TABLES + n + lane], words[TABLES + lane // width] + lane % width
        if i >= 0:
            work[Y_OLD, i] = room[place]
            for k in range(HIGHEST + 1):
                work[K + k, i] = room[place + k * stride] if k <= order else 0.0


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
    for i in range(words[N_VECTORS] * words[WIDTH]):
        room[array(words, target) + i] = room[array(words, source) + i]
