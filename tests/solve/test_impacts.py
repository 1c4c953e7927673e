"""Claims about impacts, switches and separations, by motions with known answers."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from fastdyn import Phase, solve_ivp, solve_phases
from fastdyn.solve import solve_second_order
from tests.support.impacts import bounce, falling, ground, marked

TIGHT = {"rtol": 1e-11, "atol": 1e-13}


def test_a_rimless_wheel_rolls_as_mcgeer_and_coleman_say():
    """
    Between impacts the energy is kept, at each the velocity falls by cos 2 alpha: T. McGeer,
    "Passive dynamic walking", Int. J. Robotics Research 9(2), 1990, section 2.
    """
    alpha, slope = math.pi / 8, 0.08

    def wheel(t, y):
        return [y[1], math.sin(y[0])]

    def strike(t, y):
        return y[0] - slope - alpha

    run = solve_ivp(
        wheel, (0.0, 400.0), [slope - alpha, 0.6], "DOP853", events=marked(strike, terminal=40),
        on_event=lambda t, y: [slope - alpha, math.cos(2 * alpha) * y[1]], **TIGHT,
    )  # fmt: skip
    squares = run.y_events[0][:, 1] ** 2
    gain, keep = 4.0 * math.sin(alpha) * math.sin(slope), math.cos(2 * alpha) ** 2
    assert run.status == 1 and squares[0] == pytest.approx(0.36 + gain, abs=1e-9)
    assert np.abs(squares[1:] - keep * squares[:-1] - gain).max() <= 1e-9
    assert squares[-1] == pytest.approx(gain / math.sin(2 * alpha) ** 2, abs=1e-9)


def walk(t, y, slope):
    stance, rate, swing, swing_rate = y
    pull = math.sin(stance - slope)
    kick = math.sin(swing) * (rate * rate - math.cos(stance - slope))
    return [rate, pull, swing_rate, pull + kick]


def heel_strike(t, y, slope):
    return y[2] - 2.0 * y[0]


def step(t, y, slope):
    c = math.cos(2.0 * y[0])
    return [-y[0], c * y[1], -2.0 * y[0], c * (1.0 - c) * y[1]]


def test_the_simplest_walker_takes_the_published_steps():
    """
    M. Garcia, A. Chatterjee, A. Ruina, M. Coleman, "The simplest walking model: stability,
    complexity, and scaling", J. Biomech. Eng. 120, 1998: on a slope g the steps of the long gait
    last 3.812092 + O(g^(2/3)), by angles of 0.970956 g^(1/3) + O(g).
    """
    period = brentq(lambda x: math.tan(x / 2) + 3.0 * math.tanh(x / 2), 3.5, 4.5)
    angle = math.tanh(period / 2) ** (2 / 3)
    assert round(period, 6) == 3.812092 and round(angle, 6) == 0.970956
    strikes, gaits = marked(heel_strike, direction=1, terminal=120), []
    for slope in (1e-3, 5e-4, 1.25e-4, 6.25e-5):
        start = angle * slope ** (1 / 3)
        run = solve_ivp(
            walk, (0.0, 500.0), [-start, -start / math.tanh(period / 2), -2.0 * start, 0.0],
            "DOP853", events=strikes, on_event=step, args=(slope,), **TIGHT,
        )  # fmt: skip
        times, (stance, rate) = run.t_events[0], run.y_events[0][-1][:2]
        assert times[0] == 0.0 and len(times) == 120  # from a strike
        gain = 4.0 * math.sin(-stance) * math.sin(slope)  # in a step, and lost at its end
        assert abs(rate**2 * math.sin(2.0 * stance) ** 2 - gain) <= 1e-6 * gain
        gaits.append((times[-1] - times[-2], -stance / slope ** (1 / 3)))
    for found, exact in zip(np.transpose(gaits), (period, angle), strict=True):
        rest = (4.0 * found[2:] - found[:2]) / 3.0 - exact  # without g^(2/3): O(g^(4/3))
        assert np.abs(rest).max() <= 4e-5 and rest[0] / rest[1] == pytest.approx(2 ** (4 / 3), 0.05)


def rocket(t, y):
    _, v, mass, stage = y
    first = stage < 0.5
    burn = 4.0 if first else 2.5
    speed = 2.0 if first else 3.0
    return [v, burn * speed / mass - 0.01, -burn, 0.0]


def empty(t, y):
    return y[2] - (40.0 if y[3] < 0.5 else 10.0)


def separate(t, y):
    return [y[0], y[1], 30.0, y[3] + 1.0]


@pytest.mark.parametrize("method", ["RK45", "DOP853", "ode45"])
def test_a_stage_separates_as_between_two_phases_and_as_tsiolkovsky_says(method):
    empties = marked(empty, direction=-1, terminal=2)
    given = {"rtol": 1e-10, "atol": 1e-12}
    run = solve_ivp(
        rocket, (0.0, 100.0), [0.0, 0.0, 100.0, 0.0], method, events=empties, on_event=separate,
        **given,
    )  # fmt: skip
    last = marked(lambda t, y: y[2] - 10.0 * y[3], direction=-1, terminal=True)
    phase = Phase(rocket, empties, lambda t, y: ("up", separate(t, y)))
    phases = solve_phases(
        {"up": phase._replace(event=marked(empty, direction=-1, terminal=True))}, "up",
        (0.0, 100.0), [0.0, 0.0, 100.0, 0.0], method, events=last, **given,
    )  # fmt: skip
    n = len(run.t)
    assert run.status == 1 and run.t_events[0] == pytest.approx([15.0, 23.0], abs=1e-12)
    assert np.array_equal(run.t, phases.t[:n]) and np.array_equal(run.y[:, -2], phases.y[:, n - 2])
    speed = 2.0 * math.log(100.0 / 40.0) + 3.0 * math.log(30.0 / 10.0) - 0.01 * 23.0
    assert run.y[1, -1] == pytest.approx(speed, abs=1e-8)
    assert run.y[2:, -1] == pytest.approx([10.0, 1.0], abs=1e-11)


def test_a_switch_is_passed_once_and_may_switch_the_event():
    """A thermostat: the mode is a component of the state, whose derivative is 0."""

    def room(t, y):
        return [(2.0 if y[1] > 0.5 else 0.0) - y[0], 0.0]

    def limit(t, y):
        return y[0] - (1.5 if y[1] > 0.5 else 0.5)

    run = solve_ivp(
        room, (0.0, 20.0), [0.0, 1.0], "DOP853", events=limit,
        on_event=lambda t, y: [y[0], 1.0 - y[1]], **TIGHT,
    )  # fmt: skip
    heating, cooling = math.log(1.5 / 0.5), math.log(1.5 / 0.5)
    n = len(run.t_events[0])
    exact = math.log(2.0 / 0.5) + np.cumsum(np.r_[0.0, np.tile([cooling, heating], n)])[:n]
    assert n == 17 and np.abs(run.t_events[0] - exact).max() <= 1e-9
    once = solve_ivp(
        lambda t, y: [1.0, 0.0], (0.0, 3.0), [0.0, 1.0], events=lambda t, y: y[1] * (y[0] - 1.0),
        on_event=lambda t, y: [0.0, 0.0],
    )  # fmt: skip
    assert len(once.t_events[0]) == 1 and once.y[0, -1] == pytest.approx(2.0, abs=1e-14)
    through = solve_ivp(
        lambda t, y: [1.0], (0.0, 3.0), [0.0], events=lambda t, y: y[0] - 1.0,
        on_event=lambda t, y: y, dense_output=True,
    )  # fmt: skip
    assert len(through.t_events[0]) == 1 and through.sol(2.0) == pytest.approx(2.0, abs=1e-14)


def test_a_jump_over_zero_is_no_event():
    run = solve_ivp(
        falling, (0.0, 1.0), [1.0, 0.0], args=(1.0,), events=ground,
        on_event=lambda t, y, e: [-0.5, 0.0], **TIGHT,
    )  # fmt: skip
    assert run.success and len(run.t_events[0]) == 1
    s = 1.0 - run.t_events[0][0]
    assert run.y[0, -1] == pytest.approx(-0.5 - 0.5 * 9.81 * s * s, abs=1e-10)


@pytest.mark.parametrize("speed, direction, n", [(-1.0, -1, 1), (1.0, -1, 0), (1.0, 0, 0)])
def test_an_event_at_the_start_counts_in_a_direction_that_is_given(speed, direction, n):
    run = solve_ivp(
        falling, (0.0, 0.1), [0.0, speed], args=(1.0,), events=marked(ground, direction=direction),
        on_event=bounce, **TIGHT,
    )  # fmt: skip
    assert run.success and len(run.t_events[0]) == n and run.y[0].min() >= 0.0


@pytest.mark.parametrize("method", ["VelocityVerlet", "SofroniouSpaletta10", "GaussNystrom8"])
def test_symplectic_methods_begin_anew(method):
    """A ball on a spring that strikes a wall at rest: half the period, and no energy lost."""
    wall = marked(lambda t, y: y[0], direction=-1)
    run = solve_second_order(
        lambda t, q: -q, (0.0, 20.0), [1.0], [0.0], method, step=0.01, events=wall,
        on_event=lambda t, y: [0.0, -y[1]],
    )  # fmt: skip
    slack = 2e-4 if method == "VelocityVerlet" else 1e-9  # h^2 t / 24; the cubic between steps
    assert np.abs(run.t_events[0] - math.pi * np.arange(0.5, 6.4)).max() <= slack
    energy = 0.5 * (run.y**2).sum(axis=0)
    assert np.abs(energy - 0.5).max() <= 5e-5 if method == "VelocityVerlet" else 1e-9


def test_states_on_constraints_stay_there():
    """A pendulum in x and y that is turned back at the bottom, on a circle of radius 1."""

    def circle(t, y):
        x, z, u, w = y
        pull = u * u + w * w - z
        return [u, w, -pull * x, -1.0 - pull * z]

    def onto(t, y):
        r = math.hypot(y[0], y[1])
        return [y[0] / r, y[1] / r, y[2], y[3]]

    run = solve_ivp(
        circle, (0.0, 30.0), [math.sin(1.0), -math.cos(1.0), 0.0, 0.0], project=onto,
        events=marked(lambda t, y: y[0], direction=-1), on_event=lambda t, y: [*y[:2], *(-y[2:])],
        rtol=1e-9, atol=1e-11,
    )  # fmt: skip
    assert run.success and run.y[0].min() >= -1e-14
    assert np.abs(np.hypot(run.y[0], run.y[1]) - 1.0).max() <= 4e-16
    assert np.ptp(np.diff(run.t_events[0])) <= 1e-6 and len(run.t_events[0]) > 7
