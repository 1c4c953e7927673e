"""Claims about the pendulum: three regimes, long times, small angles, slack."""

import math
from decimal import Decimal

import numpy as np
import pytest
from scipy.special import ellipj, ellipkinc, ellipkm1

from fastdyn.course.lessons.pendulum import allowance
from fastdyn.systems import pendulum
from fastdyn.systems.formulas.elliptic import amplitude, quarter_period

EPS = np.finfo(float).eps
EDGE = 2.0 * math.sqrt(9.81)  # launch velocity of the separatrix for g = 9.81, l = 1


@pytest.mark.parametrize("V0, t_end", [(0.1, 20.0), (5.0, 20.0), (EDGE, 2.0), (8.0, 5.0)])
def test_computed_angle_is_as_exact_as_its_tolerance(V0, t_end):
    run = pendulum(V0=V0).solve((0.0, t_end), rtol=1e-9, atol=1e-12)
    assert np.abs(run.error()[0]).max() <= allowance(run)


@pytest.mark.parametrize("m1", [1.0, 0.5, 1e-3, 1e-8, 1e-14])
def test_elliptic_functions_agree_with_scipy_where_scipy_is_accurate(m1):
    K = quarter_period(m1)
    assert pytest.approx(ellipkm1(m1), rel=8 * EPS) == K
    u = np.linspace(-0.95, 0.95, 39) * K
    phi = amplitude(u, m1)
    if m1 >= 1e-8:  # ellipkinc sees 1 - m1, whose rounding is EPS / m1 of m1
        assert np.allclose(ellipkinc(phi, 1.0 - m1), u, rtol=0, atol=K * (20 * EPS + EPS / m1))
    if m1 > 1e-2:
        assert np.allclose(np.sin(phi), ellipj(u, 1.0 - m1)[0], rtol=0, atol=20 * EPS)


@pytest.mark.parametrize("V0", [0.1, 6.0, EDGE * (1 - 1e-9), EDGE * (1 + 1e-9), 8.0, 100.0])
def test_pendulum_repeats_after_a_million_periods(V0):
    system = pendulum(V0=V0)
    turn = 0.0 if system.regime == "swinging" else 2.0 * math.pi
    n = 10**6
    t = n * system.period
    theta, omega = system.exact(t)
    allowed = 8 * EPS * t * system.initial_state()[1]  # rounding of the time, at launch speed
    assert theta - n * turn == pytest.approx(0.0, abs=allowed)
    assert omega == pytest.approx(system.initial_state()[1], rel=1e-6)


def test_whirling_angle_does_not_jump():
    system = pendulum(V0=EDGE * 1.0001)
    t = np.linspace(0.0, 20 * system.period, 20001)
    theta, omega = system.exact(t)
    assert np.all(np.diff(theta) > 0.0)
    assert np.diff(theta).max() <= 1.001 * omega.max() * t[1]
    assert theta[-1] == pytest.approx(40 * math.pi, rel=1e-12)


def test_regimes_and_periods():
    assert [pendulum(V0=v).regime for v in (6.26, EDGE, 6.27)] == [
        "swinging",
        "separatrix",
        "whirling",
    ]
    assert pendulum(V0=EDGE).period == math.inf
    assert pendulum(V0=1e-6).period == pytest.approx(2 * math.pi / math.sqrt(9.81), rel=1e-12)
    angle = math.radians(60.0)  # published: the period at 60 degrees is 1.0732 times T0
    at_60 = pendulum(V0=EDGE * math.sin(angle / 2))
    assert at_60.largest_angle == pytest.approx(angle, rel=1e-14)
    assert at_60.period * math.sqrt(9.81) / (2 * math.pi) == pytest.approx(1.0732, abs=5e-5)


def test_small_angle_error_grows_as_the_cube_of_the_amplitude_and_linearly_in_time():
    t = np.linspace(0.0, 20.0, 20001)
    peaks = []
    for A in (0.01, 0.02):
        system = pendulum(V0=EDGE * math.sin(A / 2))
        error = np.abs(system.small_angle(t) - system.exact(t))[0]
        peaks.append((error[t <= 10.0].max(), error.max()))
        assert error.max() == pytest.approx(A**3 / 16 * math.sqrt(9.81) * 20, rel=0.06)
    (half, whole), (_, doubled) = peaks
    assert doubled / whole == pytest.approx(8.0, rel=1e-3)
    assert whole / half == pytest.approx(2.0, rel=0.1)


@pytest.mark.parametrize("factor", [2.1, 3.5, 4.0, 4.9])
def test_slack_is_noticed_where_energy_says(factor):
    system = pendulum(V0=-math.sqrt(factor * 9.81))
    run = system.solve((0.0, 3.0), rtol=1e-10, atol=1e-12, events="slack")
    assert run.status == 1
    time, (theta, omega) = run.t_events[0][0], run.y_events[0][0]
    allowed = 1e-10 * run.n_accepted * 50.0 * math.exp(3.2 * time)
    assert theta == pytest.approx(-system.slack_angle, abs=allowed)
    assert time == pytest.approx(system.slack_time, abs=2 * allowed / abs(omega))
    assert system.along(system.quantities["tension"], run.t, run.y)[:-1].min() > 0.0


@pytest.mark.parametrize("V0", [0.1, 4.4, 7.01, 20.0])
def test_a_cable_that_stays_taut_gives_no_event(V0):
    system = pendulum(V0=V0)
    run = system.solve((0.0, 5.0), events=["slack"])
    assert run.status == 0 and len(run.t_events[0]) == 0
    assert math.isnan(system.slack_angle) and math.isnan(system.slack_time)


def test_time_to_an_angle_inverts_the_exact_solution():
    for system in (pendulum(V0=5.0), pendulum(V0=-EDGE), pendulum(V0=8.0)):
        t = np.linspace(0.01, 0.4, 7)
        angles = system.exact(t)[0]
        assert [system.time_to(a) for a in angles] == pytest.approx(list(t), rel=1e-12)
        assert math.isnan(system.time_to(-angles[0]))
    assert math.isnan(pendulum(V0=5.0).time_to(2.0))
    assert math.isnan(pendulum(V0=5.0).time_to(2 * math.pi - 1.0))
    assert pendulum().time_to(0.0) == pendulum(V0=0.0).time_to(0.0) == 0.0


def test_tension_carries_the_weight_and_turns_the_motion():
    system = pendulum(V0=8.0, l=2.0, m=3.0)
    at_bottom, at_top = system.along(
        system.quantities["tension"], [0.0, 1.0], [[0.0, math.pi], [4.0, 1.0]]
    )
    assert at_bottom == pytest.approx(3.0 * (2.0 * 16.0 + 9.81))
    assert at_top == pytest.approx(3.0 * (2.0 * 1.0 - 9.81))


def test_turning_angle_close_to_the_top_has_all_its_digits():
    V0, g = EDGE * (1.0 - 1e-9), 9.81
    k_squared = Decimal(V0) ** 2 / (4 * Decimal(g))
    to_top = 2.0 * math.atan(math.sqrt((1 - k_squared) / k_squared))
    assert math.pi - pendulum(V0=V0).largest_angle == pytest.approx(to_top, rel=0, abs=4 * EPS)
