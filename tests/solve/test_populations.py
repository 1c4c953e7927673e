"""`nonnegative` for populations and films: what is small and must not be negative."""

import numpy as np
import pytest

from fastdyn import solve_ivp


def predator(t, y):
    return [y[0] * (1.0 - y[1]), 30.0 * y[1] * (y[0] - 1.0)]


def sir(t, y):
    infected = 5.0 * y[0] * y[1]
    return [-infected, infected - y[1], y[1]]


@pytest.mark.parametrize("method", ("RK45", "Vern7", "BDF", "Rodas5P", "LSODA"))
def test_populations(method):
    for fun, start, end in ((predator, [6.0, 0.1], 20), (sir, [1.0, 1e-12, 0.0], 60)):
        found = solve_ivp(fun, (0, end), start, method, nonnegative=True, rtol=1e-4)
        assert found.status == 0 and found.y.min() >= 0.0
    assert found.y.sum(axis=0) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("method", ("BDF", "Rodas5P"))
def test_a_thin_film(method):
    """h_t = -(h^3 h_xxx)_x, a drop that spreads on an almost dry surface."""
    n = 40
    x = np.linspace(-1, 1, n + 1)[:-1]
    dx = 2.0 / n

    def film(t, h):
        third = (np.roll(h, -2) - 3 * np.roll(h, -1) + 3 * h - np.roll(h, 1)) / dx**3
        between = 0.5 * (h + np.roll(h, -1))
        flux = between**3 * third
        return -(flux - np.roll(flux, 1)) / dx

    start = np.maximum(1 - 4 * x**2, 0.0) + 1e-4
    found = solve_ivp(film, (0, 0.05), start, method, nonnegative=True, rtol=1e-5, atol=1e-8)
    assert found.status == 0 and found.y.min() >= 0.0
    assert found.y.sum(axis=0) == pytest.approx(start.sum(), rel=1e-4)
