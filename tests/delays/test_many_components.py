"""Delay equations of many components: in loops, in batches, and as Python computes them."""

import numpy as np
import pytest

from fastdyn import CompileWarning
from fastdyn.delays import solve_dde

RTOL = 1e-6  # sums in another order change the step sizes, and states by a part of the tolerance
OPTIONS = {"rtol": RTOL, "atol": 1e-8}


def ring(n, taus):
    """Oscillators that see their neighbour late, in loops and with arrays."""
    rates = np.linspace(0.8, 1.2, n)

    def singly(t, y, past, k):
        return [
            rates[i] + k * np.sin(past(t - taus[i % len(taus)])[i - 1] - y[i]) for i in range(n)
        ]

    def together(t, y, past, k):
        late = np.roll(past(t - taus[0]), 1)
        return rates + k * np.sin(late - y)

    return singly, together


@pytest.mark.parametrize("n", [4, 10, 70, 300])
def test_components_one_by_one_and_as_an_array(n):
    singly, together = ring(n, [1.0])
    start = np.linspace(0, 6, n)
    one = solve_dde(singly, (0, 6), start, args=(0.3,), **OPTIONS)
    other = solve_dde(together, (0, 6), start, args=(0.3,), **OPTIONS)
    assert one.delays.tolist() == other.delays.tolist() == [1.0]
    np.testing.assert_allclose(one.y, other.y, rtol=RTOL)


def test_many_reads_of_the_past_are_those_of_python():
    """Twelve reads at three delays, which form rows of equal operations."""
    singly, _ = ring(12, [0.5, 0.75, 1.0])
    start = np.linspace(0, 6, 12)
    traced = solve_dde(singly, (0, 4), start, args=(0.3,), **OPTIONS)
    seen = []

    def noted(t, y, past, k):
        seen.append(float(str(t)))
        return singly(t, y, past, k)

    with pytest.warns(CompileWarning):
        python = solve_dde(noted, (0, 4), start, args=(0.3,), delays=[0.5, 0.75, 1.0], **OPTIONS)
    np.testing.assert_allclose(traced.t, python.t, rtol=RTOL)
    np.testing.assert_allclose(traced.y, python.y, rtol=RTOL)
