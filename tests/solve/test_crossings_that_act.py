"""Two crossings within a step of an event that acts count by each method, also by SciPy's."""

import numpy as np
import pytest

from fastdyn import solve_ensemble, solve_ivp

ALL = (
    "RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA", "ode45", "ode23", "Tsit5", "Vern7", "Vern9",
    "Rodas5P", "Taylor", "auto",
)  # fmt: skip
SPAN = (0.0, 20.0)


def turning(t, y):
    return [y[1], -y[0]]


@pytest.mark.few(5)
@pytest.mark.parametrize("method", ALL)
def test_a_counter_counts_each_pulse_by_each_method(method):
    """By SciPy's rule RK45 counts 1 of the 13 pulses, DOP853 2, Radau 4, ode45 6."""

    def pulse(t, y, d):
        return np.sin(4.0 * t) - 0.9

    pulse.direction = 1.0
    found = solve_ivp(
        lambda t, y, d: [y[1], -y[0]], SPAN, [1.0, 0.0], method, events=pulse, discrete=[0.0],
        on_event=lambda t, y, d: (y, [d[0] + 1.0]),
    )  # fmt: skip
    times = (np.arcsin(0.9) + 2 * np.pi * np.arange(13)) / 4.0
    assert found.discrete[0, -1] == len(times)
    assert found.t_events[0] == pytest.approx(times, abs=1e-8)


def ceiling(t, y, *args):
    """A body on a spring hits a wall, passes it and returns within a step if no hit counts."""
    return y[0] - 0.99


ceiling.direction = 1.0


def hit(t, y, *args):
    return [y[0], -0.9 * y[1]]


@pytest.mark.few(5)
@pytest.mark.parametrize("method", ALL)
def test_a_wall_is_hit_by_each_method(method):
    given = {"events": ceiling, "on_event": hit}
    right = solve_ivp(turning, SPAN, [-1.0, 0.0], "Vern9", rtol=1e-11, atol=1e-12, **given)
    found = solve_ivp(turning, SPAN, [-1.0, 0.0], method, rtol=1e-6, atol=1e-8, **given)
    assert len(found.t_events[0]) == len(right.t_events[0]) > 0
    assert np.abs(found.y[:, -1] - right.y[:, -1]).max() < 1e-2


def test_a_thermostat_with_a_trembling_sensor_switches_by_each_method():
    """The sensor reaches the level for moments, within the long steps of a slow temperature."""

    def cold(t, y, d):
        return y[0] + 0.4 * np.sin(4.0 * t) - 19.0

    def warm(t, y, d):
        return y[0] + 0.4 * np.sin(4.0 * t) - 21.0

    cold.direction, warm.direction = -1.0, 1.0
    numbers = {}
    for method in ALL:
        found = solve_ivp(
            lambda t, y, d: [-0.05 * (y[0] - 10.0 - 20.0 * d[0])], (0, 60), [20.0], method,
            events=[cold, warm], discrete=[1.0], rtol=1e-5, atol=1e-5,
            on_event=[lambda t, y, d: (y, [1.0]), lambda t, y, d: (y, [0.0])],
        )  # fmt: skip
        numbers[method] = [len(each) for each in found.t_events], round(found.y[0, -1], 2)
    assert all(each == numbers["Vern9"] for each in numbers.values()), numbers


@pytest.mark.parametrize("method", ["RK45", "DOP853"])
def test_actions_in_lanes_are_those_of_each_trajectory(method):
    start = np.column_stack([-np.linspace(0.9, 1.1, 9), np.zeros(9)])
    given = {"events": ceiling, "on_event": hit, "rtol": 1e-6, "atol": 1e-8}
    lanes, alone = (
        solve_ensemble(turning, SPAN, start, (), method, simd=simd, **given)
        for simd in (True, False)
    )
    assert lanes.width > 1
    for i, y0 in enumerate(start):
        one = solve_ivp(turning, SPAN, y0, method, **given)
        for many in (lanes, alone):
            assert len(many.t_events[0][i]) == len(one.t_events[0])
            assert many.y_end[i] == pytest.approx(one.y[:, -1], abs=1e-9)
    assert sum(len(each) for each in lanes.t_events[0]) > 9
