"""Sparse elimination in a fixed order: solutions, refused pivots, and patterns that do not pay."""

import numpy as np
import pytest
import scipy.sparse
from scipy.sparse import linalg

from fastdyn import solve_ivp
from fastdyn.code_store.call import Call
from fastdyn.kernels.algebra.sparse.factors import LARGEST
from fastdyn.run.matrices.elimination import MOST, Elimination
from fastdyn.specialise.scalar import sparse_kernels

EPS = np.finfo(float).eps


def tangle(n, seed):
    """A matrix with dominant columns, of a random pattern that is not quite symmetric."""
    rng = np.random.default_rng(seed)
    near = rng.normal(size=(n, n)) * (rng.random((n, n)) < 2.0 / n)
    both = near + near.T * (rng.random((n, n)) < 0.8)
    return scipy.sparse.csc_matrix(both + np.diag(1.0 + abs(both).sum(axis=0)))


def eliminated(matrix):
    matrix.sort_indices()
    return Elimination(matrix.shape[0], matrix.indptr, matrix.indices)


@pytest.mark.few
@pytest.mark.parametrize("factor", [1.0, 1.0 + 0.7j], ids=["real", "complex"])
@pytest.mark.parametrize("seed", range(6))
def test_solutions_are_those_of_the_matrix(seed, factor):
    n = 5 + 40 * seed
    matrix, b = factor * tangle(n, seed), np.cos(np.arange(n)) * factor
    found, first = eliminated(matrix), None
    for scale in (1.0, -3.0):  # the pattern serves other numbers
        x = found.factorised(scale * matrix.data)(b.copy())
        # N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., theorems 9.4 and
        # 13.7: |b - A x| is at most 3 n u |L| |U| |x|, and with dominant columns no element of
        # |L| |U| is above 2 n times the largest of A.  Complex products round 2 sqrt(2) times as
        # far (lemma 3.5).
        rounded = EPS / 2 * (2 * np.sqrt(2) if factor.imag else 1.0)
        most = 3 * n * rounded * 2 * n * abs(scale * matrix).max() * abs(x).sum()
        assert abs(scale * matrix @ x - b).max() <= most
        first = x if first is None else first
    assert abs(first + 3.0 * x).max() <= 100 * n * EPS * abs(first).max()


def factors_by_columns(found, numbers):
    """L and U by one column at a time, as dense matrices."""
    begins, rows, places = found._pattern
    n = len(begins) - 1
    a = np.zeros((n, n), numbers.dtype)
    a[rows, np.repeat(np.arange(n), np.diff(begins))] = numbers[places]
    for k in range(n):
        for j in range(k):
            if a[j, k] != 0.0:
                a[j + 1 :, k] -= a[j + 1 :, j] * a[j, k]
        a[k + 1 :, k] /= a[k, k]
    return a


def test_four_columns_at_once_round_as_one_by_one():
    """A matrix with a full corner, whose columns are alike, and a square of two components."""
    n = 30
    matrix = scipy.sparse.lil_matrix(tangle(n, 3))
    matrix[n - 12 :, n - 12 :] = np.cos(np.arange(144.0)).reshape(12, 12) + 20.0 * np.eye(12)
    matrix = scipy.sparse.csc_matrix(matrix)
    found = eliminated(matrix)
    lower_begins, lower_rows, *_ = found._factors
    assert (np.diff(lower_begins)[:-1] >= 4).any()
    lower, upper = (np.empty(len(each)) for each in found._factors[1::2])
    call = Call(
        sparse_kernels["f"][0](), *found._pattern, matrix.data, *found._factors, lower, upper,
        np.zeros(n),
    )  # fmt: skip
    assert call() == 1
    known = factors_by_columns(found, matrix.data)
    assert (lower == known[lower_rows, np.repeat(np.arange(n), np.diff(lower_begins))]).all()


def test_a_small_number_on_the_diagonal_is_no_pivot():
    n = 30
    matrix = scipy.sparse.diags([np.ones(n - 1), np.full(n, 3.0), np.ones(n - 1)], [-1, 0, 1])
    matrix = scipy.sparse.csc_matrix(matrix)
    found, own = (
        eliminated(matrix),
        matrix.indices == np.repeat(np.arange(n), np.diff(matrix.indptr)),
    )
    for small in (0.5 / LARGEST, 0.0, np.nan):
        numbers = np.where(own, small, matrix.data)
        assert found.factorised(numbers) is None
    assert found.factorised(matrix.data) is not None


def test_full_patterns_are_left_to_dense_blocks():
    n = 2 * MOST + 10
    assert not eliminated(scipy.sparse.csc_matrix(np.ones((n, n)))).pays


@pytest.mark.parametrize("method", ["BDF", "Radau"])
def test_superlu_takes_what_has_no_pivots_on_the_diagonal(monkeypatch, method):
    n, rng = 150, np.random.default_rng(1)
    i, j = np.array([(i, j) for i, j in rng.integers(0, n, (2 * n, 2)) if i != j]).T

    def fun(t, y):
        flow, d = y[j] - y[i], -(y**3)
        for e in range(len(i)):
            d[i[e]] += flow[e]
            d[j[e]] -= flow[e]
        return d

    def solved():
        made.clear()
        return solve_ivp(fun, (0, 2), 1 + 0.5 * np.cos(np.arange(n)), method, rtol=1e-6, atol=1e-9)

    made, splu = [], linalg.splu
    monkeypatch.setattr(linalg, "splu", lambda *a, **b: made.append(a) or splu(*a, **b))
    own = solved()
    assert len(made) == 1 and own.nlu > 10  # the order
    monkeypatch.setattr(Elimination, "factorised", lambda *_: None)
    theirs = solved()
    assert len(made) >= theirs.nlu and (own.nfev, own.nlu) == (theirs.nfev, theirs.nlu)
    # The same steps: y differs by what is left of Newton's iterations, some 1e-3 of the tolerance.
    assert abs(own.y[:, -1] - theirs.y[:, -1]).max() < 0.1 * 1e-6
