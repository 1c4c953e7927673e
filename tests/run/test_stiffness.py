"""Explicit methods notice that stability holds them back."""

import inspect
import math
import warnings
from fractions import Fraction

import numpy as np
import pytest

import fastdyn
from fastdyn.compile import memory
from fastdyn.kernels.methods import METHODS
from fastdyn.kernels.methods.method import stability_polynomial
from fastdyn.kernels.methods.taylor import accuracy
from fastdyn.run import stiffness
from fastdyn.solve import automatic


@pytest.mark.parametrize("name", [name for name, m in METHODS.items() if m.stable_to])
def test_limits_are_those_of_the_tables(name):
    """R(z) = 1 + z b (1 - z A)^-1 (1, 1, ...)."""
    method, s = METHODS[name], METHODS[name].n_stages
    a, b = np.zeros((s, s)), np.array([float(x) for x in method.tableau["b"].exact])[:s]
    for i, row in enumerate(method.tableau["a"][:s]):
        a[i, : len(row.exact)] = [float(x) for x in row.exact]

    def growth(z):
        return abs(1.0 - z * (b @ np.linalg.solve(np.eye(s) + z * a, np.ones(s))))

    inside = np.linspace(0.01, method.stable_to, 500)
    assert max(map(growth, inside)) <= 1.0 < growth(method.stable_to + 0.02)


def test_limits_of_oscillations_follow_from_the_tables():
    """A growth of 1e-4 a step is none that a run of some thousand steps shows."""
    found, z = {}, np.arange(1, 4000) / 400
    named = inspect.getsource(automatic)
    for name in [n for n, method in METHODS.items() if method.is_pair and f'"{n}"' in named]:
        growth = abs(np.polyval(stability_polynomial(METHODS[name].tableau), 1j * z))
        found[name] = np.floor(20 * z[(growth > 1 + 1e-4).argmax()]) / 20
    assert found == stiffness.ON_THE_IMAGINARY_AXIS


@pytest.mark.parametrize("order", stiffness.OF_SERIES)
def test_limits_of_series(order):
    """R(z) is the first terms of the exponential series, in whole numbers of hundredths."""

    def growth(hundredths):
        z = Fraction(-hundredths, 100)
        return abs(sum(z**k / math.factorial(k) for k in range(order + 1)))

    end = round(100 * stiffness.OF_SERIES[order])
    assert order in accuracy.ALLOWANCE and len(stiffness.OF_SERIES) == len(accuracy.ALLOWANCE)
    assert max(map(growth, range(1, end))) <= 1 < growth(end)


def decay(t, y, rate):
    return [-rate * (y[0] - np.cos(t)) - np.sin(t)]


def diffusion(t, y):
    inner = np.zeros(len(y) + 2)
    inner[1:-1] = y
    return (len(y) + 1) ** 2 * (inner[2:] - 2.0 * y + inner[:-2]) + 1.0


@pytest.fixture(autouse=True)
def nothing_was_asked():
    memory.forget()


@pytest.mark.parametrize("method", ["RK23", "RK45", "DOP853", "Vern7", "Taylor"])
def test_stiff_problems_are_named_once(method):
    given = (decay, (0, 20), [1.0], method)
    with pytest.warns(
        fastdyn.StiffnessWarning, match=rf"{method} took .* -1e\+03 of .*'Rodas5P' or"
    ):
        fastdyn.solve_ivp(*given, args=(1e3,))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fastdyn.solve_ivp(*given, args=(1e3,))
    with pytest.warns(fastdyn.StiffnessWarning, match="'BDF' or"):
        fastdyn.solve_ivp(diffusion, (0, 2), np.ones(40), method)


def test_what_is_named_takes_complex_states():
    with pytest.warns(fastdyn.StiffnessWarning, match="'BDF' or"):
        fastdyn.solve_ivp(decay, (0, 20), [1.0 + 0j], "RK45", args=(1e3,))


def lorenz(t, y):
    return [10 * (y[1] - y[0]), y[0] * (28 - y[2]) - y[1], y[0] * y[1] - 8 / 3 * y[2]]


def test_others_are_not():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for rtol in (1e-3, 1e-6, 1e-9):
            fastdyn.solve_ivp(lambda t, y: [y[1], -y[0]], (0, 5000), [1.0, 0.0], rtol=rtol)
            fastdyn.solve_ivp(lorenz, (0, 500), [1.0, 1.0, 1.0], rtol=rtol)
            fastdyn.solve_ivp(decay, (0, 9000), [1.0], args=(1.0,), rtol=rtol)
            fastdyn.solve_ivp(lorenz, (0, 500), [1.0, 1.0, 1.0], "Taylor", rtol=rtol)
            fastdyn.solve_ivp(decay, (0, 9000), [1.0], "Taylor", args=(1.0,), rtol=rtol)
        fastdyn.solve_ivp(decay, (0, 20), [1.0], "BDF", args=(1e3,))


def test_a_twisting_controller_is_named():
    """The switchings accumulate at t = 3.64, at the origin, as a geometric series."""

    def twisting(t, y):
        return [y[1], -3 * np.sign(y[0]) - 1.5 * np.sign(y[1])]

    run = fastdyn.solve_ivp(twisting, (0, 10), [1.0, 0.0], "Taylor")
    assert run.status == -1 and "a point on 2 switches of `fun` at once" in run.message
    once = fastdyn.solve_ivp(lambda t, y: [y[0] ** 2 + np.sign(y[0])], (0, 10), [1.0], "Taylor")
    assert once.status == -1 and "switches" not in once.message


def spread(w):
    sides = np.roll(w, 1, 0) + np.roll(w, -1, 0) + np.roll(w, 1, 1) + np.roll(w, -1, 1)
    return sides - 4 * w


def heat(t, y, d):
    w = y.reshape(32, 64)
    return (d * spread(w) + 1 - w).ravel()


def two_species(t, y, d):
    u, v = y.reshape(2, 32, 32)
    du, dv = d * spread(u) + 1 - u * v, d * spread(v) + u * v - v
    return np.concatenate([du.ravel(), dv.ravel()])


@pytest.mark.parametrize(("fun", "d", "told"), [
    (heat, 100.0, True),  # BDF takes two thirds of the time
    (two_species, 100.0, False),  # BDF takes as long: 14 factorisations of 12 ms
    (two_species, 400.0, True),
])  # fmt: skip
def test_the_price_of_matrices_decides(fun, d, told):
    start = 1.0 + 0.1 * np.random.default_rng(0).random(2048)

    def own(t, y, d):  # notes are of a function
        return fun(t, y, d)

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        run = fastdyn.solve_ivp(own, (0, 12), start, "Tsit5", args=(d,))
    stiff = [w for w in said if issubclass(w.category, fastdyn.StiffnessWarning)]
    assert run.n_accepted > stiffness.MANY and len(stiff) == told
