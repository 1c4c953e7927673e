"""Taylor: facts, first step and interpolant; the compiled series fills the rows of the work array.

`fastdyn/compile/taylor` makes the series and the loop over steps for each function.
"""

from ...jit.options import INLINED, INTERNAL, njit
from ...output.dense_output import VECTOR, WIDTH
from ...state.layout import Form
from ...state.record import RUNNING, Y_OLD, K, Y
from ...state.rows import keep_vector, numbers_of, vector_at
from ...state.series import HIGHEST, LOW, N_ROWS, SCALE
from ...stepping.first_step import plain
from ..method import method, with_complex_states


@njit(**INTERNAL)
def taylor(state, work, block, order, fsal_stage):
    """The start kernel: the derivative, and the size max |y| / max |y'| for the first step."""
    status = plain(state, work, block, order, fsal_stage)
    s = state[0]
    y = 0.0
    rate = 0.0
    for i in range(work.shape[1]):
        y = max(y, abs(work[Y, i]))
        rate = max(rate, abs(work[K + fsal_stage, i]))
        work[LOW, i] = 0.0
    s.h = y / rate if rate > 0.0 and y > 0.0 else 1.0
    return status if status != RUNNING else RUNNING


def _divided(form):
    """``divide(series, numbers, i, n, order, x)``: the rows of `dense_rows` from component i on."""

    @njit(**INLINED)
    def divide(series, numbers, i, n, order, x):
        power = 1.0
        for k in range(order + 1):
            keep_vector(form, numbers, k * n + i, vector_at(form, series, (K + k) * n + i) * power)
            power *= x
        for first in range(1, order, 2):
            above = vector_at(form, numbers, order * n + i)
            for k in range(order - 1, first - 1, -1):
                above = vector_at(form, numbers, k * n + i) + above
                keep_vector(form, numbers, k * n + i, above)
        for k in range(2, order + 1):
            if k & 2:  # divided by 1 - x an odd number of times
                keep_vector(form, numbers, k * n + i, -vector_at(form, numbers, k * n + i))
        rise = vector_at(form, series, Y * n + i) - vector_at(form, series, Y_OLD * n + i)
        keep_vector(form, numbers, n + i, rise)  # as exact as the end of the step

    return divide


_vectors = _divided(VECTOR)
_numbers = _divided(Form(1, 1, exact=True))


@njit(**INLINED)
def dense_rows(rhs, t, h, work, block, d):
    """The series in the form of `output/dense_output.py`, in a row for each order; 0 evaluations.

    Dividing by x moves the coefficients; dividing by x - 1 sums the coefficients above each.  All
    orders of a few components at a time: their sums run side by side (40 components, order 17: 1.5
    us with the components innermost).
    """
    n = d.shape[1]
    order = d.shape[0] - 1
    x = h / work[SCALE, 0]
    series = numbers_of(work)
    numbers = numbers_of(d)
    whole = n - n % WIDTH
    for i in range(0, whole, WIDTH):
        _vectors(series, numbers, i, n, order, x)
    for i in range(whole, n):
        _numbers(series, numbers, i, n, order, x)
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
