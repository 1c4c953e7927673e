"""Norms and starts of methods on complex states, which are stored as pairs of real numbers.

Steps and interpolants of real states serve complex states, too.  The error of a component is
measured as a complex number, as in SciPy.
"""

import numpy as np

from ..jit.options import INTERNAL, njit
from ..state.record import ATOL, RTOL, Y
from ..stepping.first_step import forget, make_hairer
from ..stepping.step_size import Norm, larger


@njit(**INTERNAL)
def sum_of_squares_of_pairs(error, y, y_new, rtol, atol):
    """Sum of |error|^2 / (atol + rtol max(|y|, |y_new|))^2 over the complex components."""
    total = 0.0
    for i in range(0, len(error), 2):
        before = np.hypot(y[i], y[i + 1])
        after = np.hypot(y_new[i], y_new[i + 1])
        scale = atol[i] + larger(before, after) * rtol[i]
        real = error[i] / scale
        imag = error[i + 1] / scale
        total += real * real + imag * imag
    return total


@njit(**INTERNAL)
def rms_of_pairs(error, y, y_new, rtol, atol):
    """Root mean square of the error over its tolerance."""
    return np.sqrt(sum_of_squares_of_pairs(error, y, y_new, rtol, atol) / (len(error) // 2))


OF_PAIRS = Norm(rms_of_pairs, sum_of_squares_of_pairs, 2)


@njit(**INTERNAL)
def _scaled_rms_of_pairs(values, work):
    total = 0.0
    for i in range(0, len(values), 2):
        scale = work[ATOL, i] + np.hypot(work[Y, i], work[Y, i + 1]) * work[RTOL, i]
        real = values[i] / scale
        imag = values[i + 1] / scale
        total += real * real + imag * imag
    return np.sqrt(total / (len(values) // 2))


hairer_of_pairs = make_hairer("hairer_of_pairs", _scaled_rms_of_pairs)
hairer_of_pairs.py_func.__module__ = __name__  # where the key of the kernel looks for its sources


@njit(**INTERNAL)
def implicit_of_pairs(state, work, block, order, fsal_stage):
    """`hairer_of_pairs`, for a method that factorises matrices."""
    forget(state[0], 1)
    return hairer_of_pairs(state, work, block, order, fsal_stage)
