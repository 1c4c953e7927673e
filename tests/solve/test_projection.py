"""Claims about projection: every state that is shown is on the manifold."""

import math

import numpy as np
import pytest

import fastdyn
from fastdyn import solve_ivp
from fastdyn.kernels.methods import METHODS
from fastdyn.systems import pendulum_xy

ADAPTIVE = [name for name, m in METHODS.items() if m.error_order and m.projects]

EPS = np.finfo(float).eps


@pytest.mark.parametrize("method, options", [("VelocityVerlet", {"step": 0.1}), ("BDF", {})])
def test_methods_without_projection_are_told_those_that_have_it(method, options):
    others = [name for name, m in METHODS.items() if m.error_order and not m.projects]
    assert others == ["BDF", "LSODA"]
    with pytest.raises(ValueError, match=f"{method} does not .*, except for BDF and LSODA"):
        solve_ivp(
            lambda t, y: [y[1], -y[0]], (0, 1), [1.0, 0.0], method, project=lambda t, y: y,
            **options,
        )  # fmt: skip


@pytest.mark.parametrize("method", [*ADAPTIVE, "RK4"])
def test_projection_keeps_the_pendulum_on_its_circle(method):
    system = pendulum_xy(V0=4.0)
    options = {"step": 0.02} if method == "RK4" else {}
    free = system.solve((0.0, 30.0), method=method, **options)
    held = system.solve((0.0, 30.0), method=method, project=True, **options)
    at = system.solve(
        (0.0, 30.0), method=method, project=True, t_eval=np.linspace(0, 30, 77), **options
    )
    drifted = max(np.abs(v).max() for v in free.residuals().values())
    for run in (held, at):
        kept = max(np.abs(v).max() for v in run.residuals().values())
        assert kept <= 16 * EPS and drifted > 1e4 * kept
    if not METHODS[method].n_matrices:
        assert held.nfev == METHODS[method].n_stages * (held.n_accepted + held.n_rejected) + (
            held.n_accepted + (2 if METHODS[method].start.endswith(".hairer") else 1)
        )
    assert np.abs(held.error()).max() < np.abs(free.error()).max()


def test_ten_thousand_periods_on_the_circle():
    system = pendulum_xy(V0=4.0)
    t_end = 1e4 * system.period
    run = system.solve((0.0, t_end), project=True, t_eval=np.linspace(0, t_end, 1000))
    assert max(np.abs(v).max() for v in run.residuals().values()) <= 16 * EPS


def test_projection_is_bit_identical_in_chunks_and_tiers(monkeypatch):
    system = pendulum_xy(V0=4.0)
    whole = system.solve((0.0, 5.0), project=True, compile="shared")
    monkeypatch.setattr(fastdyn.run.loop, "CHUNK_SECONDS", 1e-9)
    for tier in ("shared", "inlined"):
        again = system.solve((0.0, 5.0), project=True, compile=tier)
        assert np.array_equal(again.y, whole.y)


def test_a_projection_that_stays_in_python_or_raises():
    seen = []

    def to_energy(t, y):
        seen.append(t)
        r = math.hypot(*y)
        return [y[0] / r, y[1] / r]

    def spring(t, y):
        return [y[1], -y[0]]

    with pytest.warns(fastdyn.CompileWarning, match="to_energy"):
        run = solve_ivp(spring, (0, 10), [1.0, 0.0], project=to_energy)
    assert np.abs(np.hypot(*run.y) - 1.0).max() <= 4 * EPS

    def fails(t, y):
        if t > 5.0:
            raise KeyError("lost")
        return y

    with pytest.raises(KeyError, match="lost"):
        solve_ivp(spring, (0, 10), [1.0, 0.0], project=fails)


def one(t, y):
    return [1.0]


def test_a_projection_that_raises_at_an_output_time_raises():
    def fails(t, y):
        if t == 0.9:
            raise KeyError("here")
        return [y[0]]

    with pytest.raises(KeyError, match="here"):
        solve_ivp(one, (0, 1), [0.0], project=fails, t_eval=[0.5, 0.9])


def test_interpolated_ends_and_events_are_projected_too():
    def circle(t, y):
        r = math.hypot(y[0], y[1])
        return [y[0] / r, y[1] / r]

    def half(t, y):
        return y[0] - 0.5

    half.terminal = 2

    def turn(t, y):
        return [y[1], -y[0]]

    run = solve_ivp(turn, (0, 10), [1.0, 0.0], project=circle, events=half)
    assert np.abs(np.hypot(*run.y) - 1.0).max() <= 2 * EPS
    assert np.abs(np.hypot(*run.y_events[0].T) - 1.0).max() <= 2 * EPS
    run = solve_ivp(turn, (0, 1), [1.0, 0.0], "RK4", step=0.3, project=circle)
    assert np.abs(np.hypot(*run.y) - 1.0).max() <= 2 * EPS


@pytest.mark.parametrize("method", ADAPTIVE)
def test_events_of_projected_solutions_are_where_they_belong(method):
    """Also those that Taylor finds by the series of a step, which a projection must not change."""

    def circle(t, y):
        r = math.hypot(y[0], y[1])
        return [y[0] / r, y[1] / r]

    run = solve_ivp(
        lambda t, y: [2 * y[1], -2 * y[0]], (0, 4), [1.0, 0.0], method, project=circle,
        events=lambda t, y: y[0] - 0.5, rtol=1e-8, atol=1e-8,
    )  # fmt: skip
    exact = np.array([1, 5, 7]) * math.pi / 6
    assert run.t_events[0] == pytest.approx(exact, abs=1e-6)
