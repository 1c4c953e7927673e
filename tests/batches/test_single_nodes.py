"""Single nodes in batches: the bits of straight code, and the values of NumPy."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fastdyn
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.code import Traced
from fastdyn.trace.paths.runs import trace
from support.pointer_forms import compiled


def steps_of(rng, n):
    """Six steps of a program on arrays, drawn."""
    shift, k = (int(i) for i in rng.integers(-4, 5, 2))
    edges = np.array([-1.0, 0.3, 1.7])

    def inside(z):
        d = np.zeros_like(z)
        d[1:-1] = z[2:] - 2 * z[1:-1] + z[:-2]
        return z + 0.1 * d

    steps = [
        lambda t, z, y, p, c: z * np.roll(y, shift) + c,
        lambda t, z, y, p, c: z - p * np.roll(z, shift),
        lambda t, z, y, p, c: np.where(z > p, z * 0.5, z + np.roll(z, shift)),
        lambda t, z, y, p, c: z - z.mean() * c,
        lambda t, z, y, p, c: inside(z),
        lambda t, z, y, p, c: np.clip(z, -2, p),
        lambda t, z, y, p, c: np.concatenate([z[k:], z[:k]]) * (1 + t),
        lambda t, z, y, p, c: np.abs(z) / (1 + z * z),
        lambda t, z, y, p, c: z + np.sum((z[:5, None] - z[None, :]) ** 2, axis=0) * 1e-3,
        lambda t, z, y, p, c: np.where((z < 1) & ~(y < p) | (z == c), z, -z),
        lambda t, z, y, p, c: z + np.interp(y, edges, [0.0, 1.0, 0.5]),
    ]
    return [steps[i] for i in rng.integers(0, len(steps), 6)]


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", range(16))
def test_loops_have_the_bits_of_straight_code(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(17, 50))
    steps = steps_of(rng, n)

    def fun(t, y, p, c):
        z = y
        for step in steps:
            z = step(t, z, y, p, c)
        return z

    args = rng.standard_normal(n), float(rng.standard_normal())
    loops = compiled(fun, n, args, True, monkeypatch)
    straight = compiled(fun, n, args, False, monkeypatch)
    for i in range(20):
        t, y = 0.1 * i, 3 * rng.standard_normal(n)
        assert np.array_equal(loops(t, y), straight(t, y), equal_nan=True)


def heat(t, u):
    return np.roll(u, 1) - 2 * u + np.roll(u, -1)


def phases(t, y, omega, strength):
    return omega + strength / len(y) * np.sum(np.sin(y[None, :] - y[:, None]), axis=1)


def plane(t, w):
    u = w.reshape(20, 20)
    shifted = [np.roll(u, s, axis) for axis in (0, 1) for s in (1, -1)]
    return (sum(shifted) - 4 * u + u * (1 - u)).ravel()


def bodies(t, w):
    r, v = w[:36].reshape(12, 3), w[36:]
    a = np.zeros((12, 3))
    for i in range(12):
        for j in range(12):
            if i != j:
                d = r[j] - r[i]
                a[i] += d / np.linalg.norm(d) ** 3
    return np.concatenate([v, a.ravel()])


def of_all_functions(t, y):
    z = 1.5 + np.tanh(y)
    with_two = np.arctan2(z, y) + z**y + np.hypot(y, 1.0)
    return np.exp(-z) + np.log(z) * np.cos(y) - np.sinh(z) / np.cbrt(z) + np.arctan(y) * with_two


def at_another_time(t, y):
    return np.sin(t) * y + np.cos(y * t) + np.array([i % 3 for i in range(len(y))])


@pytest.mark.parametrize(
    ("fun", "n", "args"),
    [
        (heat, 1000, ()),
        (plane, 400, ()),
        (bodies, 72, ()),
        (phases, 30, (np.linspace(-1, 1, 30), 2.0)),
        (of_all_functions, 100, ()),
        (at_another_time, 200, ()),
    ],
)
def test_loops_have_the_values_of_numpy(fun, n, args, monkeypatch):
    """Elementary functions and powers err by some units of the last place, sums by n of them."""
    call = compiled(fun, n, args, True, monkeypatch)
    rng = np.random.default_rng(1)
    for t in (0.0, 0.7, 30.0):
        y = rng.standard_normal(n)
        expected = fun(t, y, *args)
        bound = 16 * np.finfo(float).eps * n**0.5 * max(1.0, np.abs(expected).max())
        assert np.abs(call(t, y) - expected).max() < bound


def test_the_code_grows_with_the_formula_not_with_the_state():
    def length(n):
        return len(Traced(trace(heat, (), n, (n,)), DERIVATIVE, n).text("f").splitlines())

    assert length(4000) == length(1000) < 200


@pytest.mark.filterwarnings("error")  # it is compiled
def test_a_large_function_answers_as_scipy_does():
    y0 = np.sin(np.linspace(0, 6, 1000)) ** 2
    mine, other = fastdyn.solve_ivp(heat, (0, 2), y0), solve_ivp(heat, (0, 2), y0)
    assert mine.nfev == other.nfev
    assert np.allclose(mine.y, other.y, rtol=1e-12, atol=1e-12)


def test_where_a_large_function_raises():
    def logs(t, y):
        return np.array([math.log(3.0 - v) - t for v in y])

    y0 = np.linspace(0, 1, 80)
    with pytest.raises(ValueError, match=r"math domain error|expected a positive"):
        fastdyn.solve_ivp(lambda t, y: -logs(t, y) + 3, (0, 50), y0)


@pytest.mark.filterwarnings("error")
def test_new_parameters_need_no_new_code():
    y0, omega = np.linspace(0, 6, 40), np.linspace(-1, 1, 40)
    for strength in (0.5, 2.0):
        omega[3] += strength
        mine = fastdyn.solve_ivp(phases, (0, 3), y0, args=(omega, strength))
        other = solve_ivp(phases, (0, 3), y0, args=(omega, strength))
        assert np.allclose(mine.y[:, -1], other.y[:, -1], rtol=1e-10, atol=1e-10)
