"""Taylor where the function has kinks or jumps: steps end there, and the order is kept."""

import math

import numpy as np
import pytest

from fastdyn import solve_ivp

TIGHT = {"method": "Taylor", "rtol": 1e-12, "atol": 1e-12}
NEAR = 1e-10  # a hundred steps and kinks at these tolerances


def end(fun, t, y0, **options):
    run = solve_ivp(fun, (0.0, t), y0, **TIGHT | options)
    assert run.status == 0, run.message
    return run, run.y[:, -1]


def test_a_force_that_changes_its_sign():
    def fun(t, y):
        return [y[1], 1.0 if y[0] < 0 else -1.0]

    run, y = end(fun, 20.0, [0.5, 0.0])  # parabolas of half period 2
    assert np.abs(y - [0.5, 0.0]).max() < NEAR
    assert run.n_accepted < 40


def test_a_time_that_is_asked_for():
    def fun(t, y):
        return [1.0 if t < 1.3 else -2.0]

    run, y = end(fun, 5.0, [0.0])
    assert abs(y[0] - (1.3 - 2 * 3.7)) < NEAR
    assert run.n_accepted < 20


def rise_and_fall(t, v0, g=9.81, k=0.1):
    """Height and speed after a throw upwards against the drag k |v| v."""
    final = math.sqrt(g / k)
    top = final / g * math.atan(v0 / final)
    h = final**2 / (2 * g) * math.log(1 + (v0 / final) ** 2)
    fall = t - top
    x = g * fall / final
    return [h - final**2 / g * math.log(math.cosh(x)), -final * math.tanh(x)]


def by_size(t, y):
    return [y[1], -9.81 - 0.1 * abs(y[1]) * y[1]]


def by_root(t, y):
    return [y[1], -9.81 - 0.1 * math.sqrt(y[1] ** 2) * y[1]]


def by_length(t, y):
    return [y[1], -9.81 - 0.1 * math.sqrt(y[1] ** 2 + (y[0] - y[0]) ** 2) * y[1]]


def by_numpy(t, y):
    return [y[1], -9.81 - 0.1 * np.linalg.norm([y[1], 0.0]) * y[1]]


@pytest.mark.parametrize("fun", [by_size, by_root, by_length, by_numpy])
def test_a_root_is_not_continued_to_the_other_sign(fun):
    """The series of sqrt(v^2), which is |v|, goes on through 0 as v."""
    run, y = end(fun, 4.0, [0.0, 20.0])
    assert np.abs(y - rise_and_fall(4.0, 20.0)).max() < 1e-9  # |v|, not v, within 1e-6 of the top
    assert run.n_accepted < 60


def test_directions_turn_where_they_vanish():
    """v / |v| is 1 or -1: dry friction, until it stops."""

    def fun(t, y):
        v = np.array([y[1], y[2]])
        return [y[1], *(-0.5 * v / np.sqrt(v @ v + 0.0 * y[0]))]

    run = solve_ivp(fun, (0.0, 1.9), [0.0, 1.0, 0.0], **TIGHT)
    assert run.status == 0 and abs(run.y[1, -1] - (1.0 - 0.95)) < NEAR
    over = solve_ivp(fun, (0.0, 4.0), [0.0, 1.0, 0.0], max_steps=2000, **TIGHT)
    assert over.status == -1 or abs(over.y[1, -1]) < 1e-6  # never through 0 to negative speeds


def test_the_angle_of_a_point_jumps_at_the_cut():
    def fun(t, y):
        return [math.atan2(y[1], y[2]), y[2], -y[1]]

    _, y = end(fun, 3.0, [0.0, math.sin(2.0), math.cos(2.0)])  # of 2 + t, up to pi
    assert abs(y[0] - (6.0 + 4.5 - 2 * math.pi * (5.0 - math.pi))) < NEAR


def test_a_start_on_a_kink_takes_the_side_it_goes_to():
    def fun(t, y):
        return [y[1], -1.0 if y[0] > 0 else 1.0]

    _, y = end(fun, 2.0, [0.0, 1.0])
    assert np.abs(y - [0.0, -1.0]).max() < NEAR
    _, y = end(fun, 2.0, [0.0, -1.0])
    assert np.abs(y - [0.0, 1.0]).max() < NEAR


def test_clipping():
    def fun(t, y):
        return [y[1], -np.clip(5.0 * y[0], -1.0, 1.0)]

    forth, y = end(fun, 10.0, [1.0, 0.0])
    _, back = end(fun, 10.0, [y[0], -y[1]])
    assert np.abs(back - [1.0, 0.0]).max() < NEAR
    assert forth.n_accepted < 40


def test_what_raises_does():
    def fun(t, y):
        if y[0] < 0.5:
            raise ValueError("too low")
        return [-y[0]]

    with pytest.raises(ValueError, match="too low"):
        solve_ivp(fun, (0.0, 5.0), [1.0], **TIGHT)
    _, y = end(fun, 0.5, [1.0])
    assert abs(y[0] - math.exp(-0.5)) < NEAR


@pytest.mark.parametrize("span", [(0.0, 3.0), (3.0, 0.0)])
def test_both_directions_of_time(span):
    def fun(t, y):
        return [abs(t - 1.0), max(t, 2.0)]

    run = solve_ivp(fun, span, [0.0, 0.0], **TIGHT)
    sign = 1.0 if span[1] > span[0] else -1.0
    assert np.abs(run.y[:, -1] - sign * np.array([2.5, 6.5])).max() < NEAR


CURVES = [
    lambda x, v: v + 1.6 * x + 0.2 * x**3,
    lambda x, v: np.sin(1.3 * x) + 0.9 * v,
    lambda x, v: np.exp(-x * x) + 0.1 * v - 0.4,
]


@pytest.mark.few(1)
@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-7, 1e-9])
@pytest.mark.parametrize("curve", CURVES)
def test_a_change_lies_where_the_difference_is_less_accurate_than_the_states(curve, rtol):
    """The series of a curved difference may have a remainder far above the tolerance.

    An error of the time of a change grows by the jump, 1.5; without the nearer look the errors are
    200 to 2e5 tolerances.
    """

    def fun(t, y):
        jump = 1.0 if curve(y[0], y[1]) > 0 else -0.5
        return [y[1], -0.9 * y[0] - 0.1 * y[1] + 1.3 * jump + 0.8 * math.sin(0.95 * t)]

    for start in ([0.9, 0.1], [-0.6, 0.8], [0.2, -0.7]):
        _, y = end(fun, 12.0, start, rtol=rtol, atol=rtol)
        exact = end(fun, 12.0, start)[1]
        assert np.abs(y - exact).max() < 30 * rtol * (1 + np.abs(exact).max())
