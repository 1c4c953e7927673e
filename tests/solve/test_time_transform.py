"""Claims about another clock, dt = g(y) ds."""

import math

import numpy as np
import pytest

import fastdyn
from fastdyn.systems import satellite


def distance(t, w, GM):
    return math.sqrt(w[0] * w[0] + w[1] * w[1])


def energy_with_time(t, w, GM):
    return 0.5 * (w[2] * w[2] + w[3] * w[3]) - GM / np.sqrt(w[0] * w[0] + w[1] * w[1])


@pytest.mark.parametrize(
    "e, steps, bound", [(0.6, 30, 1e-13), (0.9, 40, 5e-13), (0.99, 100, 5e-12)]
)
def test_eccentric_orbits_by_another_clock(e, steps, bound):
    orbit = satellite(V=math.sqrt(1.0 + e))
    fun = fastdyn.solve.time_transformed(orbit.rhs, distance)
    turn = 2.0 * math.pi * math.sqrt(orbit.semi_major_axis)
    study = fastdyn.energy_drift(
        fun, "Gauss16", step=turn / steps, n_steps=1000 * steps, y0=[*orbit.initial_state(), 0.0],
        args=orbit.args, invariants={"energy": energy_with_time},
    )  # fmt: skip
    assert study.drifts["energy"].largest < bound
    t = study.y[4]
    assert t[-1] == pytest.approx(1000 * orbit.period, rel=1e-9)
    off = np.abs(study.y[:2] - orbit.exact(t)[:2]).max()
    assert off < 1e-5 * orbit.semi_major_axis


def test_another_clock_takes_plain_functions_and_is_the_same_in_python():
    fun = fastdyn.solve.time_transformed(lambda t, y: [y[1], -y[0]], lambda t, y: 2.0 + y[0])
    assert fun(0.0, np.array([1.0, 0.5, 7.0])) == [1.5, -3.0, 3.0]
    run = fastdyn.solve_ivp(fun, (0, 3), [1.0, 0.0, 0.0], rtol=1e-10, atol=1e-12)
    assert np.allclose(run.y[0], np.cos(run.y[2]), rtol=0, atol=1e-8)
    arrays = fastdyn.solve.time_transformed(lambda t, y: -1.0 * y, lambda t, y: 1.0 + t)
    run = fastdyn.solve_ivp(arrays, (0, 1), [1.0, 0.0], rtol=1e-9, atol=1e-12)
    assert np.allclose(run.y[0], np.exp(-run.y[1]), rtol=0, atol=1e-8)
    with pytest.raises(TypeError, match="plain Python functions"):
        fastdyn.solve.time_transformed(len, distance)
