"""Variational equations in loops over columns: complex steps, and the formula node by node."""

import numpy as np
import pytest

from fastdyn import solve_ivp
from fastdyn.compile.compare import called, machine_value
from fastdyn.compile.derivatives.sensitivities import bind_variational
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.make import Near
from fastdyn.problem.sensitivities import Variational

N, EPS = 12, np.finfo(float).eps


def mixed(t, y, a, b):
    """Rows of 0, 1, 3, 5 and 12 terms; `a` acts on few rows, `b` on all of the row with 12."""
    coupled = y[2:] * np.roll(y, 1)[2:] - np.sin(y[:-2]) * a[0]
    first = (b * y * y).sum() + t
    return np.concatenate([[np.exp(-a[-1] * t)], coupled, [first]])


def by_complex_steps(args, directions, t, z):
    """[f, df/dy S + df/dp] by complex steps, which are exact to rounding."""
    y, s, h = z[:N], z[N:].reshape(N, -1), 1e-30
    slopes, at = np.empty_like(s), 0
    for j in directions:
        for i in range(N if j == 0 else args[j - 1].size):
            moved = [np.array(a, complex) for a in args]
            if j:
                moved[j - 1][i] += 1j * h
            slopes[:, at] = mixed(t, y + 1j * h * s[:, at], *moved).imag / h
            at += 1
    return np.r_[mixed(t, y, *args), slopes.ravel()]


def bound_to(args, directions):
    m = sum(N if j == 0 else args[j - 1].size for j in directions)
    equations = Variational(mixed, DERIVATIVE, N, directions, m, N)
    return bind_variational(equations, args, Near(0.0, 1.0, np.linspace(0.5, 1, N))), m


@pytest.mark.few
@pytest.mark.parametrize("directions", [(1,), (0, 1, 2)])
@pytest.mark.parametrize("length", [3, 8, 23])
def test_complex_steps_and_single_nodes(length, directions):
    rng = np.random.default_rng(length)
    args = rng.normal(size=length), rng.normal(size=N)
    bound, m = bound_to(args, directions)
    z, t = rng.normal(size=N * (1 + m)), 0.4
    size = np.abs(z).max() ** 2 * max(np.abs(a).max() for a in args)
    rounding = 2 * N * EPS * size  # of 13 terms, each of up to 3 factors
    found = machine_value(bound, t, z)
    assert np.abs(found - by_complex_steps(args, directions, t, z)).max() < rounding
    traced = bound.function.traced
    assert traced.key().startswith("columns")
    straight = traced.with_outputs(traced.stored, bound.mode, len(z)).compiled()
    assert np.abs(called(bound, straight, len(z), t, z)[0] - found).max() < rounding


def test_many_factors_lie_on_the_heap():
    """A dense layer: 70 x 70 weights, more factors than the stack takes."""
    n = 70

    def layer(t, y, w):
        return np.tanh(w @ y)

    rng = np.random.default_rng(0)
    w, y0 = rng.normal(size=(n, n)) / n, rng.normal(size=n)
    at = {"t_eval": [0.5], "rtol": 1e-9, "atol": 1e-9}
    r = solve_ivp(layer, (0, 0.5), y0, args=(w,), sensitivity="w", **at)
    assert r.sensitivity["w"].shape == (n, n, n, 1)
    h, moved = 1e-5, np.zeros((n, n))
    moved[3, 5] = h
    ends = [solve_ivp(layer, (0, 0.5), y0, args=(w + s * moved,), **at).y for s in (1, -1)]
    assert np.abs(r.sensitivity["w"][:, 3, 5] - (ends[0] - ends[1]) / (2 * h)).max() < 1e-7


def test_a_limit_in_the_state_that_does_not_change_is_met_as_a_constant_is():
    k, y0 = np.linspace(0.5, 1, 39), np.linspace(0.4, 1, 40)

    def found(limit):
        def ramp(t, y, k):
            faster = 1.0 + 2.0 * np.maximum(t - limit(y), 0.0)
            return np.concatenate([np.zeros(1), np.roll(y[1:], 1) - k * y[1:] * faster])

        return solve_ivp(ramp, (0, 1), y0, args=(k,), rtol=1e-9, atol=1e-9, sensitivity="k")

    held, constant = found(lambda y: y[0]), found(lambda y: y0[0])
    assert np.array_equal(held.t, constant.t)
    assert np.abs(held.sensitivity["k"] - constant.sensitivity["k"]).max() < 1e-13


def test_a_function_that_raises_does_so_with_its_sensitivities():
    def raises(t, y, k):
        if y[0] > 2.0:
            raise ValueError("too far")
        return k * y[::-1]

    given = {"args": (np.ones(6),), "sensitivity": "k"}
    with pytest.raises(ValueError, match="too far"):
        solve_ivp(raises, (0, 5), np.ones(6), **given)
    assert solve_ivp(raises, (0, 0.3), np.ones(6), **given).success


def test_implicit_methods_have_the_jacobian_of_all_numbers():
    rng = np.random.default_rng(1)
    args, y0 = (rng.uniform(0.5, 1, 3), rng.uniform(0.5, 1, N)), np.linspace(0.5, 1, N)
    given = {"args": args, "rtol": 1e-8, "atol": 1e-8, "t_eval": [0.3], "sensitivity": ("y0", "a")}
    explicit = solve_ivp(mixed, (0, 0.3), y0, "DOP853", **given)
    implicit = solve_ivp(mixed, (0, 0.3), y0, "Radau", **given)
    assert implicit.njev < 10
    for name in explicit.sensitivity:
        assert np.allclose(explicit.sensitivity[name], implicit.sensitivity[name], atol=1e-6)
