"""The past of BDF: backward differences, their size, and the polynomial through the last values.

L. F. Shampine and M. W. Reichelt, "The MATLAB ODE suite", SIAM J. Sci. Comput. 18 (1997).
"""

import math

import numpy as np

from ...jit.options import INLINED, INTERNAL, njit
from ...output.dense_output import F as DENSE
from ...state.record import K
from ...state.rows import scratch

MAX_ORDER = 5
KAPPA = np.array([0, -0.1850, -1 / 9, -0.0823, -0.0415, 0])
GAMMA = np.array([math.fsum(1 / j for j in range(1, k + 1)) for k in range(MAX_ORDER + 1)])
ALPHA = (1 - KAPPA) * GAMMA
ERROR = KAPPA * GAMMA + 1 / np.arange(1, MAX_ORDER + 2)
# Rows F1 to F4 of the interpolant from D[2] to D[5]; see `dense_output.py`.
POLYNOMIAL = np.array(
    [
        [-1 / 2, -1 / 6, -2 / 24, -6 / 120],
        [0, -1 / 6, -4 / 24, -18 / 120],
        [0, 0, 1 / 24, 7 / 120],
        [0, 0, 0, 1 / 120],
    ]
)

# Rows: a row whose first number is the order of the last step, and the differences.
ORDER = K
D = K + 2
SIZE = MAX_ORDER + 1
matrix = scratch(SIZE * SIZE)


@njit(**INTERNAL)
def change_size(work, order, factor):
    """Change the differences D to steps that are longer by a factor.

    The new differences are V^T D with V = R U.  R[j, i] = prod_{m <= j} (m - 1 - factor i) / m has
    the values of the polynomial at the new places; U is R for a factor of 1.
    """
    v = matrix()
    for k in range(order + 1):
        for j in range(order + 1):
            total, sign = 0.0, 1.0  # sign: U[i, k] = (-1)^i binomial(k, i)
            for i in range(k + 1):
                value = 1.0
                for m in range(1, j + 1):
                    value *= (m - 1 - factor * i) / m
                total += value * sign
                sign *= (i - k) / (i + 1)
            v[j * SIZE + k] = total if j > 0 or k == 0 else 0.0
    for c in range(work.shape[1]):
        for k in range(order + 1):
            total = 0.0
            for j in range(k, order + 1):  # differences of a lower order do not count
                total += v[j * SIZE + k] * work[D + j, c]
            work[D + k, c] = total


@njit(**INLINED)
def dense_rows(rhs, t, h, work, block, d):
    """The polynomial through the last values, in the form of `dense_output.py`; 0 evaluations."""
    order = int(work[ORDER, 0])
    for i in range(work.shape[1]):
        for r in range(4):
            total = 0.0
            for j in range(2, order + 1):
                total += POLYNOMIAL[r, j - 2] * work[D + j, i]
            d[DENSE + 1 + r, i] = total
    return 0
