"""The past of LSODA: the Nordsieck array h^j y^(j) / j!, its rows, norms, and interpolant.

K. Radhakrishnan and A. C. Hindmarsh, "Description and use of LSODE", NASA RP-1327 (1993).
"""

from ..jit_options import INLINED, INTERNAL, njit
from ..output.dense_output import F as DENSE
from ..output.dense_output import nest
from ..state.record import ATOL, RTOL, Y_OLD, K, Y
from .lsoda_table import HIGHEST

# Rows: the order of the last step in the first place of one, the derivative, the Nordsieck array,
# the correction of its step and of an earlier one, a derivative and the state where it is, one over
# tolerances, factors of differences and two rows for them, pivots.
ORDER, SLOPE, Z = K, K + 1, K + 2
CHANGE, KEPT, RATE, TRIAL, WEIGHT, FACTOR, FOUND = (K + 15 + i for i in range(7))
PIVOTS, N_ROWS = K + 23, 24
J = K + N_ROWS  # the Jacobian; behind it the factors of I - h l0 J


@njit(**INTERNAL)
def weigh(work):
    """Keep 1 / tolerance of each component at the state; False if a tolerance is 0."""
    for i in range(work.shape[1]):
        tolerance = work[RTOL, i] * abs(work[Y, i]) + work[ATOL, i]
        if not tolerance > 0.0:
            return False
        work[WEIGHT, i] = 1.0 / tolerance
    return True


@njit(**INTERNAL)
def norm(work, row):
    """The largest component of a row in units of its tolerance; NaN if a component is NaN."""
    largest = 0.0
    for i in range(work.shape[1]):
        x = abs(work[row, i]) * work[WEIGHT, i]
        if not x <= largest:
            if x != x:
                return x
            largest = x
    return largest


@njit(**INTERNAL)
def predict(work, order):
    """The Nordsieck array a step further: Pascal's triangle."""
    for k in range(order):
        for j in range(order - 1, k - 1, -1):
            for i in range(work.shape[1]):
                work[Z + j, i] += work[Z + j + 1, i]


@njit(**INTERNAL)
def retract(work, order):
    """Undo `predict`."""
    for k in range(order):
        for j in range(order - 1, k - 1, -1):
            for i in range(work.shape[1]):
                work[Z + j, i] -= work[Z + j + 1, i]


@njit(**INTERNAL)
def rescale(work, order, factor):
    """The Nordsieck array for steps that are longer by a factor."""
    power = 1.0
    for j in range(1, order + 1):
        power *= factor
        for i in range(work.shape[1]):
            work[Z + j, i] *= power


@njit(**INLINED)
def dense_rows(rhs, t, h, work, block, d):
    """The polynomial of the last step, in the form of `dense_output.py`; 0 evaluations.

    The Nordsieck array has the powers of x - 1, where x is the share of the step.  The first two
    rows are the states at the ends of the step, which the polynomial meets.
    """
    order, last, n = int(work[ORDER, 0]), HIGHEST[0], work.shape[1]
    for j in range(last + 1):
        for i in range(n):
            d[j, i] = work[Z + j, i] if j <= order else 0.0
    nest(d, order)
    for i in range(n):
        d[0, i], d[DENSE, i] = work[Y_OLD, i], work[Y, i] - work[Y_OLD, i]
    return 0
