"""Claims about linear equations E y' + A y = g with E singular in any combination of its rows."""

import numpy as np
import pytest

from fastdyn import solve_dae


def equations(t, y, yp, E, A, w):
    """The solution is sin(w t)."""
    return E @ (yp - w * np.cos(w * t)) + A @ (y - np.sin(w * t))


CALLS = []


def in_python(t, y, yp, E, A, w):
    CALLS.append(t)
    return equations(t, y, yp, E, A, w)


def pencil(rng, n, rank, index):
    """E and A of a regular pencil of that index, in mixed coordinates and units."""
    E, A = np.zeros((n, n)), np.eye(n)
    E[:rank, :rank] = np.eye(rank)
    A[:rank, :rank] = np.diag(10 ** rng.uniform(-2, 3, rank))
    if index == 2:
        E[n - 2, n - 1] = 1.0
    left, right = (np.linalg.qr(rng.normal(size=(n, n)))[0] for _ in range(2))
    left = 10 ** rng.uniform(-4, 4, (n, 1)) * left
    return left @ E @ right, left @ A @ right


def drawn(seed, index):
    """E and A of that index, and the frequencies of the solution."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1 + index, 8))
    E, A = pencil(rng, n, int(rng.integers(1, n + 1 - index)), index)
    return E, A, rng.uniform(0.3, 2.0, n)


@pytest.mark.parametrize("F", [equations, in_python])
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_pencils_of_index_1_are_solved(F, seed):
    E, A, w = drawn(seed, 1)
    n = len(w)
    for yp0 in (w, None):
        run = solve_dae(F, (0, 2), np.zeros(n), yp0, args=(E, A, w), rtol=1e-7, atol=1e-9)
        assert run.success and np.abs(run.y - np.sin(w[:, None] * run.t)).max() <= 3e-6
        assert np.abs(run.yp[:, 0] - w).max() <= 1e-4


@pytest.mark.parametrize("F", [equations, in_python])
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_pencils_of_index_2_are_refused(F, seed):
    E, A, w = drawn(seed, 2)
    n = len(w)
    with pytest.raises(ValueError, match="index of the equations is above 1"):
        solve_dae(F, (0, 2), np.zeros(n), w, args=(E, A, w))
