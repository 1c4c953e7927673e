"""Roots of what comes to zero: emptied tanks, starts at zero, ways through it."""

import math

import numpy as np
import pytest
import scipy.integrate

from fastdyn import Stepper, solve_ensemble, solve_ivp
from fastdyn.kernels.methods.taylor import tangent
from fastdyn.systems import satellite


def tank(t, y, k):
    return [-k * np.sqrt(max(y[0], 0))]


@pytest.mark.parametrize("beyond", [1.0001, 1.1, 3.0, 100.0])
@pytest.mark.parametrize("rtol", [1e-6, 1e-10])
@pytest.mark.parametrize("method", ["Taylor", "auto"])
def test_an_emptied_tank_stays_empty(method, rtol, beyond):
    rng = np.random.default_rng(int(10 * beyond))
    for k, y0 in rng.uniform(0.05, 3.0, (8, 2)):
        end = beyond * 2.0 * math.sqrt(y0) / k
        run = solve_ivp(tank, (0, end), [y0], method, args=(k,), rtol=rtol, atol=1e-2 * rtol)
        assert run.status == 0 and run.nfev < 300 and abs(run.y[0, -1]) < 1e-2 * rtol
        half = solve_ivp(
            tank, (0, end), [y0], method, args=(k,), rtol=rtol, atol=1e-2 * rtol,
            t_eval=[math.sqrt(y0) / k],
        )  # fmt: skip
        assert abs(half.y[0, 0] - y0 / 4) < 10 * rtol * y0


def scaled(t, y):
    return [-0.1 * math.sqrt(2 * 9.81 * max(y[0], 0.0))]


def in_array(t, y):
    return -np.sqrt(np.maximum(y, 0))


def by_power(t, y):
    return [-(max(y[0], 0.0) ** (1 / 3))]


def cascade(t, y):
    out = 0.5 * math.sqrt(max(y[0], 0.0))
    return [-out, out - 0.1 * math.sqrt(max(y[1], 0.0))]


def refilled(t, y):
    return [math.cos(t) - np.sqrt(max(y[0], 0))]


def rained_on(t, y):
    return [max(math.cos(t), 0) - np.sqrt(max(y[0], 0))]


def both_ways(t, y):
    return [y[1], -np.sign(y[0]) * np.sqrt(abs(y[0]))]


def with_friction(t, y):
    return [y[1], -y[0] - 0.1 * np.sqrt(abs(y[1])) * np.sign(y[1])]


@pytest.mark.parametrize(
    ("fun", "y0", "end"),
    [
        (scaled, [1.0], 20.0), (in_array, [2.0, 1.0, 0.1], 10.0), (by_power, [1.7], 10.0),
        (cascade, [2.0, 0.0], 40.0), (refilled, [1.7], 30.0), (rained_on, [1.7], 33.0),
        (both_ways, [1.7, 0.0], 10.0), (with_friction, [1.7, 0.0], 20.0),
    ],
)  # fmt: skip
def test_zeros_of_roots_are_passed(fun, y0, end):
    exact = scipy.integrate.solve_ivp(
        fun, (0, end), y0, "DOP853", rtol=1e-12, atol=1e-13, max_step=0.05
    )
    run = solve_ivp(fun, (0, end), y0, "Taylor", rtol=1e-8, atol=1e-10)
    assert run.status == 0 and run.nfev < 6000
    assert np.abs(run.y[:, -1] - exact.y[:, -1]).max() < 2e-5


@pytest.mark.parametrize(
    ("fun", "exact"),
    [
        (lambda t, y: [t**0.5], 2 / 3), (lambda t, y: [np.sqrt(y[0])], 0.0),
        (lambda t, y: [t**1.5], 0.4), (lambda t, y: [1 + np.sqrt(y[0])], 2.1461932206205825),
    ],
)  # fmt: skip
def test_a_start_without_a_series(fun, exact):
    """The last is 2 w - 2 log(1 + w) = t at the end, w the root."""
    run = solve_ivp(fun, (0.0, 1.0), [0.0], "Taylor", rtol=1e-8, atol=1e-8)
    if exact > 2:
        w = math.sqrt(run.y[0, -1])
        assert run.status == 0 and abs(2 * w - 2 * math.log1p(w) - 1.0) < 1e-6
    else:
        assert run.status == 0 and abs(run.y[0, -1] - exact) < 1e-6


def test_a_pulse_after_the_tank_is_empty_is_not_stepped_over():
    """A step along the tangent, where nothing moves, is a small part of the span."""

    def fun(t, y):
        return [max(math.cos(t - 3.0) - 0.99, 0.0) - math.sqrt(max(y[0], 0.0))]

    def filled(t, y):
        return [math.cos(t - 3.0) - 0.99 - np.sqrt(max(y[0], 0))]

    run = solve_ivp(fun, (0.0, 3.0), [0.0], "Taylor", rtol=1e-8, atol=1e-10)
    rise = math.acos(0.99)
    exact = scipy.integrate.solve_ivp(filled, (3 - rise, 3), [0.0], "Radau", rtol=1e-10, atol=1e-13)
    assert tangent.MOST < rise / 3.0 / 8.0
    assert abs(run.y[0, -1] / exact.y[0, -1] - 1.0) < 1e-2


def test_chunks_of_one_step_are_the_same():
    whole = solve_ivp(refilled, (0, 30), [1.7], "Taylor", rtol=1e-8, atol=1e-10)
    pieces = solve_ivp(
        refilled, (0, 30), [1.7], "Taylor", rtol=1e-8, atol=1e-10, callback=lambda solver: None
    )
    assert np.array_equal(whole.t, pieces.t) and np.array_equal(whole.y, pieces.y)


def test_ensembles_of_tanks():
    y0 = np.linspace(0.5, 2.0, 12)[:, None]
    found = solve_ensemble(tank, (0, 30), y0, (0.7,), "Taylor", rtol=1e-8, atol=1e-10)
    assert found.success.all() and np.abs(found.y_end).max() < 1e-9


def stuck(t, y):
    """Comes to rest, where the friction holds against the spring: the state slides."""
    return [y[1], -y[0] - 0.1 * np.sign(y[1])]


@pytest.mark.parametrize("method", ["auto", "Taylor"])
def test_sliding_is_noticed(method):
    run = solve_ivp(stuck, (0, 100), [1.7, 0], method, rtol=1e-6, atol=1e-9)
    assert run.nfev < 50_000
    if method == "Taylor":
        assert run.status == -1 and "Required step size" in run.message


def test_an_orbit_that_grazes_its_planet_is_no_tank():
    """Each step near the planet, short beside the period, tried the tangent twelve times."""
    orbit = satellite(V=math.sqrt(2.0 - 1e-6))
    given = {"args": orbit.args, "rtol": 1e-14, "atol": 1e-22}
    start, end = orbit.initial_state(), 3.0 * orbit.period
    run = solve_ivp(orbit.rhs, (0, end), start, "Taylor", t_eval=[end], **given)
    assert run.n_rejected < 0.1 * run.n_accepted
    step_by_step = Stepper(orbit.rhs, 0.0, start, end, "Taylor", **given)
    for _ in range(40):
        step_by_step.step()
    assert step_by_step.n_rejected <= 15
