"""The interpolant of a constant step of high order, from shorter steps of the same method.

A cubic between the ends of a step has order 3, and does not keep what a symplectic method keeps:
Kepler's orbit by SofroniouSpaletta10 has an energy error of 9e-16 at the steps, and of 1e-5 on the
cubics between.  So in a step that contains an output, the method takes m shorter steps from the
begin of the step, which are thrown away.  The interpolant is the polynomial of degree 3 + 2 m with
the states and the derivatives at their ends and at both ends of the step.

The ends of the shorter steps are the inner points of Lobatto's quadrature, where such polynomials
are good: P. Davis and P. Rabinowitz, "Methods of Numerical Integration", section 2.7.
"""

import numpy as np

from ..calls.block import RAISED_WORD
from ..jit.options import INTERNAL, njit
from ..output.dense_output import F, hermite
from ..state.elementwise import halves
from ..state.record import Y_OLD, K, Y
from ..state.rows import slot

OWN = 3  # rows of a method of kicks and drifts
ROWS = K + OWN  # of the shorter steps, behind those


def n_shorter(order):
    """The number m of shorter steps, so that the degree 3 + 2 m is not below the order."""
    return max(0, (order - 2) // 2)


def nodes_of(m):
    """The ends of the shorter steps, as shares of the step."""
    roots = np.polynomial.legendre.Legendre.basis(m + 1).deriv().roots().real
    return 0.5 + 0.5 * np.sort(roots)


def basis(m):
    """The factors of the rows F0, F1, ... of `output/dense_output.py` as polynomials of x."""
    x = np.polynomial.Polynomial([0.0, 1.0])
    found = [x]
    for i in range(1, 3 + 2 * m):
        found.append(found[-1] * (1.0 - x if i % 2 else x))
    return found


def weights(m):
    """The matrix from what the cubic lacks at the nodes, values and slopes in turn, to the rows."""
    rows = [
        [f(x) for f in fs]
        for x in nodes_of(m)
        for fs in (basis(m)[3:], [f.deriv() for f in basis(m)[3:]])
    ]
    return np.linalg.inv(np.array(rows).reshape(2 * m, 2 * m))


def of_data(m):
    """The matrix to the rows of `d` from the values and h times the slopes at the begin, the end
    and the nodes of a step, in turn.
    """
    matrix = np.zeros((4 + 2 * m, 4 + 2 * m))
    matrix[0, 0] = 1.0
    matrix[1, :4] = rise = np.array([-1.0, 0.0, 1.0, 0.0])
    matrix[2, :4] = [0.0, 1.0, 0.0, 0.0] - rise
    matrix[3, :4] = 2.0 * rise - [0.0, 1.0, 0.0, 1.0]
    factors = [np.polynomial.Polynomial([1.0]), *basis(m)[:3]]
    lacks = np.eye(4 + 2 * m)[4:]
    for k, x in enumerate(nodes_of(m)):
        lacks[2 * k] -= [f(x) for f in factors] @ matrix[:4]
        lacks[2 * k + 1] -= [f.deriv()(x) for f in factors] @ matrix[:4]
    matrix[4:] = weights(m) @ lacks
    return matrix


def write_dense_rows(name, make_step, velocity, n_stages, m):
    """The `dense_rows` of a method of kicks and drifts; `velocity` computes those of a pair."""
    nodes, matrix, last = nodes_of(m), weights(m), K + 1
    step = make_step(velocity)
    is_pair = velocity.__name__ != "itself"

    @njit(**INTERNAL)
    def dense_rows(rhs, t, h, work, block, d):
        short = work[K + OWN :]  # others may have rows behind
        y_old = slot(None, work, Y_OLD)
        slope = slot(None, work, K)
        nothing = slot(None, short, Y_OLD)
        if is_pair:  # no step needs the velocities at its ends
            for y, at, time in ((Y_OLD, K, t), (Y, last, t + h)):
                _, p = halves(slot(None, work, y))
                rate, _ = halves(slot(None, work, at))
                velocity(time, p, block, rate)
            hermite(h, 1, work, d)
        if m > 0:
            for i in range(d.shape[1]):
                short[Y_OLD, i] = 0.0  # the rounding errors of the sums
                for j in range(2 * m):
                    d[F + 3 + j, i] = 0.0
        for k in range(m):
            x = nodes[k]
            step(rhs, t, y_old, x * h, slope, nothing, block, None, short)
            if block[RAISED_WORD] != 0:
                return (k + 1) * n_stages
            if is_pair:
                _, p = halves(slot(None, short, Y))
                rate, _ = halves(slot(None, short, last))
                velocity(t + x * h, p, block, rate)
            for i in range(d.shape[1]):
                bend = d[F + 1, i] + x * d[F + 2, i]
                value = d[0, i] + x * (d[F, i] + (1.0 - x) * bend)
                rise = d[F, i] + (1.0 - 2.0 * x) * bend + x * (1.0 - x) * d[F + 2, i]
                lacks = short[Y, i] - value
                falls = h * short[last, i] - rise
                for j in range(2 * m):
                    d[F + 3 + j, i] += matrix[j, 2 * k] * lacks + matrix[j, 2 * k + 1] * falls
        return m * n_stages

    dense_rows.py_func.__name__ = f"dense_rows_of_{name}"
    return dense_rows
