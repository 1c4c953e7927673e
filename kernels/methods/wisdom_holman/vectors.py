"""Vectors of some planets at once: the rows of x, y and z, and sums of their columns."""

from ...jit.options import INLINED, njit
from ...state.rows import keep_vector, vector_at
from .kepler import FORM


@njit(**INLINED)
def three(row, i, p):
    """The three components of planets i, i + 1, ... as vectors."""
    return vector_at(FORM, row, i), vector_at(FORM, row, p + i), vector_at(FORM, row, 2 * p + i)


@njit(**INLINED)
def keep_three(row, i, p, x, y, z):
    keep_vector(FORM, row, i, x)
    keep_vector(FORM, row, p + i, y)
    keep_vector(FORM, row, 2 * p + i, z)


@njit(**INLINED)
def combined(matrix, row, columns, i, p):
    """Planets i, i + 1, ... of a matrix times vectors, from the first to the last of `columns`."""
    x, y, z = three(row, i, p)
    x = 0.0 * x
    y = 0.0 * y
    z = 0.0 * z
    for j in range(*columns):
        c = vector_at(FORM, matrix, j * p + i)
        x = x + c * row[j]
        y = y + c * row[p + j]
        z = z + c * row[2 * p + j]
    return x, y, z
