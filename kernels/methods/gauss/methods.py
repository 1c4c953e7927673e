"""Gauss4, Gauss8, Gauss16: Gauss-Legendre collocation with 2, 4 and 8 stages; and HBVM.

GaussNystrom8 and 16 are Gauss8 and Gauss16 for q'' = a(t, q), iterated in positions and velocities
by turns: the results agree to rounding, and a step takes half the time.

Gauss methods are symplectic for every Hamiltonian system y' = f(y), separable or not (J. C.
Butcher, "Implicit Runge-Kutta processes", Math. Comp. 18 (1964); J. M. Sanz-Serna, "Runge-Kutta
schemes for Hamiltonian systems", BIT 28 (1988)).

EnergyConserving2 and 4: the average vector field method (G. R. W. Quispel and D. I. McLaren, "A
new class of energy-preserving numerical integration methods", J. Phys. A 41 (2008)) and the
Hamiltonian boundary value method HBVM(8, 2) (L. Brugnano, F. Iavernaro and D. Trigiante,
"Hamiltonian boundary value methods", JNAIAM 5 (2010)).  Both take the integral along a step by
Gauss's formula of order 16, which is exact for polynomials of degree 15, and exact to rounding for
smooth functions at reasonable steps.
"""

from decimal import Decimal
from functools import partial

import numpy as np

from ...jit.options import INLINED, njit
from ...state.rows import numbers_of
from ...stepping import first_step
from ..method import method
from . import collocation, legendre
from .collocation import make_step
from .iteration import INCREMENTS
from .stages import Matrix

N_ROWS_PER_STAGE, N_ROWS_MORE = 2, 4  # increments, stages; compensation, two rows of changes, slope
ITERATIONS = 12  # a guess, for an estimate of the time of a step


def symplectic(s):
    """mu_ij = a_ij / b_j, rounded so that mu_ij + mu_ji = 1 holds exactly."""
    a = legendre.collocation(s)
    _, b = legendre.nodes_and_weights(s)
    mu = [[0.5] * s for _ in range(s)]
    for i in range(s):
        for j in range(i):
            mu[i][j] = float(a[i][j] / b[j])
            mu[j][i] = 1.0 - mu[i][j]
    return mu


def energy_conserving(s, order):
    """mu_ij = sum I_m(c_i) P_m(c_j) over the Legendre polynomials of degree below order / 2.

    Each mu_ij is rounded to a multiple of 2^-52, so that mu_ij + mu_(s+1-i)(s+1-j) = 1 holds
    exactly: rounding then has no preferred sign, and the energy does not drift.
    """
    c, _ = legendre.nodes_and_weights(s)
    linear = 3 if order == 4 else 0
    half = [[x + linear * (x * x - x) * (2 * y - 1) for y in c] for x in c[: s // 2]]
    half = [[float((x * 2**52).to_integral_value()) / 2**52 for x in row] for row in half]
    return half + [[1.0 - x for x in row[::-1]] for row in half[::-1]]


def extrapolation(s):
    """The matrix b_i l_j(1 + c_i) / b_j, which predicts L of the next step from L of this step."""
    e = legendre.extrapolated(s)
    _, b = legendre.nodes_and_weights(s)
    return [[float(b[i] * e[i][j] / b[j]) for j in range(s)] for i in range(s)]


def collocation_polynomial(s):
    """Rows of the interpolant from the increments, in the form of `dense_output.py`."""
    _, b = legendre.nodes_and_weights(s)
    columns = zip(legendre.nested_integrals(s), b, strict=True)
    return np.array([[float(x / w) for x in column] for column, w in columns]).T


def energy_polynomial(s, order):
    """Rows of the interpolant of an energy-conserving method: a line, or a parabola."""
    c, _ = legendre.nodes_and_weights(s)
    rows = [[1.0] * s, [float(3 * (1 - 2 * x)) for x in c]]
    return np.array(rows[: order // 2])


def make_dense_rows(name, s, rows):
    """The `dense_rows` of a method, which takes no evaluations."""
    rows = np.vstack([rows, np.zeros((max(0, 3 - len(rows)), s))])

    def dense_rows(rhs, t, h, work, block, d):
        n = work.shape[1]
        numbers = numbers_of(work)
        for c in range(n):
            for r in range(len(rows)):
                total = 0.0
                for i in range(s):
                    total += rows[r, i] * numbers[INCREMENTS * n + c * s + i]
                d[1 + r, c] = total
        return 0

    dense_rows.__name__ = name
    return njit(**INLINED)(dense_rows)


def _gauss(name, s, order, mu, rows, nystrom=False):
    """A Method of implicit Runge-Kutta type with the matrix mu."""
    nodes, weights = legendre.nodes_and_weights(s)
    b, c = (np.array([float(x) for x in values]) for values in (weights, nodes))
    more = N_ROWS_PER_STAGE * s + N_ROWS_MORE
    given = s, Matrix(mu), Matrix(extrapolation(s)), b, c, nystrom
    return method(
        name, order=order, error_order=0, n_stages=0, n_rows=more, fsal_stage=more - 1,
        kernel=partial(collocation.kernel, make_step(*given)),
        batched=(s, partial(collocation.kernel, make_step(*given, batched=True))),
        start=first_step.second_order if nystrom else first_step.plain,
        n_dense=max(3, len(rows)), dense_rows=make_dense_rows(name, s, rows),
        dense_order=len(rows), second_order=nystrom, projects=False, cost=s * ITERATIONS,
        backward="collocation",
        tableau={"mu": mu, "b": tuple(map(Decimal, weights)), "c": nodes, "rows": rows},
    )  # fmt: skip


GAUSS = tuple(
    _gauss(f"Gauss{2 * s}", s, 2 * s, symplectic(s), collocation_polynomial(s)) for s in (2, 4, 8)
)
NYSTROM = tuple(
    _gauss(f"GaussNystrom{2 * s}", s, 2 * s, symplectic(s), collocation_polynomial(s), True)
    for s in (4, 8)
)
ENERGY_CONSERVING = tuple(
    _gauss(f"EnergyConserving{n}", 8, n, energy_conserving(8, n), energy_polynomial(8, n))
    for n in (2, 4)
)
