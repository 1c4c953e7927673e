"""The past of LSODA: the Nordsieck array h^j y^(j) / j!, its rows, norms, and interpolant.

K. Radhakrishnan and A. C. Hindmarsh, "Description and use of LSODE", NASA RP-1327 (1993).
"""

from ...jit.options import INLINED, INTERNAL, njit
from ...output.dense_output import F as DENSE
from ...output.dense_output import nest
from ...state.record import Y_OLD, K, Y
from .table import HIGHEST

# Rows: a row whose first number is the order of the interpolant, negative if it is not the order of
# the last step; the derivative; the Nordsieck array;
# the correction of the last step, the correction of an earlier step; the state of an iteration and
# its derivative; 1 / tolerance; factors of differences and two rows of work space; pivots.
ORDER = K
SLOPE = K + 1
Z = K + 2
CHANGE, KEPT, RATE, TRIAL, WEIGHT, FACTOR, FOUND = (K + 15 + i for i in range(7))
PIVOTS = K + 23
N_ROWS = 24
J = K + N_ROWS  # the first row of the Jacobian; the factors of I - h l0 J lie behind the Jacobian


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
    """Advance the Nordsieck array by one step, by Pascal's triangle."""
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
    """Change the Nordsieck array to steps that are longer by a factor."""
    power = 1.0
    for j in range(1, order + 1):
        power *= factor
        for i in range(work.shape[1]):
            work[Z + j, i] *= power


@njit(**INLINED)
def dense_rows(rhs, t, h, work, block, d):
    """The polynomial of the last step, in the form of `dense_output.py`; 0 evaluations.

    The Nordsieck array has the coefficients of the powers of x - 1, with x = (t - t_old) / h.  The
    polynomial passes through the states at both ends of the step, if it has the order of the step.
    """
    given = int(work[ORDER, 0])
    last = HIGHEST[0]
    n = work.shape[1]
    order = abs(given)
    for j in range(last + 1):
        for i in range(n):
            d[j, i] = work[Z + j, i] if j <= order else 0.0
    nest(d, order)
    if given > 0:
        for i in range(n):
            d[0, i], d[DENSE, i] = work[Y_OLD, i], work[Y, i] - work[Y_OLD, i]
    return 0
