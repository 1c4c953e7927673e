"""`sensitivity=` of solve_dae at a higher index: a pendulum of its length, by its angle."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp as scipys

from fastdyn import solve_dae
from tests.support.daes import linear, linear_solution

TIMES = np.linspace(0, 3, 7)
H = 1e-30  # of complex steps
START = [0.6, -0.8, 0.0, 0.0, 0.0]


def pendulum(t, y, yp, length, g):
    x, z, u, v, force = y
    return [yp[0] - u, yp[1] - v, yp[2] + force * x, yp[3] + force * z + g, x**2 + z**2 - length**2]


def by_angle(length, g, angle, rate):
    """The components from the angle; the force is per mass and length."""

    def motion(t, s):
        return np.array([s[1], -g / length * np.sin(s[0])])

    start = np.array([angle, rate], complex)
    a, w = scipys(motion, (0, 3), start, "DOP853", TIMES, rtol=1e-12, atol=1e-13).y
    x, z = length * np.sin(a), -length * np.cos(a)
    return np.array([x, z, -z * w, x * w, w**2 + g / length * np.cos(a)])


def solved(rtol=1e-9, start=START, **options):
    return solve_dae(
        pendulum, (0, 3), start, args=(1.0, 9.81), rtol=rtol, atol=rtol, t_eval=TIMES, **options
    )


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_a_pendulum_by_complex_steps(rtol):
    """With x held, z and the angle follow from the length."""
    run = solved(rtol, given=[0], sensitivity=("g", "y0", "length"))

    def exact(length, g, x):
        return by_angle(length, g, np.arcsin(x / length), 0.0)

    found = run.sensitivity["length"], run.sensitivity["g"], run.sensitivity["y0"][:, 0]
    for j, each in enumerate(found):
        moved = [v + 1j * H * (k == j) for k, v in enumerate((1.0, 9.81, 0.6))]
        assert np.abs(each - exact(*moved).imag / H).max() <= 100 * rtol  # of up to 30
    assert run.index == 3 and not run.sensitivity["y0"][:, [1, 4]].any()
    x, z, u, v, _ = run.y
    dx, dz, du, dv, _ = run.sensitivity["length"]
    assert np.abs(x * dx + z * dz - 1.0).max() <= 1e-14  # the constraint, differentiated
    assert np.abs(x * du + u * dx + z * dv + v * dz).max() <= 1e-13


def test_directions_of_the_start_are_the_nearest_that_the_constraints_allow():
    run = solved(sensitivity="y0")
    angle = np.arcsin(0.6)
    by_position = by_angle(1.0, 9.81, angle + 1j * H, 0.0).imag / H
    by_speed = by_angle(1.0, 9.81, angle, 1j * H).imag / H
    for k, exact in enumerate(
        (0.8 * by_position, 0.6 * by_position, 0.8 * by_speed, 0.6 * by_speed)
    ):
        assert np.abs(run.sensitivity["y0"][:, k] - exact).max() <= 1e-7
    assert not run.sensitivity["y0"][:, 4].any()  # the force is a guess


def test_the_time_of_an_event():
    """The period scales with g^-1/2, and so does the time of each passage."""

    def lowest(t, y, length, g):
        return y[0]

    run = solved(events=lowest, sensitivity="g")
    at, times = run.event_sensitivity[0], run.t_events[0]
    assert len(times) == 3 and np.abs(at.t["g"] + times / (2 * 9.81)).max() <= 1e-8
    assert np.abs(at.y["g"][:2]).max() <= 1e-12  # the place stays


@pytest.mark.parametrize("method", ["Vern9", "Radau", "Taylor"])
def test_other_methods(method):
    run = solved(method=method, sensitivity="g")
    exact = by_angle(1.0, 9.81 + 1j * H, np.arcsin(0.6), 0.0).imag / H
    assert np.abs(run.sensitivity["g"] - exact).max() <= 1e-7


def test_index_1_by_a_method_of_solve_ivp():
    def scaled(t, y, yp, k):
        first, second = linear(t, y, yp)
        return [first, k * second]

    run = solve_dae(
        scaled, (0, 2), *linear_solution(0.0), args=(3.0,), method="DOP853", rtol=1e-9, atol=1e-9,
        sensitivity=("k", "y0"), given="differential",
    )  # fmt: skip
    assert np.abs(run.sensitivity["k"]).max() <= 1e-12  # k drops out
    decay = np.exp(-2 * run.t)
    assert np.abs(run.sensitivity["y0"][:, 0] - [decay, -decay]).max() <= 1e-8
    assert not run.sensitivity["y0"][:, 1].any()


def test_a_callback_and_a_span_without_length():
    seen = []
    run = solved(sensitivity="g", callback=lambda solver: seen.append(solver.y.shape))
    assert set(seen) == {(5,)} and run.sensitivity["g"].shape == (5, 7)
    still = solve_dae(
        pendulum, (1, 1), START, args=(1.0, 9.81), sensitivity="length", given=[0], t_eval=[1.0]
    )
    assert np.allclose(still.sensitivity["length"][:4, 0], [0, -1 / 0.8, 0, 0])


def test_actions_are_refused():
    with pytest.raises(ValueError, match="`sensitivity` and `on_event` do not go together"):
        solved(sensitivity="g", at=[1.0], on_event=lambda t, y, *args: y)
    with pytest.raises(ValueError, match="no start: the constraints of equations 4 cannot hold"):
        solved(sensitivity="y0", given=[0, 1])
