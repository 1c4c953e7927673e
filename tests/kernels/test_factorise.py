"""Elimination in matrices stored by columns, banded and full, real and complex."""

import numba
import numpy as np
import pytest

from fastdyn.kernels.algebra import factorise as kernels
from support.loops import by_columns, by_complex_kernels, by_kernels

EPS = np.finfo(float).eps


@numba.njit
def add_product(a, x, out, lower, upper):
    kernels.add_matrix_product(a.reshape(-1), len(x), x, out, len(x), lower, upper)


@numba.njit
def bandwidths(a):
    return kernels.bandwidths(a.reshape(-1), len(a))


def banded(rng, n, lower, upper):
    i, j = np.indices((n, n))
    return np.where((i - j <= lower) & (j - i <= upper), rng.standard_normal((n, n)), 0.0)


BANDS = [
    (1, 0, 0), (2, 1, 1), (5, 4, 4), (30, 29, 29), (30, 1, 1), (40, 2, 5), (40, 12, 3), (60, 8, 20),
    (51, 13, 13), (33, 3, 17),
]  # fmt: skip


def error(a, x, b):
    """The residual in units of what elimination with these pivots may leave, roughly n eps."""
    return np.abs(a @ x - b).max() / (len(b) * EPS * np.abs(a).sum(1).max() * np.abs(x).max())


@pytest.mark.parametrize(("n", "lower", "upper"), BANDS)
def test_solutions_solve(n, lower, upper):
    rng = np.random.default_rng(n + lower)
    for _ in range(20):
        a, b = banded(rng, n, lower, upper), rng.standard_normal(n)
        x = b.copy()
        by_kernels(by_columns(a, lower, upper), x, np.empty(n), lower, upper)
        assert error(a, x, b) < 1.0


@pytest.mark.parametrize(("n", "lower", "upper"), BANDS)
def test_products_are_added(n, lower, upper):
    """Rounding: an eps a term and one for the sum."""
    rng = np.random.default_rng(n + lower)
    a, x, b = banded(rng, n, lower, upper), *rng.standard_normal((2, n))
    out, size = b.copy(), np.abs(a) @ np.abs(x) + np.abs(b)
    add_product(by_columns(a, lower, upper), x, out, lower, upper)
    assert (np.abs(out - (a @ x + b)) <= (n + 2) * EPS * size).all()


@pytest.mark.parametrize(("n", "lower", "upper"), BANDS)
def test_complex_solutions_solve(n, lower, upper):
    rng = np.random.default_rng(n + lower)
    for _ in range(20):
        re, im = banded(rng, n, lower, upper), banded(rng, n, lower, upper)
        b, c = rng.standard_normal((2, n))
        x, y = b.copy(), c.copy()
        given = by_columns(re, lower, upper), by_columns(im, lower, upper)
        by_complex_kernels(*given, x, y, np.empty(n), lower, upper)
        assert error(re + 1j * im, x + 1j * y, b + 1j * c) < 2.0


def test_a_band_has_the_bits_of_the_full_matrix():
    rng = np.random.default_rng(3)
    a, b = banded(rng, 25, 3, 2), rng.standard_normal(25)
    x, y = b.copy(), b.copy()
    by_kernels(by_columns(a, 3, 2), x, np.empty(25), 3, 2)
    by_kernels(by_columns(a, 24, 24), y, np.empty(25), 24, 24)
    assert np.array_equal(x, y)


def eliminated(a, b):
    """The solution by elimination with NumPy, which rounds each product and each difference."""
    a, b = a.copy(), b.copy()
    for k in range(len(b)):
        p = k + np.argmax(np.abs(a[k:, k]))
        a[[k, p], k:], b[[k, p]] = a[[p, k], k:], b[[p, k]]
        a[k, k] = 1.0 / a[k, k]
        a[k + 1 :, k] *= a[k, k]
        a[k + 1 :, k + 1 :] -= np.outer(a[k + 1 :, k], a[k, k + 1 :])
        b[k + 1 :] -= b[k] * a[k + 1 :, k]
    for k in reversed(range(len(b))):
        b[k] *= a[k, k]
        b[:k] -= b[k] * a[:k, k]
    return b


@pytest.mark.parametrize("dominant", [0.0, 0.8, 1.0])
@pytest.mark.parametrize(("n", "lower", "upper"), BANDS)
def test_vectors_have_the_bits_of_numbers(n, lower, upper, dominant):
    """Also four columns at a time, which are taken where the diagonal has the pivots."""
    rng = np.random.default_rng(n + lower)
    a, b = banded(rng, n, lower, upper), rng.standard_normal(n)
    a[np.diag_indices(n)] += 100.0 * (rng.random(n) < dominant)
    x, pivots = b.copy(), np.empty(n)
    by_kernels(by_columns(a, lower, upper), x, pivots, lower, upper)
    assert np.array_equal(x, eliminated(a, b))
    assert (pivots == np.arange(n)).all() or dominant < 1.0


def test_bands_are_found():
    rng = np.random.default_rng(4)
    for n, lower, upper in BANDS:
        assert bandwidths(by_columns(banded(rng, n, lower, upper), n, n)) == (lower, upper)


def test_a_singular_matrix_gives_no_finite_solution():
    b = np.ones(2)
    by_kernels(np.array([[1.0, 2.0], [2.0, 4.0]]), b, np.empty(2), 1, 1)
    assert not np.isfinite(b).all()
