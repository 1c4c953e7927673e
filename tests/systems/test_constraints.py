"""Constrained systems against the course's matrices: the pendulum in x and y, the vehicle."""

import math

import numpy as np
import pytest

from fastdyn.course.lessons.pendulum_xy import velocity_matrix
from fastdyn.course.lessons.vehicle import coasting
from fastdyn.systems import (
    pendulum,
    pendulum_xy,
    vehicle,
)

EPS = np.finfo(float).eps

TIGHT = {"rtol": 1e-10, "atol": 1e-12}


def courses_pendulum(t, w, g, l, m, rate):  # noqa: E741
    """The course's script, with NumPy's linear solve."""
    x, y, vx, vy = w
    M = np.eye(5)
    M[2, 4], M[3, 4] = x / m / math.hypot(x, y), y / m / math.hypot(x, y)
    M[4] = [0.0, 0.0, x, y, 0.0]
    return np.linalg.solve(M, [vx, vy, 0.0, g, -(vx**2) - vy**2])


def test_constrained_pendulum_is_the_courses_matrix():
    system = pendulum_xy(m=2.0, l=0.7, g=3.0)
    rng = np.random.default_rng(3)
    for _ in range(20):
        angle, v = rng.uniform(-3, 3), rng.normal()
        s, c = math.sin(angle), math.cos(angle)
        w = [0.7 * s, 0.7 * c, v * c, -v * s]
        *rate, R = courses_pendulum(0.0, w, *system.args)
        assert system.rhs(0.0, w, *system.args) == pytest.approx(rate, rel=1e-12, abs=1e-12)
        tension = system.along(system.quantities["tension"], 0.0, np.array(w)[:, None])
        assert tension == pytest.approx(R, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("V0", [0.1, 4.0, 8.0])
def test_constrained_pendulum_is_the_pendulum_by_angle(V0):
    system = pendulum_xy(V0=V0, m=3.0)
    run = system.solve((0.0, 10.0), project=True, **TIGHT)
    allowed = run.n_accepted * 1e-10 * (1.0 + V0) * 100.0
    assert np.abs(run.error()).max() <= allowed
    force = system.along(system.quantities["tension"], run.t, run.y)
    exact = system.by_angle.along(pendulum.quantities["tension"], run.t,
                                  system.by_angle.exact(run.t))  # fmt: skip
    assert np.abs(force - exact).max() <= allowed * 3.0 * (V0 + 10.0)


def test_baumgarte_holds_the_circle_better_than_accelerations_alone():
    system = pendulum_xy(V0=4.0)
    runs = {
        "alone": system.solve((0.0, 100.0)),
        "Baumgarte": system.baumgarte().solve((0.0, 100.0)),
        "projection": system.solve((0.0, 100.0), project=True),
    }
    off = {how: np.abs(run.residuals()["circle"]).max() for how, run in runs.items()}
    assert off["projection"] < 1e-6 * off["Baumgarte"] and off["Baumgarte"] < 0.1 * off["alone"]


def test_a_constraint_on_the_velocities_says_that_the_matrix_is_singular():
    with pytest.raises(ArithmeticError, match="singular"):
        velocity_matrix(0.6, 0.8, 0.4, -0.3)


def courses_vehicle(t, w, m, L, c, driver):
    """The course's script, with NumPy's linear solve of its eight equations."""
    alpha, dadt, P = driver(t, w)
    th, v = w[2], math.hypot(w[3], w[4])
    s, cs, sf, cf = math.sin(th), math.cos(th), math.sin(th + alpha), math.cos(th + alpha)
    M = np.zeros((8, 8))
    M[0, 0] = M[1, 1] = M[2, 2] = 1.0
    M[3, 3], M[3, 6], M[3, 7] = m, -sf, -s
    M[4, 4], M[4, 6], M[4, 7] = m, -cf, -cs
    M[5, 6], M[5, 7] = math.cos(alpha), -1.0
    M[6, 3], M[6, 4], M[6, 5] = s, cs, L / 2
    M[7, 3], M[7, 4], M[7, 5] = sf, cf, -L * math.cos(alpha) / 2
    f = [
        w[3], w[4], w[5], P * cs - c * v * w[3], -P * s - c * v * w[4], 0.0,
        (-cs * w[3] + s * w[4]) * w[5],
        (-cf * w[3] + sf * w[4]) * (w[5] + dadt) - math.sin(alpha) * L * w[5] * dadt / 2,
    ]  # fmt: skip
    return np.linalg.solve(M, f)


def test_vehicle_is_the_courses_matrix():
    system = vehicle(m=2.0, L=1.5, c=0.3)
    rng = np.random.default_rng(4)
    for _ in range(20):
        t, w = rng.uniform(0, 9), rng.normal(size=6)
        *rate, R1, R2 = courses_vehicle(t, w, *system.args)
        assert system.rhs(t, w, *system.args) == pytest.approx(rate, rel=1e-12, abs=1e-12)
        for name, force in (("front_force", R1), ("rear_force", R2)):
            value = system.along(system.quantities[name], t, w[:, None])
            assert value == pytest.approx(force, rel=1e-11, abs=1e-12)


def test_wheels_do_not_slip_and_coasting_keeps_the_speed():
    run = vehicle(driver=coasting, c=0.0).solve(
        y0=vehicle(driver=coasting).rolling(2.0), project=True, **TIGHT
    )
    assert max(np.abs(v).max() for v in run.residuals().values()) <= 32 * EPS
    energy = run.quantities()["kinetic_energy"]
    assert np.ptp(energy) <= run.n_accepted * 1e-10 * 8.0
    assert max(abs(v[0]) for v in run.residuals().values()) <= 4 * EPS


@pytest.mark.parametrize("alpha", [0.1, -0.3, 0.8])
def test_constant_steering_ends_on_a_circle(alpha):
    def hold(t, w):
        return alpha, 0.0, 0.2

    car = vehicle(driver=hold)
    run = car.solve((0.0, 400.0), **TIGHT)
    v = np.hypot(run.y[3, -1], run.y[4, -1])
    assert v == pytest.approx(car.terminal_speed(alpha, 0.2), rel=1e-6)
    assert v / abs(run.y[5, -1]) == pytest.approx(abs(car.circle_radius(alpha)), rel=1e-6)
