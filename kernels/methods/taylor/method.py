"""Taylor: facts, first step and interpolant; the compiled series fills the rows of the work array.

`fastdyn/compile/taylor` makes the series and the loop over steps for each function.
"""

from ...jit.options import INLINED, INTERNAL, njit
from ...state.record import RUNNING, Y_OLD, K, Y
from ...state.series import HIGHEST, LOW, N_ROWS, SCALE
from ...stepping.first_step import plain
from ..method import method, with_complex_states


@njit(**INTERNAL)
def taylor(state, work, block, order, fsal_stage):
    """The start kernel: the derivative, and the size max |y| / max |y'| for the first step."""
    status = plain(state, work, block, order, fsal_stage)
    s, y, rate = state[0], 0.0, 0.0
    for i in range(work.shape[1]):
        y, rate = max(y, abs(work[Y, i])), max(rate, abs(work[K + fsal_stage, i]))
        work[LOW, i] = 0.0
    s.h = y / rate if rate > 0.0 and y > 0.0 else 1.0
    return status if status != RUNNING else RUNNING


@njit(**INLINED)
def dense_rows(rhs, t, h, work, block, d):
    """The series in the form of `output/dense_output.py`; 0 evaluations.

    Dividing by x moves the coefficients; dividing by x - 1 sums the coefficients above each.
    """
    n, x = work.shape[1], h / work[SCALE, 0]
    for i in range(n):
        power = 1.0
        for k in range(HIGHEST + 1):
            d[k, i] = work[K + k, i] * power
            power *= x
        for first in range(1, HIGHEST + 1, 2):
            for k in range(HIGHEST - 1, first - 1, -1):
                d[k, i] += d[k + 1, i]
            for k in range(first + 1, HIGHEST + 1):
                d[k, i] = -d[k, i]
        d[1, i] = work[Y, i] - work[Y_OLD, i]  # as exact as the end of the step
    return 0


def kernel(rhs, form):
    """Raise NotImplementedError: no loop serves all functions."""
    raise NotImplementedError("the loop of a Taylor series is made for its function")


TAYLOR = method(
    "Taylor", order=HIGHEST, error_order=HIGHEST, n_stages=1, n_rows=N_ROWS, fsal_stage=1,
    kernel=kernel, start=taylor, n_dense=HIGHEST, dense_rows=dense_rows, dense_order=HIGHEST,
    h_max_share=1.0, series=True,
)  # fmt: skip
TAYLOR = with_complex_states(TAYLOR, kernel, taylor)
