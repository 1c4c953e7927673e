"""Loops along columns, in whole vectors that begin at multiples of WIDTH.

So a vector is read as it was written: a load that overlaps two stores waits for both.
"""

import numpy as np

from ...jit.options import INLINED, INTERNAL, njit
from ...state.layout import Form
from ...state.rows import keep_vector, vector_at
from ...vector.scalar_or_vector import select
from . import storage

WIDTH = storage.WIDTH
leading = njit(**INTERNAL)(storage.leading)
FORM = Form(1, WIDTH)
LANES = np.arange(float(WIDTH))


@njit(**INLINED)
def block_of(i):
    """The first row of the vector that holds row i."""
    return i & -WIDTH


@njit(**INLINED)
def lanes_from(i):
    """The lanes from row i on, in the vector that holds row i."""
    return vector_at(FORM, LANES, 0) >= float(i & (WIDTH - 1))


@njit(**INLINED)
def subtract(y, a, first, end, factor):
    """y -= factor a for the rows from `first` to `end` - 1, and some behind."""
    if factor == 0.0:
        return
    at = block_of(first)
    change = select(lanes_from(first), vector_at(FORM, a, at) * factor, 0.0)
    keep_vector(FORM, y, at, vector_at(FORM, y, at) - change)
    for i in range(at + WIDTH, end, WIDTH):
        keep_vector(FORM, y, i, vector_at(FORM, y, i) - vector_at(FORM, a, i) * factor)
