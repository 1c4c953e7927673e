"""Claims about the course's systems: against its numbers, and its errata."""

import math
import warnings

import numpy as np
import pytest

from fastdyn import CompileWarning, SwitchingWarning
from fastdyn.systems import (
    SYSTEMS,
    System,
    building,
    drag,
    nanoparticle,
    pendulum,
    pendulum_xy,
    projectile,
    rod,
    suspension,
    tower,
    vehicle,
)
from fastdyn.systems.drag import specific_drag

EPS = np.finfo(float).eps
TIGHT = {"rtol": 1e-10, "atol": 1e-12}


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_system_compiles_and_runs_from_its_defaults(name):
    system = SYSTEMS[name]()
    with warnings.catch_warnings():
        warnings.simplefilter("error", CompileWarning)
        # On a circle the apsides are where the error crosses zero, twice in some steps.
        warnings.filterwarnings("ignore", "`.*apsis` crosses zero", SwitchingWarning)
        run = system.solve(events=list(system.events.values()) or None)
    assert run.success and np.isfinite(run.y).all()


@pytest.mark.parametrize(
    "value, published, half_a_digit",
    [
        (tower().range, 37.10, 0.005),
        (tower(V=11.0).range, 36.40, 0.005),
        (tower().best_range, 44.39, 0.005),
        (math.degrees(tower().best_angle), 16.0, 0.05),
        (1e3 * nanoparticle().apex_height, 7.9, 0.05),
        (1e3 * nanoparticle().apex_height_at_mean_speed, 6.7, 0.05),
        (building().lower_frequency, 8.740, 0.0005),
        (building().upper_frequency, 22.882, 0.0005),
    ],
)
def test_derived_answers_are_those_published(value, published, half_a_digit):
    assert abs(value - published) <= half_a_digit


def test_best_angle_is_a_maximum_of_the_range():
    best = tower().best_angle
    around = [tower(angle=best + d).range for d in (-1e-3, 0.0, 1e-3)]
    assert around[1] > max(around[0], around[2]) and around[1] == pytest.approx(tower().best_range)


@pytest.mark.parametrize("system", [projectile(z0=5.0), tower(angle=1.0), nanoparticle()], ids=str)
def test_apex_and_impact_are_events(system):
    run = system.solve((0.0, 100.0), events=["apex", "ground"], **TIGHT)
    assert run.status == 1 and len(run.t_events[0]) == 1
    up = system.V * math.sin(1.0) if system.name == "tower" else run.y[-1, 0]
    assert run.t_events[0][0] == pytest.approx(up / system.g)
    if hasattr(system, "flight_time"):
        assert run.t[-1] == pytest.approx(system.flight_time, rel=1e-9)


def test_suspension_tells_its_frequency_by_its_deflection():
    system = suspension()
    assert math.sqrt(system.g / system.static_deflection) == pytest.approx(
        system.natural_frequency, rel=4 * EPS
    )
    assert suspension(x0=system.equilibrium).amplitude == 0.0
    still = suspension(x0=system.equilibrium).solve(**TIGHT)
    assert np.ptp(still.y[0]) <= 1e-12 + 1e-10


@pytest.mark.parametrize("mu", [0.0, 0.3, 2.0])
def test_block_on_the_rod(mu):
    system = rod(mu=mu)
    run = system.solve(**TIGHT)
    growth = math.exp(system.growth_rate * system.t_end)
    assert np.abs(run.error()).max() <= run.n_accepted * 1e-9 * growth


@pytest.mark.parametrize("vz0", [20.0, 0.0, -2.0, -math.sqrt(9.81 / 0.5), -30.0])
def test_vertical_throw_with_drag_is_exact(vz0):
    system = drag(vx0=0.0, vy0=0.0, vz0=vz0, z0=100.0)
    run = system.solve(**TIGHT)
    assert np.abs(run.error()).max() <= run.n_accepted * 1e-10 * 100.0


def test_drag_only_takes_energy_and_wind_may_give_it():
    run = drag().solve(**TIGHT)
    energy = drag.quantities["energy"]
    assert np.all(np.diff(run.system.along(energy, run.t, run.y)) < 0.0)
    blown = drag(vx0=0.0, vy0=0.0, vz0=0.0, wx=8.0).solve((0.0, 20.0), **TIGHT)
    c, g = 0.5, 9.81  # in the end the air carries the weight: c |u|^2 = g along (0, 0, -1)
    assert blown.y[3, -1] == pytest.approx(8.0, abs=1e-6)
    assert blown.y[5, -1] == pytest.approx(-math.sqrt(g / c), abs=1e-6)
    with pytest.raises(ValueError, match="vertically in still air"):
        drag(wx=1.0, vx0=0.0, vy0=0.0).exact(1.0)


def test_specific_drag_of_a_sphere():
    expected = pytest.approx(math.pi * 1.2 * 0.47 * 0.04 / 4.0)
    assert specific_drag(1.2, 0.47, 0.2, 0.5) == expected
    assert drag.specific_drag(rho=1.2, C_D=0.47, D=0.2, m=0.5) == expected


@pytest.mark.parametrize(
    "build, error, sentence",
    [
        (lambda: vehicle(driver=3), TypeError, "`driver` of the vehicle must be a function"),
        (lambda: vehicle(driver=lambda t, w, u: (0, 0, 0)), TypeError, "function of .t, w."),
        (lambda: vehicle(c=-1), ValueError, "`c` .* must not be negative"),
        (lambda: drag(c=-0.1), ValueError, "`c` .* must not be negative"),
        (lambda: rod(mu=-0.1), ValueError, "`mu` .* must not be negative"),
        (lambda: rod().ensemble(mu=np.array([0.1, -0.1])), ValueError, "`mu` .* negative"),
        (lambda: pendulum_xy(rate=-1.0), ValueError, "`rate` .* must not be negative"),
        (lambda: building(m=-1), ValueError, "`m` .* greater than zero"),
        (lambda: pendulum().solve(project=True), ValueError, "no constraints"),
        (lambda: pendulum().baumgarte(), ValueError, "no Baumgarte"),
        (lambda: pendulum_xy().solve(stabilise="glue"), TypeError, r"write `solve.project=True.`"),
        (lambda: pendulum_xy().ensemble(stabilise=None), TypeError, r"`system.baumgarte\(\)"),
        (lambda: pendulum_xy().solve(project="glue"), TypeError, "True, False or a function"),
        (lambda: System.scene(projectile(), 0.0, [0.0] * 6), ValueError, "no view"),
    ],
)
def test_wrong_systems_get_a_sentence(build, error, sentence):
    with pytest.raises(error, match=sentence):
        build()
