"""Delay equations of many components: in loops, in batches, and as Python computes them."""

import numpy as np
import pytest

from fastdyn import CompileWarning
from fastdyn.delays import points, solve_dde

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


def test_delays_of_an_array_in_a_loop_over_components():
    """Times of the past that are numbers of rows, of an array from outside."""
    n = 100
    taus = np.random.default_rng(1).choice([0.5, 0.8, 1.1, 1.7, 2.3], n)
    rates = np.linspace(0.8, 1.2, n)

    def singly(t, y, past, k):
        return [rates[i] + k * np.sin(past(t - taus[i])[i - 1] - y[i]) for i in range(n)]

    def by_delay(t, y, past, k):
        late = np.empty(n) * y
        for tau in np.unique(taus):
            late = np.where(taus == tau, np.roll(past(t - tau), 1), late)
        return rates + k * np.sin(late - y)

    start = np.linspace(0, 6, n)
    one = solve_dde(singly, (0, 4), start, args=(0.3,), **OPTIONS)
    other = solve_dde(by_delay, (0, 4), start, args=(0.3,), **OPTIONS)
    assert one.delays.tolist() == other.delays.tolist() == [0.5, 0.8, 1.1, 1.7, 2.3]
    np.testing.assert_allclose(one.y, other.y, rtol=10 * RTOL)


def test_points_of_many_delays_are_bounded(monkeypatch):
    """Thirty delays make 10^5 points to order 5; behind FEW, residuals are bounded instead."""
    n = 30
    taus = np.random.default_rng(2).uniform(0.5, 3.0, n)
    rates = np.linspace(0.8, 1.2, n)

    def fun(t, y, past, k):
        return [rates[i] + k * np.sin(past(t - taus[i])[i - 1] - y[i]) for i in range(n)]

    start = np.linspace(0, 6, n)
    found = solve_dde(fun, (0, 4), start, "Tsit5", args=(0.9,), rtol=1e-6, atol=1e-6)
    assert len(found.delays) == n and len(found.t) < 1000
    monkeypatch.setattr(points, "FEW", 10**9)
    whole = solve_dde(fun, (0, 4), start, "Tsit5", args=(0.9,), rtol=1e-6, atol=1e-6, max_step=9)
    assert len(whole.t) > 2 * len(found.t)
    assert np.abs(found.y[:, -1] - whole.y[:, -1]).max() < 10 * 1e-6 * 7  # y is below 7


@pytest.mark.parametrize("n", [40, 300])
def test_a_delay_for_each_component(n):
    """Reads of single components, beside the same equations with whole past states in Python."""
    taus = np.random.default_rng(3).uniform(0.5, 2.0, n)
    rates = np.linspace(0.8, 1.2, n)

    def fun(t, y, past, k):
        return [rates[i] + k * np.sin(past(t - taus[i])[i - 1] - y[i]) for i in range(n)]

    start = np.linspace(0, 6, n)
    before = {"args": (0.3,), "t_eval": [1.0, 3.0], **OPTIONS}
    found = solve_dde(fun, (0, 3), start, **before)
    assert len(found.delays) == n
    tight = solve_dde(fun, (0, 3), start, **{**before, "rtol": 1e-9, "atol": 1e-9})
    assert np.abs(found.y - tight.y).max() < 10 * RTOL * 7  # y is below 7
    whole = solve_dde(fun, (0, 3), start, dense_output=True, args=(0.3,), **OPTIONS)
    late = [whole.sol(3.0 - tau)[i - 1] for i, tau in enumerate(taus)]
    slope = rates + 0.3 * np.sin(late - whole.y[:, -1])
    np.testing.assert_allclose(whole.sol.derivative(3.0), slope, rtol=0, atol=1e-5)


@pytest.mark.parametrize("method", ["Vern7", "Rodas5P", "Radau"])
def test_components_alone_and_whole_states_are_equal(method):
    """Forty components: one is read alone, all are read at once, and with sensitivities."""
    n = 40

    def alone(t, y, past, a, tau):
        return [-a * y[i] + past(t - tau)[5] - past(t - 0.3)[i - 1] for i in range(n)]

    def together(t, y, past, a, tau):
        p = past(t - tau)
        return -a * y + p[5] - np.roll(past(t - 0.3), 1)

    given = (0, 2), np.linspace(0.5, 1, n), method
    options = {"args": (2.0, 0.7), "rtol": 1e-7, "atol": 1e-8}
    one = solve_dde(alone, *given, **options)
    other = solve_dde(together, *given, **options)
    np.testing.assert_allclose(one.y[:, -1], other.y[:, -1], rtol=0, atol=1e-12)
    if method == "Vern7":
        one, other = [
            solve_dde(f, *given, sensitivity=["a", "tau"], t_eval=[2.0], **options)
            for f in (alone, together)
        ]
        for name in ("a", "tau"):
            np.testing.assert_allclose(
                one.sensitivity[name], other.sensitivity[name], rtol=0, atol=1e-10
            )


def pairs_of_ring(n):
    """Oscillators each of which sees every other at a delay of the pair."""
    taus = np.random.default_rng(4).uniform(0.2, 1.5, (n, n))

    def fun(t, y, past, k):
        total = np.zeros(n)
        for i in range(n):
            for j in range(n):
                total[i] += np.sin(past(t - taus[i, j])[j] - y[i])
        return k / n * total - 0.1 * y

    return fun, taus


@pytest.mark.parametrize("method", ["Vern7", "Rodas5P"])
def test_a_delay_for_each_pair(method):
    """Reads of one component at delays of their own, in rows of equal operations."""
    fun, taus = pairs_of_ring(10)
    start = np.linspace(0, 1, 10)
    before = {"args": (0.5,), "t_eval": [1.0, 2.0], "rtol": 1e-8, "atol": 1e-8}
    found = solve_dde(fun, (0, 2), start, method, **before)
    assert len(found.delays) == 100
    sampled = solve_dde(fun, (0, 2), start, dense_output=True, **{**before, "t_eval": None})
    assert np.abs(sampled.sol([1.0, 2.0]) - found.y).max() < 10 * 1e-8  # ten tolerances
    late = np.array([[sampled.sol(2.0 - tau)[j] for j, tau in enumerate(row)] for row in taus])
    end = sampled.sol(2.0)
    slope = 0.05 * np.sin(late - end[:, None]).sum(axis=1) - 0.1 * end
    assert np.abs(sampled.sol.derivative(2.0) - slope).max() < 1e-6  # less an order, see above


def test_sensitivities_of_a_delay_for_each_pair():
    fun, _ = pairs_of_ring(9)
    start = np.linspace(0, 1, 9)
    tight = {"t_eval": [1.0], "rtol": 1e-10, "atol": 1e-10}
    found = solve_dde(fun, (0, 1), start, args=(0.5,), sensitivity="k", **tight)
    more, less = [solve_dde(fun, (0, 1), start, args=(k,), **tight).y for k in (0.501, 0.499)]
    assert np.abs(found.sensitivity["k"] - (more - less) / 0.002).max() < 1e-6
