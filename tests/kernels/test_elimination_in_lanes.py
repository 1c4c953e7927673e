"""Linear systems in the lanes of vectors: each lane has a matrix and pivots of its own."""

import numpy as np
import pytest
from numba import njit

from fastdyn.kernels.algebra.elimination_in_lanes import make_elimination
from fastdyn.kernels.algebra.elimination_structure import structure
from fastdyn.kernels.ensemble.lanes import field
from fastdyn.kernels.state.layout import Form
from fastdyn.kernels.state.rows import fetch, keep, rows_on_stack

WIDTH, N = 4, 6
EPS = 2.0**-53
# Higham, "Accuracy and Stability of Numerical Algorithms", theorem 9.5: of the residual, in units
# of |A| |x|, with the most that pivots can grow.
BOUND = N**2 * 3 * N * EPS * 2 ** (N - 1)
SHAPES = {
    "full": [(i, j) for i in range(N) for j in range(N)],
    "banded": [(i, j) for i in range(N) for j in range(N) if abs(i - j) < 2],
    "without a diagonal": [(i, (i + 1) % N) for i in range(N)],
    "arrow": [(0, j) for j in range(N)] + [(i, 0) for i in range(1, N)],
    "triangular": [(i, j) for i in range(N) for j in range(i + 1, N)],
}


def eliminated(places, diagonal, entries, b):
    """x of each lane, and whether rows were exchanged; (WIDTH,), (WIDTH, m) and (WIDTH, N)."""
    rows, columns = zip(*places, strict=True)
    form, form_of_entries = Form(N, WIDTH), Form(len(places), WIDTH)
    room, factorise, solve = make_elimination(rows, columns, form)

    @njit(error_model="numpy")
    def run(diagonal, entries, b, x):
        factors = rows_on_stack(room, WIDTH)
        given = fetch(form_of_entries, entries, 0)
        exchanged = factorise(factors, given, field(form, diagonal, 0), None)
        keep(x, 0, (solve(factors, exchanged, fetch(form, b, 0)),))
        return exchanged

    given = [np.ascontiguousarray(a.T).reshape(1, -1) for a in (diagonal, entries, b)]
    x = np.empty((1, N * WIDTH))
    exchanged = run(*given, x)
    return x.reshape(N, WIDTH).T, exchanged


def matrices(places, diagonal, entries):
    a = np.zeros((WIDTH, N, N))
    for (i, j), values in zip(places, entries.T, strict=True):
        a[:, i, j] = -values
    return a + diagonal[:, None, None] * np.eye(N)


@pytest.mark.parametrize("shape", SHAPES)
def test_each_lane_has_pivots_of_its_own(shape):
    rng, places = np.random.default_rng(1), SHAPES[shape]
    entries, b = rng.normal(size=(WIDTH, len(places))), rng.normal(size=(WIDTH, N))
    diagonal = np.array([0.0, 1e-20, 1.0, 1e3]) + (shape in ("arrow", "triangular"))
    a = matrices(places, diagonal, entries)
    x, exchanged = eliminated(places, diagonal, entries, b)
    residual = abs(np.einsum("kij,kj->ki", a, x) - b).max(axis=1)
    assert (residual <= BOUND * abs(a).sum(axis=2).max(axis=1) * abs(x).max(axis=1)).all()
    assert exchanged == (shape != "triangular")


def test_a_singular_matrix_has_no_finite_solution_and_leaves_the_other_lanes_alone():
    rng, places = np.random.default_rng(2), SHAPES["full"]
    entries, b = rng.normal(size=(WIDTH, N * N)), rng.normal(size=(WIDTH, N))
    diagonal = np.full(WIDTH, 2.0)
    before, _ = eliminated(places, diagonal, entries, b)
    diagonal[1], entries[1] = 0.0, 1.0  # all rows the same
    entries[2, 7] = np.nan
    after, _ = eliminated(places, diagonal, entries, b)
    assert not np.isfinite(after[1]).all() and np.isnan(after[2]).all()
    assert np.array_equal(after[[0, 3]], before[[0, 3]])


@pytest.mark.parametrize("shape", SHAPES)
def test_the_structure_holds_the_factors_for_any_pivots(shape):
    found, rng = structure(SHAPES[shape], N), np.random.default_rng(3)
    for _ in range(200):
        a = np.eye(N, dtype=bool)
        a[tuple(zip(*SHAPES[shape], strict=True))] = True
        for k in range(N):
            rows = [i for i in range(k, N) if a[i, k]]
            assert set(rows) <= {k, *found.below[k]}
            p = rng.choice(rows)
            a[[k, p], k:] = a[[p, k], k:]
            assert set(np.flatnonzero(a[k, k + 1 :]) + k + 1) <= set(found.right[k])
            for i in range(k + 1, N):
                if a[i, k]:
                    a[i, k:] |= a[k, k:]


def test_a_band_stays_a_band():
    found = structure(SHAPES["banded"], N)
    assert max(map(len, found.below)) == 1 and max(map(len, found.right)) == 2
