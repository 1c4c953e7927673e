"""Arrays of parameters as the tuple that a right-hand side takes, in compiled code."""

from numba import njit
from numba.cpython.unsafe.tuple import tuple_setitem


def to_tuple_of(m):
    """A compiled function from an array of m numbers to a tuple."""
    zeros = (0.0,) * m

    @njit
    def to_tuple(p):
        given = zeros
        for i in range(m):
            given = tuple_setitem(given, i, p[i])
        return given

    return to_tuple
