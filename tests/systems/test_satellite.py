"""Claims about the satellite: Kepler's orbits, the course's erratum, apsides, drift."""

import math

import numpy as np
import pytest

from fastdyn.course.lessons.satellite import allowance
from fastdyn.systems import satellite
from fastdyn.systems.formulas.kepler import eccentric_anomaly

EPS = np.finfo(float).eps


@pytest.mark.parametrize("method", ["RK45", "DOP853", "Tsit5", "Vern7", "Vern9", "ode45"])
@pytest.mark.parametrize("rtol", [1e-6, 1e-10])
@pytest.mark.parametrize("V", [1.0, 1.2, -0.8])
def test_computed_orbit_is_as_exact_as_its_tolerance(V, rtol, method):
    run = satellite(V=V).solve((0.0, 30.0), method=method, rtol=rtol, atol=rtol)
    assert run.success
    assert np.abs(run.error()).max() <= allowance(run, rtol, rtol)


def test_tighter_tolerance_makes_the_error_smaller_in_proportion():
    loose, tight = (
        np.abs(satellite(V=1.2).solve(rtol=rtol, atol=rtol).error()).max() for rtol in (1e-6, 1e-9)
    )
    assert 1e-3 / 3.0 < tight / loose < 3e-3


@pytest.mark.parametrize("name", ["vmag from components 1 and 2", "vmag from 3 and 4"])
def test_erratum_of_the_printed_energy(name):
    def printed(w):
        r = math.sqrt(w[0] ** 2 + w[1] ** 2)
        vmag = r if name.endswith("1 and 2") else math.sqrt(w[2] ** 2 + w[3] ** 2)
        return -1.0 / r + vmag**2 / 2

    t = np.linspace(0.0, 20.0, 101)
    circle, ellipse = (np.array([printed(w) for w in satellite(V=V).exact(t).T]) for V in (1, 1.2))
    assert np.ptp(circle) < 100 * EPS  # where r = v = 1 the slip cannot be seen
    if name.endswith("1 and 2"):
        assert np.ptp(ellipse) > 1.0
    else:
        assert np.ptp(ellipse) < 100 * EPS
        system = satellite(V=1.2)
        ours = system.along(system.invariants["energy"], t, system.exact(t))
        assert np.allclose(ours, ellipse, rtol=10 * EPS)


@pytest.mark.parametrize("e", [0.0, 0.3, -0.7, 0.99, -0.999999, 1.0 - 1e-12])
def test_kepler_equation_is_solved_to_rounding_and_continuously(e):
    M = np.concatenate([np.linspace(-20.0, 20.0, 4001), [1e-12, -1e-6, math.pi, 1e5]])
    u = eccentric_anomaly(M, e)
    assert np.all(np.abs(u - e * np.sin(u) - M) <= 4 * EPS * (2 * math.pi + np.abs(M)))
    assert np.all(np.diff(u[:4001]) > 0.0)


@pytest.mark.parametrize("V", [1.2, -1.2])
def test_apsides_and_revolutions_come_at_half_periods(V):
    system = satellite(V=V)
    run = system.solve(
        (0.0, 50.0), rtol=1e-10, atol=1e-12, events=["periapsis", "apoapsis", "revolution"]
    )
    near, far, laps = (times[times > 1e-6] for times in run.t_events)
    allowed = allowance(run, 1e-10, 1e-12)
    assert near == pytest.approx(system.period * np.arange(1, len(near) + 1), abs=allowed)
    assert far == pytest.approx(system.period * (np.arange(len(far)) + 0.5), abs=allowed)
    assert len(laps) == len(near) == 3 and laps == pytest.approx(near, abs=allowed)


def test_derived_answers_of_the_satellite():
    circle = satellite()
    assert (circle.period, circle.eccentricity) == (pytest.approx(2 * math.pi), 0.0)
    assert satellite(V=1.2).semi_major_axis == pytest.approx(1 / (2 - 1.44))
    assert satellite(GM=4.0, R=2.0).escape_speed == pytest.approx(2.0)
    assert satellite(V=1.5).eccentricity == pytest.approx(1.25)


@pytest.mark.parametrize("V", [0.0, 1.5, math.sqrt(2.0) * (1 + 1e-12), -2.0, 1e-9])
def test_an_orbit_that_is_no_ellipse_is_refused_with_a_reason(V):
    system = satellite(V=V)
    for ask in (lambda: system.exact(1.0), lambda: system.period):
        with pytest.raises(ValueError, match=r"no ellipse: .* Choose V between 0 and 1\.41421"):
            ask()


def test_velocity_verlet_keeps_the_energy_error_bounded():
    step = 0.02
    run = satellite(V=1.2).solve((0.0, 600.0), method="VelocityVerlet", step=step)
    energy = run.invariants()["energy"]
    change = np.abs(energy - energy[0])
    first, last = change[run.t < 15.0].max(), change[run.t > 585.0].max()
    assert last == pytest.approx(first, rel=0.05)
    momentum = run.invariants()["angular_momentum"]
    assert np.ptp(momentum) <= EPS * run.n_accepted
