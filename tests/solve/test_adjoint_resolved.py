"""Derivatives by what the steps of a solve do not resolve: other steps are taken, or none."""

import numpy as np
import pytest
from scipy.linalg import expm

from fastdyn import solve_ivp
from support.discrete_solution import by_complex_steps, flat

TIMES, Y0 = np.linspace(0, 3, 7), [1e-9, 0.0, 1.0]


def driven(t, y, w):
    """An oscillation far below the tolerance drives a slow decay."""
    return [w * y[1], -w * y[0], y[0] - 0.1 * y[2]]


def solved(method, w, **options):
    how = {"args": (w,), "rtol": 1e-6, "atol": 1e-6, "adjoint": ("y0", "args")}
    return solve_ivp(driven, (0, 3), Y0, method, TIMES, **how, **options)


@pytest.mark.few(1)
@pytest.mark.parametrize("method", ["RK45", "Tsit5", "DOP853", "Rodas5P", "Radau"])
def test_a_hidden_oscillation(method):
    """The derivatives by its amplitude are of order one, and were wrong in the first digit."""
    g = np.random.default_rng(0).normal(size=(3, len(TIMES)))

    def number(*values):
        *y0, w = values
        matrix = np.array([[0, w, 0], [-w, 0, 0], [1, 0, -0.1]])
        y = [expm(t * matrix) @ np.array(y0) for t in TIMES]
        return (g * np.array(y).T).sum()

    for w in (200.0, 210.0, 220.0, 230.0, 240.0, 250.0):
        r = solved(method, w)
        found, exact = flat(r.vjp(g)), by_complex_steps(number, Y0, (w,))
        assert np.abs(found - exact).max() < 1e-3 * np.abs(exact).max()
        assert len(r.vjp._legs[0].t) > 50 * w * 3 / 100 > r.vjp._problem.t_eval[-1]
        assert np.array_equal(flat(r.vjp(g)), found)


def test_nothing_else_is_solved_again(monkeypatch):
    """Compared gradients agree; outputs at each step, parameters that are arrays or zero."""
    calls = []

    def fun(t, y, k, c):
        return [y[1], -k[0] * np.sin(y[0]) - k[1] * y[1] + c * np.cos(t)]

    def legs(self, *given):
        calls.append(original(self, *given))
        return calls[-1]

    from fastdyn.solve.adjoint.along import Along

    original = Along.legs
    monkeypatch.setattr(Along, "legs", legs)
    for adjoint in ("y0", "args", "c", ("k", "y0")):
        for t_eval in ([2.0, 5.0], None):
            r = solve_ivp(
                fun, (0, 5), [1.0, 0.0], "Tsit5", t_eval, args=(np.array([2.0, 0.0]), 0.0),
                rtol=1e-6, adjoint=adjoint,
            )  # fmt: skip
            r.vjp(np.cos(r.y))
    assert len(calls) >= 4 and not any(calls)
