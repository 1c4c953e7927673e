"""M y' = f(t, y) by Rodas5P, Radau and BDF: layouts, published values, matrices that change."""

import math

import numpy as np
import pytest

from fastdyn import solve_ivp
from support.masses import TAKE

TIGHT = {"rtol": 1e-9, "atol": 1e-13}


@pytest.mark.few(2)
@pytest.mark.parametrize("method", ["Radau", "BDF"])
@pytest.mark.parametrize("jac", [None, "2-point"])
def test_matrices_of_all_layouts(method, jac):
    """Full, banded and sparse ones, by all ways of elimination."""
    n = 40
    rates, ones = np.linspace(1, 100, n), np.ones(n)
    full = np.eye(n) + 0.3 * np.random.default_rng(0).standard_normal((n, n)) / n**0.5
    band = np.eye(n) + 0.25 * (np.eye(n, k=1) + np.eye(n, k=-1))
    for mass in (full, band, np.eye(n) + 0.2 * np.fliplr(np.eye(n))):
        given = {"rtol": 1e-7, "atol": 1e-9}
        run = solve_ivp(lambda t, y: ones - rates * y, (0, 1), ones, method, mass=mass, jac=jac,
                        **given)  # fmt: skip
        exact = solve_ivp(
            lambda t, y, mass=mass: np.linalg.solve(mass, ones - rates * y), (0, 1), ones,
            "DOP853", **TIGHT,
        )  # fmt: skip
        assert run.y[:, -1] == pytest.approx(exact.y[:, -1], abs=3e-7)


END = [  # at t = 0.2, as the Test Set for IVP Solvers, release 2.4, has them
    -0.5562145012262709e-2, 0.3006522471903042e1, 0.2849958788608128e1, 0.2926422536206241e1,
    0.2704617865010554e1, 0.2761837778393145e1, 0.4770927631616772e1, 0.1236995868091548e1,
]  # fmt: skip


@pytest.mark.parametrize("method", TAKE)
def test_the_transistor_amplifier(method):
    """Eight voltages, coupled by five capacitors: a matrix of rank five."""

    def amplifier(t, y):
        first = 1e-6 * (np.exp((y[1] - y[2]) / 0.026) - 1.0)
        second = 1e-6 * (np.exp((y[4] - y[5]) / 0.026) - 1.0)
        entered = 0.1 * np.sin(200.0 * np.pi * t)
        r = 9000.0
        return [
            (y[0] - entered) / 1000.0, 2 * y[1] / r - 6.0 / r + 0.01 * first, y[2] / r - first,
            (y[3] - 6.0) / r + 0.99 * first, 2 * y[4] / r - 6.0 / r + 0.01 * second,
            y[5] / r - second, (y[6] - 6.0) / r + 0.99 * second, y[7] / r,
        ]  # fmt: skip

    mass = np.zeros((8, 8))
    for first, capacity in ((0, 1e-6), (3, 3e-6), (6, 5e-6)):
        mass[first : first + 2, first : first + 2] = [[-capacity, capacity], [capacity, -capacity]]
    mass[2, 2], mass[5, 5] = -2e-6, -4e-6
    start = [0.0, 3.0, 3.0, 6.0, 3.0, 3.0, 6.0, 0.0]
    run = solve_ivp(amplifier, (0, 0.2), start, method, mass=mass, rtol=1e-7, atol=1e-7)
    assert run.y[:, -1] == pytest.approx(END, abs=1e-8 if method != "BDF" else 2e-6)


@pytest.mark.parametrize("method", TAKE)
def test_a_matrix_that_changes(method):
    """Points that move with the solution y = (exp(-t), sin(t)), M full and of t, y and a number."""

    def mass(t, y, k):
        return [[2.0 + y[1] ** 2, k * t], [y[0], 1.0 + t]]

    def fun(t, y, k):
        slope = -y[0], math.cos(t)
        return [
            (2.0 + y[1] ** 2) * slope[0] + k * t * slope[1], y[0] * slope[0] + (1 + t) * slope[1]
        ]  # fmt: skip

    run = solve_ivp(fun, (0, 2), [1.0, 0.0], method, args=(0.5,), mass=mass, rtol=1e-8, atol=1e-10)
    assert run.y[:, -1] == pytest.approx([math.exp(-2), math.sin(2)], abs=3e-6)
    with pytest.raises(ValueError, match="`jac` and a function `mass`"):
        solve_ivp(fun, (0, 2), [1.0, 0.0], method, args=(0.5,), mass=mass, jac="2-point")


@pytest.mark.parametrize("method", TAKE)
def test_a_wider_band_than_the_jacobian(method):
    mass = np.eye(4)
    mass[0, 3], mass[3, 0] = 0.5, 0.25
    rates = np.array([1.0, 2.0, 3.0, 4.0])
    run = solve_ivp(lambda t, y: -rates * y, (0, 1), np.ones(4), method, mass=mass, **TIGHT)
    slow = solve_ivp(
        lambda t, y: np.linalg.solve(mass, -rates * y), (0, 1), np.ones(4), "DOP853", **TIGHT
    )
    assert run.y[:, -1] == pytest.approx(slow.y[:, -1], rel=1e-7 if method == "Rodas5P" else 3e-6)
