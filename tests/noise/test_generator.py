"""The random numbers: Philox's published values, Box and Muller's transformation, independence."""

import numpy as np
import pytest
from scipy import stats

from fastdyn import solve_sde

MULTIPLIERS, WEYL = (0xD2511F53, 0xCD9E8D57), (0x9E3779B9, 0xBB67AE85)
LOW = 0xFFFFFFFF
# Of Random123 1.09, the file kat_vectors: counter, key, words.
PUBLISHED = [
    ([0] * 4, [0] * 2, [0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8]),
    ([LOW] * 4, [LOW] * 2, [0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD]),
    (
        [0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344], [0xA4093822, 0x299F31D0],
        [0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1],
    ),
]  # fmt: skip


def philox(counter, key):
    """Philox 4x32-10 in whole numbers of Python."""
    a, b, c, d = counter
    left, right = key
    for _ in range(10):
        one, other = MULTIPLIERS[0] * a, MULTIPLIERS[1] * c
        a, b, c, d = (
            (other >> 32) ^ b ^ left, other & LOW, (one >> 32) ^ d ^ right, one & LOW
        )  # fmt: skip
        left, right = (left + WEYL[0]) & LOW, (right + WEYL[1]) & LOW
    return [a, b, c, d]


def normal_pair(words):
    """Box and Muller's pair from four words."""
    first, second = [((words[i] << 32 | words[i + 1]) >> 12) * 2.0**-52 for i in (0, 2)]
    radius = np.sqrt(-2.0 * np.log(1.0 - first))
    return radius * np.cos(2 * np.pi * second), radius * np.sin(2 * np.pi * second)


def brownian(n_steps, paths, sources, seed, **options):
    """Brownian motion at whole times, shape (paths, sources, n_steps + 1)."""
    found = solve_sde(
        lambda t, y: 0.0 * y, np.ones(sources), (0, n_steps), np.zeros(sources), step=1.0,
        paths=paths, t_eval=np.arange(n_steps + 1.0), rng=seed, method="EulerMaruyama", **options,
    )  # fmt: skip
    return found.y, found.key


@pytest.mark.parametrize("counter, key, words", PUBLISHED)
def test_the_reference_gives_the_published_words(counter, key, words):
    assert philox(counter, key) == words


def test_increments_are_those_of_the_reference():
    y, key = brownian(5, 11, 3, 20)
    words = key & LOW, key >> 32
    for path in range(11):
        for source in range(3):
            expected = [normal_pair(philox([i, 0, path, source], words)) for i in range(3)]
            increments = np.diff(y[path, source])
            np.testing.assert_allclose(increments, np.ravel(expected)[:5], rtol=0, atol=2e-14)


def test_numbers_are_normal_and_independent():
    """With fixed seeds, thresholds of chance 1e-6: five deviations, or Kolmogorov's."""
    y, _ = brownian(64, 4096, 4, 7)
    z = np.diff(y, axis=-1)
    assert stats.kstest(z.ravel(), "norm").pvalue > 1e-6
    n = z.size
    for k, moment, variance in ((1, 0, 1), (2, 1, 2), (3, 0, 15), (4, 3, 96)):
        assert abs((z**k).mean() - moment) < 5 * np.sqrt(variance / n)
    for axis in range(3):
        for lag in (1, 2, 3):
            moved = np.roll(z, lag, axis)
            assert abs((z * moved).mean()) < 5 / np.sqrt(n)
            assert abs(((z**2 - 1) * (moved**2 - 1)).mean()) < 5 * 2 / np.sqrt(n)


def test_halves_have_the_covariances_of_brownian_motion():
    y, _ = brownian(4, 8192, 1, 3, refine=3)
    whole, _ = brownian(4, 8192, 1, 3)
    np.testing.assert_allclose(y, whole, rtol=0, atol=1e-13)  # the same motion at whole times
    found = solve_sde(
        lambda t, y: 0.0 * y, 1.0, (0, 2), [0.0], step=1.0, paths=8192, refine=3, rng=3,
        t_eval=np.arange(17) / 8,
    )  # fmt: skip
    z = np.diff(found.y[:, 0], axis=-1) * np.sqrt(8)
    covariance = np.cov(z.T)
    assert np.abs(covariance - np.eye(16)).max() < 5 * np.sqrt(2 / 8192)
    assert stats.kstest(z.ravel(), "norm").pvalue > 1e-6


def test_large_steps_paths_and_keys_have_words_of_their_own():
    y, _ = brownian(1, 2, 1, 1)
    other, _ = brownian(1, 2, 1, 2)
    assert len({*y[:, 0, 1], *other[:, 0, 1]}) == 4
