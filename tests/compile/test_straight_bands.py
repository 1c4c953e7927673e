"""Elimination of narrow bands, a column at a time in straight-line code: the bits of the loops."""

import numpy as np
import pytest

from fastdyn.compile.linear_systems.straight_bands import are_short, band_routines
from fastdyn.kernels.algebra import factorise as kernels
from fastdyn.kernels.algebra import factorise_complex as complex_kernels
from fastdyn.kernels.algebra import lapack
from fastdyn.kernels.jit.options import njit

BANDS = [(1, 0), (1, 1), (2, 2), (1, 5), (3, 1), (4, 4), (5, 2)]


@njit()
def by_routines(factorise, solve, a, lower, upper, pivots, b):
    regular = lapack.factorise_band(factorise, a, len(pivots), lower, upper, pivots)
    lapack.solve_band(solve, a, len(pivots), lower, upper, pivots, b)
    return regular


@njit()
def by_loops(a, lower, upper, pivots, b):
    n, ld, a = len(pivots), 2 * lower + upper, a[lower + upper :]
    kernels.factorise(a, ld, pivots, n, lower, upper)
    kernels.solve(a, ld, pivots, b, n, lower, upper)


@njit()
def by_complex_loops(re, im, lower, upper, pivots, b, c):
    n, ld = len(pivots), 2 * lower + upper
    re, im = re[lower + upper :], im[lower + upper :]
    complex_kernels.factorise_complex(re, im, ld, pivots, n, lower, upper)
    complex_kernels.solve_complex(re, im, ld, pivots, b, c, n, lower, upper)


def drawn(rng, n, lower, upper, diagonal):
    """A band in LAPACK's storage, complex, and a right-hand side."""
    a = np.zeros((n, 2 * lower + upper + 1), complex)
    for j in range(n):
        rows = np.arange(max(0, j - upper), min(n, j + 1 + lower))
        numbers = rng.standard_normal((2, len(rows)))
        a[j, lower + upper + rows - j] = [1, 1j] @ numbers + diagonal * (rows == j)
    return a.reshape(-1), [1, 1j] @ rng.standard_normal((2, n))


@pytest.mark.few
@pytest.mark.parametrize("diagonal", [0.0, 30.0])  # rows are exchanged, or not
@pytest.mark.parametrize(("lower", "upper"), BANDS)
def test_bits_are_those_of_the_loops(lower, upper, diagonal):
    rng = np.random.default_rng(lower)
    factorise, solve, factorise_complex, solve_complex, _ = band_routines(lower, upper, True)
    for n in (lower + upper, lower + upper + 1, 40):
        a, b = drawn(rng, n, lower, upper, diagonal)
        x, found = b.real.copy(), b.real.copy()
        by_loops(a.real.copy(), lower, upper, np.empty(n), x)
        assert by_routines(factorise, solve, a.real.copy(), lower, upper, np.empty(n), found)
        assert np.array_equal(found, x) and np.isfinite(x).all()
        x, y, found = b.real.copy(), b.imag.copy(), b.view(float).copy()
        by_complex_loops(a.real.copy(), a.imag.copy(), lower, upper, np.empty(n), x, y)
        stored = a.view(float).copy()
        by_routines(factorise_complex, solve_complex, stored, lower, upper, np.empty(n), found)
        assert np.array_equal(found[::2], x) and np.array_equal(found[1::2], y)


@pytest.mark.parametrize("column", [0, 20, 39])
@pytest.mark.parametrize("bad", [0.0, 1e-310, np.nan])  # 1 / 1e-310 overflows
def test_what_is_not_regular_is_told(column, bad):
    a, b = drawn(np.random.default_rng(0), 40, 1, 1, 4.0)
    a = a.real.reshape(40, 4).copy()
    a[column] = bad
    factorise, solve, *_ = band_routines(1, 1, False)
    assert not by_routines(factorise, solve, a.reshape(-1), 1, 1, np.empty(40), b.real.copy())


def test_wide_bands_and_triangles_are_left_to_others():
    assert are_short(2, 2) and not are_short(0, 2) and not are_short(6, 6)
