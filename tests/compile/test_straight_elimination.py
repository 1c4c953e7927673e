"""Elimination in straight-line code: the bits of the loops, for any pivots."""

import numpy as np
import pytest

from fastdyn import solve_ensemble, solve_ivp
from fastdyn.compile import memory
from fastdyn.compile.linear_systems.straight_elimination import FULL, straight_routines
from fastdyn.kernels.algebra import lapack
from fastdyn.kernels.jit.options import njit
from fastdyn.run import again
from fastdyn.run.matrices import layouts as matrices
from support.loops import by_columns, by_complex_kernels, by_kernels
from support.stiff import PROBLEMS, counts, solved

SHAPES = {
    "full": lambda i, j: i >= 0,
    "diagonal": lambda i, j: i == j,
    "banded": lambda i, j: abs(i - j) < 2,
    "no diagonal": lambda i, j: j == (i + 1) % len(i),
    "arrow": lambda i, j: (i == 0) | (j == 0),
    "triangular": lambda i, j: i <= j,
}


@njit()
def by_routines(factorise, solve, a, pivots, b):
    regular = lapack.factorise_full(factorise, a, len(pivots), pivots)
    lapack.solve_full(solve, a, len(pivots), pivots, b)
    return regular


def drawn(n, shape):
    """Where elements are, 20 matrices with these, complex, and right-hand sides."""
    rng = np.random.default_rng(n)
    where = SHAPES[shape](*np.indices((n, n)))
    places = tuple(zip(*(index.tolist() for index in np.nonzero(where)), strict=True))
    where = where | np.eye(n, dtype=bool)
    scale = 10.0 ** rng.integers(-3, 4, (20, n, n, 2))  # for pivots off the diagonal
    a = where[:, :, None] * scale * rng.standard_normal((20, n, n, 2))
    return None if shape == "full" else places, a, rng.standard_normal((20, n, 2))


@pytest.mark.few
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("n", [1, 2, 3, 5, FULL])
def test_bits_are_those_of_the_loops(n, shape):
    places, *given = drawn(n, shape)
    factorise, solve, factorise_complex, solve_complex, _ = straight_routines(n, places, True)
    for a, b in zip(*given, strict=True):
        x, found = b[:, 0].copy(), b[:, 0].copy()
        by_kernels(by_columns(a[:, :, 0], n, n), x, np.empty(n), n - 1, n - 1)
        stored = a[:, :, 0].T.reshape(-1).copy()
        assert by_routines(factorise, solve, stored, np.empty(n), found)
        assert np.array_equal(found, x)
        re, im = by_columns(a[:, :, 0], n, n), by_columns(a[:, :, 1], n, n)
        (x, y), found = b.T.copy(), b.reshape(-1).copy()
        by_complex_kernels(re, im, x, y, np.empty(n), n - 1, n - 1)
        stored = a.transpose(1, 0, 2).reshape(-1).copy()
        by_routines(factorise_complex, solve_complex, stored, np.empty(n), found)
        assert np.array_equal(found[::2], x) and np.array_equal(found[1::2], y)


@pytest.mark.parametrize("bad", [0.0, np.nan, np.inf])
def test_what_is_not_regular_is_told(bad):
    a = np.array([1.0, 2.0, bad, bad])
    factorise, solve, *_ = straight_routines(2, None, False)
    assert not by_routines(factorise, solve, a, np.empty(2), np.ones(2))


def test_long_texts_are_left_to_the_loops():
    assert straight_routines(FULL + 1, None, True) is None
    assert straight_routines(30, tuple((i, i) for i in range(30)), True) is not None
    assert straight_routines(30, tuple((i, j) for i in range(30) for j in range(30)), True) is None


@pytest.mark.parametrize("method", ["Radau", "BDF", "LSODA", "Rodas5P"])
@pytest.mark.parametrize("name", ["Robertson", "HIRES"])
def test_solutions_are_those_by_loops(name, method, monkeypatch):
    p = PROBLEMS[name]

    def both():
        many = solve_ensemble(p.fun, p.t_span, [p.y0], method=method, simd=False, **p.options)
        return solved(solve_ivp, p, method), many

    one, many = both()
    monkeypatch.setattr(matrices, "straight_routines", lambda *given: None)
    monkeypatch.setattr(again, "calls", memory.Table())
    expected, of_many = both()
    assert counts(one) == counts(expected)
    assert np.array_equal(one.y, expected.y) and np.array_equal(many.y_end, of_many.y_end)
