"""The table of an explicit Runge-Kutta method for the kernels of `stepping/backward.py`."""

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from ..stepping.backward import SINGLE
from . import BY_NAME
from .method import stability_polynomial
from .within_steps import nodes_of, of_data

# The limit of stability is searched along rays; |R| may exceed 1 by GROWTH, which no step notices.
ANGLES = 36
FINEST = 0.02
FARTHEST = 12.0
GROWTH = 1e-3
# The angle of an eigenvalue is taken so much nearer to the imaginary axis, where pairs are least
# stable: it is measured from one cotangent, in which several modes are left.
ASIDE = math.pi / 12
ROUNDING = 1e-9  # of the trace of a step
# How far a step that is found again may end from the known end: Radau's iteration leaves a share of
# the tolerance, that of the Gauss methods rounding errors.
NEAR = 10.0
NEAR_BY_ITERATION = 1e-6
OSCILLATES = -0.5  # cosine of q'' and q below which the motion of q'' = a(t, q) oscillates


class Terms(NamedTuple):
    """Rows of a sparse matrix: row i has the entries from begin[i] to begin[i + 1]."""

    begin: Any
    index: Any
    value: Any


class Table(NamedTuple):
    """The coefficients of a method of s stages, `n_stages`, and S - s - 1 of its interpolant.

    `c` has the times of all S stages; stage s is the derivative at the end, whose row is b.  `rows`
    are the rows of a; `columns` its columns without the stages of the interpolant, `seeded` with
    them.  The last stage that another stage needs is used[0] without the interpolant, used[1] with
    it.  `dense` has the weights of the stages in the rows F0, F1, ... of the dense output.
    """

    n_stages: int
    c: Any
    rows: Terms
    columns: Terms
    seeded: Terms
    used: Any
    dense: Any

    @property
    def n_rows(self):
        """The rows of the work array of the kernels."""
        return 4 * len(self.c) + SINGLE


class Splitting(NamedTuple):
    """The kicks, the drifts, and the times of the kicks between them, as shares of the step.

    `nodes` are the ends of the shorter steps of the interpolant, and `dense` is the matrix from
    values and slopes to its rows: see `within_steps.py`.
    """

    kicks: Any
    drifts: Any
    times: Any
    nodes: Any
    dense: Any


class Rosenbrock(NamedTuple):
    """The coefficients of Rodas5P, and the places of the entries of df/dy in a band matrix.

    Row 8 of `a` is that of the end of the step.  The matrix has the components in another `order`.
    """

    a: Any
    c: Any
    times: Any
    slopes: Any
    dense: Any
    gamma: Any
    rows: Any
    columns: Any
    order: Any
    lower: Any
    upper: Any
    ld: Any


class BlocksOfRosenbrock(NamedTuple):
    """The blocks of the equations, of their Jacobian, their vjp, and the vjp of a derivative."""

    own: Any
    jacobian: Any
    pull: Any
    along: Any


class MemoryOfRosenbrock(NamedTuple):
    """The memory that `stepping/backward_rosenbrock.py` writes: see there.

    `entries` are those of df/dy, followed by df/dt; `z` has room for the arguments of a vjp.
    """

    work: Any
    out: Any
    entries: Any
    z: Any
    matrix: Any
    pivots: Any


class Collocation(NamedTuple):
    """The coefficients of an implicit Runge-Kutta method, and the places of the entries of df/dy.

    `a` is the matrix of the stages; if `second` is 1, for q'' = f(t, q), its square, and `inner` is
    the matrix itself; `twice` is b a.  `dense` has the weights of the stages in the rows F0, F1,
    ... of the dense output.  A step that is found again ends within `near` times the scale from the
    end that is known.  The matrix of all stages has the components in another `order`, and the
    bandwidths `lower` and `upper`.
    """

    c: Any
    a: Any
    inner: Any
    b: Any
    twice: Any
    dense: Any
    second: Any
    near: Any
    rows: Any
    columns: Any
    order: Any
    lower: Any
    upper: Any
    ld: Any


class BlocksOfCollocation(NamedTuple):
    """The blocks of the equations, of their Jacobian, and of their vjp."""

    own: Any
    jacobian: Any
    pull: Any


class MemoryOfCollocation(NamedTuple):
    """The memory that `stepping/backward_collocation.py` writes: see there.

    `entries` are those of df/dy; `z` has the unknowns of all stages; `pair` the arguments of a vjp.
    """

    work: Any
    out: Any
    entries: Any
    z: Any
    pair: Any
    matrix: Any
    pivots: Any


class Steps(NamedTuple):
    """All steps of a solve: their times, and whether a step evaluates its first derivative anew.

    The length h of a constant step is exact, where the difference of its times is rounded.
    """

    t: Any
    end: Any
    h: Any
    fresh: Any


class Seeds(NamedTuple):
    """The derivatives `g`, (n_points, n), of a number by the outputs.

    The outputs have the times `t`; `ends` are the start and the ends of all steps as the output
    has them.  The first left[0] outputs have not been taken yet; `beta` has room for S weights.
    """

    t: Any
    ends: Any
    g: Any
    beta: Any
    left: Any


class Outside(NamedTuple):
    """The derivatives by the outputs, g, (n, n_points), and the tolerances of a plain solve.

    `atol` has one for each component.
    """

    g: Any
    rtol: Any
    atol: Any


class Memory(NamedTuple):
    """What the kernels of `stepping/backward.py` write: see there.

    `pairs` is the first part of `work`, in rows of two rows: u_i and kappa_i.
    """

    work: Any
    pairs: Any
    out: Any
    gauge: Any


@functools.cache
def table_of(name):
    """The Table of a method."""
    given: Any = BY_NAME[name].tableau
    s = len(given["b"])
    n = len(given["a"])
    a = np.zeros((n, n))
    for i, row in enumerate(given["a"]):
        a[i, : len(row)] = row.floats
    weights = a[s]
    begin = np.zeros(n)
    end = np.zeros(n)
    begin[0] = end[s] = 1.0
    dense = [weights, begin - weights, 2 * weights - begin - end]
    dense += [np.pad(row.floats, (0, n - len(row))) for row in given["d"]]
    inner = [max(np.flatnonzero(a[i]), default=0) for i in range(n)]
    inner[s] = 0  # the new state is known
    used = np.array([max(inner[: s + 1]), max(inner)])
    plain = a.copy()
    plain[s + 1 :] = 0.0
    return Table(
        s, np.array(given["c"].floats), _terms(a), _terms(plain.T), _terms(a.T), used,
        np.array(dense),
    )  # fmt: skip


def _terms(matrix):
    places = [np.flatnonzero(row) for row in matrix]
    values = [row[at] for row, at in zip(matrix, places, strict=True)]
    begin = np.cumsum([0, *map(len, places)])
    return Terms(begin, np.concatenate(places), np.concatenate(values))


@functools.cache
def kicks_of(name):
    """The Splitting of a method."""
    given: Any = BY_NAME[name].tableau
    times = np.cumsum(given["drifts"])
    times[-1] = 1.0
    m = (BY_NAME[name].n_dense - 3) // 2
    return Splitting(
        *[np.ascontiguousarray(given[key], float) for key in ("kicks", "drifts")], times,
        nodes_of(m), of_data(m),
    )  # fmt: skip


def rosenbrock_of(rows, columns, order):
    """The Rosenbrock of equations whose df/dy has entries in these rows and columns.

    `order` is the place of each component in the matrix.
    """
    from .rodas5p.table import DENSE, END_ROW, GAMMA, SLOPES, STAGE_ROWS, TIMES, C  # other code

    a = [np.pad(row, (0, 8 - len(row))) for row in ((), *STAGE_ROWS, END_ROW)]
    c = [np.pad(row.floats, (0, 8 - len(row))) for row in C]
    rows = order[rows]
    columns = order[columns]
    lower, upper = [int(max(each.max(initial=0), 0)) for each in (rows - columns, columns - rows)]
    return Rosenbrock(
        np.array(a), np.array([np.zeros(8), *c]), np.array([0.0, *TIMES.floats]),
        np.array(SLOPES.floats), np.array([row.floats for row in DENSE]), GAMMA,
        np.array(rows, np.int64), np.array(columns, np.int64), order, lower, upper,
        min(2 * lower + upper, len(order)),
    )  # fmt: skip


def collocation_of(name, rows, columns, order):
    """The Collocation of a method for equations whose df/dy has entries in these places.

    `order` is the place of each component in the matrix.
    """
    c, a, b, dense = _stages_of(name)
    second = BY_NAME[name].second_order
    lower, upper = [
        len(c) * int(max(each.max(initial=0), 0)) + len(c) - 1
        for each in (order[rows] - order[columns], order[columns] - order[rows])
    ]
    near = NEAR if BY_NAME[name].error_order else NEAR_BY_ITERATION
    return Collocation(
        c, a @ a if second else a, a, b, b @ a, dense, int(second), near,
        np.array(rows, np.int64), np.array(columns, np.int64), order, lower, upper,
        min(2 * lower + upper, len(c) * len(order)),
    )  # fmt: skip


@functools.cache
def _stages_of(name):
    """The times, the matrix and the weights of an implicit method, and those of its output."""
    if name == "Radau":
        from .radau.stages import C, P  # other code

        # p = x (P0 + P1 x + P2 x^2), of the stages u_i - y, has the derivatives h F_i at the times.
        c = np.array(C)
        a = np.linalg.inv((P @ np.array([c**0, 2 * c, 3 * c**2])).T)
        return c, a, a[2].copy(), np.array([a[2], -(P[:, 1] + P[:, 2]) @ a, -P[:, 2] @ a])
    given: Any = BY_NAME[name].tableau
    b, c = [np.array([float(x) for x in given[key]]) for key in "bc"]
    return c, np.array(given["mu"]) * b, b, np.ascontiguousarray(given["rows"] * b)


def stable_size(name, cosine):
    """The largest stable |h lambda|, for an eigenvalue lambda with this cosine, Re / |.|."""
    angle = min(math.pi / 2, math.acos(min(1.0, max(0.0, -cosine))) + ASIDE)
    return _stable_size(name, round(ANGLES * angle / math.pi))


@functools.cache
def _stable_size(name, angle):
    polynomial = stability_polynomial(BY_NAME[name].tableau)
    z = np.exp(1j * angle * math.pi / ANGLES) * np.arange(FINEST, FARTHEST, FINEST)
    outside = np.abs(np.polyval(polynomial, -z)) > 1.0 + GROWTH
    return float(np.abs(z[outside.argmax()]))


def stable_kicks(name, cosine):
    """The largest h w of a stable step of kicks and drifts for q'' = -w^2 q; inf for growth.

    `cosine` is -1 for an oscillation.  The step is stable where the trace of its matrix, whose
    determinant is 1, is between -2 and 2.
    """
    return _stable_kicks(name) if cosine < OSCILLATES else math.inf


@functools.cache
def _stable_kicks(name):
    table = kicks_of(name)
    z = np.arange(FINEST, FARTHEST, FINEST)
    flow = np.tile(np.eye(2), (len(z), 1, 1))
    drifts = np.append(table.drifts, 0.0)
    for kick, drift in zip(table.kicks, drifts, strict=True):
        flow[:, 1] -= kick * z[:, None] ** 2 * flow[:, 0]
        flow[:, 0] += drift * flow[:, 1]
    outside = np.abs(np.trace(flow, axis1=1, axis2=2)) > 2.0 + ROUNDING
    return float(z[outside.argmax() - 1])
