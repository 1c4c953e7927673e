"""Derivatives by a sweep back over the steps of Radau and of the Gauss methods."""

import numpy as np
import pytest

from fastdyn import solve_ivp
from fastdyn.kernels.methods import METHODS
from fastdyn.kernels.methods.radau.stages import C, P
from fastdyn.solve.adjoint.keeping import Keeping
from support.discrete_solution import by_complex_steps, flat
from support.stiff_gradients import SYSTEMS, on_complex, slopes

EPS = np.finfo(float).eps
A = np.linalg.inv((P @ np.array([np.ones(3), 2 * np.array(C), 3 * np.array(C) ** 2])).T)
GAUSS = [n for n, m in METHODS.items() if m.backward == "collocation" and not m.error_order]


def stages(name, fun, t, h, y, z, args):
    """The stages of a step of Radau, less y, by Newton's iteration for complex numbers."""
    n = len(y)
    for _ in range(12):
        f = [fun(t + c * h, y + x, *args) for c, x in zip(C, z, strict=True)]
        jac = [slopes(name, t + c * h, y + x, args)[0] for c, x in zip(C, z, strict=True)]
        matrix = np.eye(3 * n, dtype=complex)
        for i in range(3):
            for j in range(3):
                matrix[i * n : i * n + n, j * n : j * n + n] -= h * A[i, j] * jac[j]
        gap = h * A @ np.array(f) - z
        z = z + np.linalg.solve(matrix, gap.ravel()).reshape(3, n)
    return z


def replayed(name, fun, steps, y, args, t_eval):
    """The outputs of the steps, from the states of the solve with other small imaginary parts."""
    found, fun = [], on_complex(fun)
    for i, (t, end) in enumerate(zip(steps.t[:-1], steps.t[1:], strict=True)):
        h, new = end - t, steps.y[:, i + 1]
        z = stages(name, fun, t, h, y, np.outer(C, new - y.real), args)
        for time in t_eval[(t_eval > t) & (t_eval <= end)]:
            x = (time - t) / h
            found.append(y + P @ np.array([x, x**2, x**3]) @ z)
        y = new + 1j * (y + z[2]).imag
    return np.array(found).T


@pytest.mark.hunt
@pytest.mark.parametrize("name", SYSTEMS)
def test_the_derivatives_are_exact_for_the_steps_of_radau(name):
    """Complex steps from the states of the solve, relative to the effect of each number."""
    fun, span, y0, args = SYSTEMS[name]
    t_eval, how = np.linspace(*span, 6)[1:], {"args": args, "rtol": 1e-6, "atol": 1e-9}
    r = solve_ivp(fun, span, y0, "Radau", t_eval, **how, adjoint=("y0", "args"))
    steps = solve_ivp(fun, span, y0, "Radau", **how)
    g = np.random.default_rng(0).normal(size=r.y.shape)

    def number(*values):
        n = len(y0)
        y = replayed(name, fun, steps, np.array(values[:n]) + 0j, values[n:], t_eval)
        return (g * y).sum()

    assert np.isclose(number(*y0, *args).real, (g * r.y).sum(), rtol=1e-5)
    exact, found = by_complex_steps(number, y0, args), flat(r.vjp(g))
    sizes = np.maximum(np.abs([*y0, *args]), 1e-3)
    assert np.abs((found - exact) * sizes).max() <= 1e-10 * np.abs(exact * sizes).max()


def forced(t, y, a, b, c):
    q, p, u, w = y
    return [u, w, -q - 2 * a * q * p + 0.1 * np.sin(t), -b * p - a * q * q + c * p * p]


def as_forward(r, s, g):
    """The derivatives of a result with `vjp`, and those by a result with `sensitivity`."""
    exact = {k: np.einsum("i...k,ik->...", each, g) for k, each in s.sensitivity.items()}
    return flat(r.vjp(g)), flat(exact)


@pytest.mark.few(1)
@pytest.mark.parametrize("name", GAUSS)
@pytest.mark.parametrize(
    ("span", "t_eval", "room"), [((0, 3), None, 30), ((1, -2), [0.7, 0.2, -2], Keeping.room)]
)
def test_gauss_as_forward(name, span, t_eval, room, monkeypatch):
    """The tangent maps of the steps; the last step passes the end of the span."""
    monkeypatch.setattr("fastdyn.solve.adjoint.solve.ROOM", room)
    given = (forced, span, [0.1, 0.2, 0.3, 0.0], name, t_eval)
    how = {"args": (1.0, 0.7, 1.1), "step": 0.07}
    r = solve_ivp(*given, **how, adjoint=("y0", "args"))
    s = solve_ivp(*given, **how, sensitivity=("y0", "args"))
    g = np.random.default_rng(0).normal(size=r.y.shape)
    assert r.vjp._legs[0].is_whole == (room > 30)
    found, exact = as_forward(r, s, g)
    assert np.abs(found - exact).max() <= 200 * EPS * np.abs(exact).max()


@pytest.mark.hunt
@pytest.mark.parametrize("room", [Keeping.room, 40])
def test_radau_as_forward(room, monkeypatch):
    """On a ring, whose matrix is a band in another order, to the tolerance; also by segments."""
    monkeypatch.setattr(Keeping, "room", room)

    def ring(t, u, flow, source):
        return flow * (np.roll(u, 1) - 2 * u + np.roll(u, -1)) + source * u * (1 - u)

    n = 40
    given = (ring, (0, 1), 0.5 + 0.4 * np.sin(np.arange(n)), "Radau", [0.3, 1.0])
    how = {"args": (50.0 + np.arange(n), 0.7), "rtol": 1e-8, "atol": 1e-10}
    r = solve_ivp(*given, **how, adjoint=("y0", "args"))
    assert r.vjp._backward.fields[-2:][0] == 3 * 2 + 2
    s = solve_ivp(*given, **how, sensitivity=("y0", "args"))
    found, exact = as_forward(r, s, np.random.default_rng(0).normal(size=r.y.shape))
    assert np.abs(found - exact).max() <= 1e-6 * np.abs(exact).max()


def test_what_cannot_be_solved_again_is_told(monkeypatch):
    """Here, because nothing is near enough; a matrix of all stages that is too large."""
    monkeypatch.setattr("fastdyn.kernels.methods.adjoint.NEAR", 0.0)
    fun, span, y0, args = SYSTEMS["forced"]
    r = solve_ivp(fun, span, y0, "Radau", [1.0], args=args, adjoint="args")
    with pytest.raises(ValueError, match=r"step from t = .* cannot be solved again"):
        r.vjp([[1.0], [1.0]])
    monkeypatch.setattr("fastdyn.solve.adjoint.backward.MOST", 30)
    with pytest.raises(ValueError, match=r"of Radau would factorise a matrix of 6 x 6"):
        solve_ivp(fun, span, y0, "Radau", [1.0], args=args, adjoint="args")
