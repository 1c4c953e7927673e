"""Functions of long arrays, traced in batches, beside NumPy."""

import numpy as np
import pytest

from fastdyn.trace.graph.refusal import Untraceable
from support.long_arrays import HARD, LINKS, N, in_batches, program

CANCELLED = 1e-11  # of the largest component, where terms cancel


def check(function, compiled, seed=1):
    random = np.random.default_rng(seed)
    for _ in range(3):
        t, y = random.normal(), random.normal(size=N)
        with np.errstate(all="ignore"):
            expected = np.asarray(function(t, y))
        found = compiled(t, y)
        size = np.max(np.abs(expected[np.isfinite(expected)]), initial=0.0)
        np.testing.assert_allclose(found, expected, rtol=1e-11, atol=CANCELLED * size)


@pytest.mark.parametrize("function", HARD, ids=lambda f: f.__name__)
def test_hard_for_the_pieces(function):
    check(function, in_batches(function, N)[0])


@pytest.mark.hunt
@pytest.mark.parametrize("seed", range(40))
def test_random_programs(seed):
    function, _lines = program(seed)
    try:
        compiled, _ = in_batches(function, N)
    except Untraceable as reason:
        pytest.skip(str(reason))
    check(function, compiled, seed)


def test_the_pattern_of_a_sparse_matrix():
    _, traced = in_batches(lambda t, y: LINKS @ y - y, N)
    there = np.zeros((N, N), bool)
    there[traced.pattern] = True
    assert np.array_equal(there, (LINKS.toarray() != 0) | np.eye(N, dtype=bool))


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", range(40))
def test_the_pattern_of_the_jacobian_has_all_that_differs_from_zero(seed):
    function, lines = program(1000 + seed)
    try:
        _, traced = in_batches(function, N)
    except Untraceable as reason:
        pytest.skip(str(reason))
    if traced.pattern is None:
        return
    there = np.zeros((N, N), bool)
    there[traced.pattern] = True
    y = np.random.default_rng(seed).normal(size=N)
    with np.errstate(all="ignore"):
        base = np.asarray(function(0.3, y))
        for j in range(N):
            moved = y.copy()
            moved[j] += 1e-3
            changed = np.asarray(function(0.3, moved)) != base
            changed &= np.isfinite(base)
            assert not (changed & ~there[:, j]).any(), lines
