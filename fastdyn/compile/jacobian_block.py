"""Jacobians as kernels take them: a matrix that stays the same, or exact ones of traced functions.

See `kernels/calls/block.py` for the words.
"""

import hashlib

import numpy as np

from fastdyn.kernels.calls.block import FIRST, N_ENTRIES
from fastdyn.trace.refusal import Untraceable

from .function import Function
from .jacobian import jacobian

CONSTANT = "constant"  # the mode of what is a matrix, and no function


def constant_function(matrix):
    """What `bind` puts in place of a compiled function: it names the numbers."""
    digest = hashlib.sha256(matrix.tobytes()).hexdigest()
    return Function(f"constant {digest}", 0, 0, None, matrix, CONSTANT, seconds=0.0)


def constant_block(matrix):
    """The block of a constant Jacobian."""
    block = np.zeros(FIRST + matrix.size, np.int64)
    block[FIRST:] = np.ascontiguousarray(matrix).view(np.int64).reshape(-1)
    return block


def exact_block(function, n, time=False):
    """The block of the exact Jacobian of a compiled function of n numbers; None if there is none.

    It has the places of the entries, column by column, where others have parameters.  With `time`
    its function gives df/dt behind the entries.
    """
    if function is None or function.traced is None or function.traced.n != n:
        return None
    try:
        found = jacobian(function, time)
    except Untraceable:
        return None
    if found is None or len(found.rows) == 0 or len(function.traced.stored) != n:
        return None
    block = np.zeros(FIRST + len(found.rows), np.int64)
    block[0], block[N_ENTRIES] = found.address, len(found.rows)
    block[FIRST:] = found.columns * n + found.rows
    return block
