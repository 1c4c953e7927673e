"""The table of an explicit Runge-Kutta method for the kernels of `stepping/backward.py`."""

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from ..stepping.backward import SINGLE
from . import BY_NAME

# The limit of stability is searched along rays; |R| may exceed 1 by GROWTH, which no step notices.
ANGLES, FINEST, FARTHEST, GROWTH = 36, 0.02, 12.0, 1e-3
# The angle of an eigenvalue is taken so much nearer to the imaginary axis, where pairs are least
# stable: it is measured from one cotangent, in which several modes are left.
ASIDE = math.pi / 12


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


class Steps(NamedTuple):
    """All steps of a solve: their times, and whether a step evaluates its first derivative anew."""

    t: Any
    end: Any
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
    s, n = len(given["b"]), len(given["a"])
    a = np.zeros((n, n))
    for i, row in enumerate(given["a"]):
        a[i, : len(row)] = row.floats
    weights, begin, end = a[s], np.zeros(n), np.zeros(n)
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


def stable_size(name, cosine):
    """The largest |h lambda| of a stable step, for an eigenvalue lambda with this cosine, Re / |.|.

    R(z) = 1 + z b (1 + z A (1 + z A ...)): E. Hairer and G. Wanner, "Solving Ordinary Differential
    Equations II", section IV.2.
    """
    angle = min(math.pi / 2, math.acos(min(1.0, max(0.0, -cosine))) + ASIDE)
    return _stable_size(name, round(ANGLES * angle / math.pi))


@functools.cache
def _stable_size(name, angle):
    given: Any = BY_NAME[name].tableau
    s = len(given["b"])
    a = np.array([np.pad(row.floats, (0, s - len(row))) for row in given["a"][:s]])
    b, powers, coefficients = np.array(given["b"].floats), np.ones(s), [1.0]
    for _ in range(s):
        coefficients.append(b @ powers)
        powers = a @ powers
    z = np.exp(1j * angle * math.pi / ANGLES) * np.arange(FINEST, FARTHEST, FINEST)
    outside = np.abs(np.polyval(coefficients[::-1], -z)) > 1.0 + GROWTH
    return float(np.abs(z[outside.argmax()]))
