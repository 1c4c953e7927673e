"""Delay equations beside exact solutions, and beside chains of shifted copies."""

import numpy as np
import pytest

from fastdyn.delays import solve_dde
from fastdyn.delays.equation import EXPLICIT
from fastdyn.kernels.output.past.steps import GROWTH, OF_GROWN, SAMPLES
from support.delayed import mackey_glass
from support.shifted_copies import end_of

TENFOLD = 10.0  # largest error over the tolerance times the size of the solution


def by_steps(n):
    """y(n) of y' = -y(t - 1), y = 1 before: the sum of (-1)^k (n - k + 1)^k / k! to k = n + 1."""
    total, term = 0.0, 1.0
    for k in range(n + 2):
        term = (-1.0) ** k * float(n - k + 1) ** k / np.prod(np.arange(1.0, k + 1))
        total += term if n - k + 1 > 0 or k == 0 else 0.0
    return total


@pytest.mark.parametrize("method", EXPLICIT)
def test_a_piecewise_polynomial_is_exact_where_the_order_suffices(method):
    """Up to t = 4 the solution has degree 4, which every method takes exactly."""
    found = solve_dde(
        lambda t, y, past: -past(t - 1.0), (0, 4), [1.0], method, rtol=1e-3, atol=1e-6
    )
    assert found.delays.tolist() == [1.0]
    assert abs(found.y[0, -1] - by_steps(4)) < 1e-14
    assert {1.0, 2.0, 3.0} <= set(found.t.tolist())


@pytest.mark.parametrize("method", EXPLICIT)
@pytest.mark.parametrize("rtol", [1e-4, 1e-7, 1e-10])
def test_errors_are_within_tolerances(method, rtol):
    found = solve_dde(
        lambda t, y, past: -past(t - 1.0), (0, 10), [1.0], method, rtol=rtol, atol=1e-2 * rtol
    )
    assert abs(found.y[0, -1] - by_steps(10)) < TENFOLD * rtol


@pytest.mark.parametrize("method", EXPLICIT)
def test_mackey_and_glass_at_500(method):
    """The reference is a chain of shifted copies to 1e-12; a tolerance of 1e-11 grows to 1e-9."""
    found = solve_dde(
        mackey_glass, (0, 500), [0.5], method, args=(0.2, 0.1, 14.0), rtol=1e-11, atol=1e-11
    )
    assert abs(found.y[0, -1] - 1.0104431117) < 1e-9


@pytest.mark.parametrize(("method", "rtol"), [("Tsit5", 3e-7), ("DOP853", 1e-6)])
def test_no_step_is_far_longer_than_the_last_by_chance(method, rtol):
    """An estimate near zero lets a step be three times as long: its residual was 16 000.

    The polynomial is compared with the equations where the solver compares them.
    """
    a, b, tau = args = 0.2, 0.1, 14.0
    found = solve_dde(
        mackey_glass, (0, 500), [0.5], method, args=args, rtol=rtol, atol=rtol, dense_output=True
    )
    h = np.diff(found.t)
    grown = 1 + np.flatnonzero(h[1:] > GROWTH * h[:-1])
    assert len(grown) > 2
    for x in SAMPLES:
        t = found.t[grown] + x * h[grown]
        late = np.where(t > tau, found.sol(np.maximum(t - tau, 0.0))[0], 0.5)
        residual = found.sol.derivative(t)[0] - a * late / (1 + late**10) + b * found.sol(t)[0]
        assert np.abs(h[grown] * residual).max() < OF_GROWN * rtol * 2.5  # y is below 1.5


@pytest.mark.parametrize("method", EXPLICIT)
def test_delays_of_the_time_and_the_state(method):
    """y = (sin t, cos t), whatever the delays."""

    def fun(t, y, past):
        early = t - 0.5 - 0.4 * y[0] ** 2
        late = t - 1.0 - 0.5 * np.sin(3 * t)
        return [
            y[1] - past(early)[0] + np.sin(early),
            -y[0] - 0.5 * past(late)[1] + 0.5 * np.cos(late),
        ]

    def before(t):
        return [np.sin(t), np.cos(t)]

    for rtol in (1e-5, 1e-9):
        found = solve_dde(fun, (0, 10), before, method, rtol=rtol, atol=rtol, dense_output=True)
        t = np.linspace(0, 10, 101)
        assert len(found.delays) == 0
        assert np.abs(found.sol(t) - [np.sin(t), np.cos(t)]).max() < 3 * TENFOLD * rtol


def test_a_delay_given_in_time():
    """DDETST B1 (Enright and Hayashi, 1997): y' = 1 - y(exp(1 - 1/t)), y = log t, behind t = 1."""
    found = solve_dde(
        lambda t, y, past: 1.0 - past(np.exp(1.0 - 1.0 / t)), (1.5, 10),
        lambda t: [np.log(t)], rtol=1e-8, atol=1e-8,
    )  # fmt: skip
    assert abs(found.y[0, -1] - np.log(10)) < TENFOLD * 1e-8 * 10


def drawn(rng):
    """A random equation of 1 to 3 components with 1 to 4 delays, its history and delays."""
    n, m = int(rng.integers(1, 4)), int(rng.integers(1, 5))
    shifts = rng.choice(np.arange(1, 8), m, replace=False).tolist()
    weights = rng.normal(size=(m, n, n)) / (2 * m * n)
    own = rng.normal(size=(n, n)) / n
    kind = rng.integers(3)

    def rate(t, y, past):
        total = own @ np.sin(y) - 0.3 * y
        for w, p in zip(weights, past, strict=True):
            total = total + w @ (np.tanh(p) if kind == 0 else p / (1 + p * p) if kind == 1 else p)
        return total + 0.2 * np.cos(t)

    start, turn = rng.normal(size=n), rng.normal(size=n)

    def history(t):
        return start + 0.3 * np.sin(turn * t)

    return rate, history, shifts


HUNTED = [pytest.param(seed, marks=pytest.mark.hunt) for seed in range(6, 60)]


@pytest.mark.parametrize("seed", [*range(6), *HUNTED])
def test_drawn_equations_beside_their_chains(seed):
    rng = np.random.default_rng(seed)
    rate, history, shifts = drawn(rng)
    unit = 0.25
    exact = end_of(rate, history, unit, shifts, 10)

    def fun(t, y, past):
        return rate(t, y, [past(t - unit * m) for m in shifts])

    for method in ("Tsit5", "Vern7"):
        found = solve_dde(fun, (0, 2.5), history, method, rtol=1e-8, atol=1e-8)
        assert found.success
        assert np.abs(found.y[:, -1] - exact).max() < TENFOLD * 1e-8 * (1 + np.abs(exact).max())
