"""Claims about the course's systems: against its own matrices, its numbers, and its errata."""

import math
import warnings

import numpy as np
import pytest
import scipy.integrate

from fastdyn import CompileWarning
from fastdyn.course.lessons.building import printed
from fastdyn.course.lessons.pendulum_xy import velocity_matrix
from fastdyn.course.lessons.vehicle import coasting
from fastdyn.systems import (
    SYSTEMS,
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
    assert np.all(np.diff(run.quantities()["energy"]) < 0.0)
    blown = drag(vx0=0.0, vy0=0.0, vz0=0.0, wx=8.0).solve((0.0, 20.0), **TIGHT)
    c, g = 0.5, 9.81  # in the end the air carries the weight: c |u|^2 = g along (0, 0, -1)
    assert blown.y[3, -1] == pytest.approx(8.0, abs=1e-6)
    assert blown.y[5, -1] == pytest.approx(-math.sqrt(g / c), abs=1e-6)
    with pytest.raises(ValueError, match="vertically in still air"):
        drag(wx=1.0, vx0=0.0, vy0=0.0).exact(1.0)


def test_specific_drag_of_a_sphere():
    assert specific_drag(1.2, 0.47, 0.2, 0.5) == pytest.approx(math.pi * 1.2 * 0.47 * 0.04 / 4.0)


def test_without_an_earthquake_the_building_stands_still_and_the_printed_one_does_not():
    still = building(d=0.0)
    run = still.solve(**TIGHT)
    assert np.ptp(run.y[:2], axis=1).max() <= 1e-12 + 1e-10 * 20.0
    wrong = scipy.integrate.solve_ivp(
        printed, (0, 20), still.initial_state(), args=still.args[:6], **TIGHT
    )
    assert np.ptp(wrong.y[0]) > 0.05


def test_building_shakes_most_at_its_frequencies():
    t = np.linspace(0.0, 20.0, 4001)
    sway = {w: np.ptp(building(omega=w).exact(t)[1]) for w in (4.0, 8.74, 15.0, 22.882, 29.0)}
    assert min(sway[8.74], sway[22.882]) > 5.0 * max(sway[4.0], sway[15.0], sway[29.0])


def test_accelerations_are_integrated_exactly():
    times = np.sort(np.random.default_rng(5).uniform(0.0, 5.0, 20))
    samples = np.random.default_rng(6).normal(size=20)
    house = building.sampled(times, accelerations=samples)
    run = scipy.integrate.solve_ivp(
        lambda t, y: [y[1], np.interp(t, times, samples)],
        (times[0], times[-1]), [0.0, 0.0], t_eval=times, rtol=1e-11, atol=1e-13, max_step=0.01,
    )  # fmt: skip
    assert np.allclose(house.ground(times), run.y[0], rtol=0, atol=1e-8)
    outside = house.ground([times[0] - 1.0, times[-1] + 1.0])
    assert outside == pytest.approx([0.0, run.y[0, -1]], abs=1e-8)


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        ({"times": [0, 1], "displacements": [0, 1, 2]}, "as many samples"),
        ({"times": [1, 0], "displacements": [0, 1]}, "increase"),
        ({"times": [0, math.nan], "displacements": [0, 1]}, "finite"),
        ({"times": [0, 1], "displacements": [0, math.inf]}, "finite"),
        ({"times": [0, 1]}, "`displacements` or `accelerations`"),
        ({"times": [0, 1], "displacements": [0, 1], "accelerations": [0, 1]}, "or"),
    ],
)
def test_samples_that_make_no_motion_are_refused(arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        building.sampled(**arguments)
    with pytest.raises(ValueError, match="go together"):
        building(times=[0.0, 1.0])


def test_buildings_compare_and_hash():
    a, b = (building.sampled([0, 1, 2], displacements=[0, x, 0]) for x in (1, 2))
    assert a == building.sampled([0, 1, 2], displacements=[0, 1, 0]) != b
    assert len({a, b, building(), building()}) == 3


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


@pytest.mark.parametrize(
    "build, error, sentence",
    [
        (lambda: vehicle(driver=3), TypeError, "`driver` of the vehicle must be a function"),
        (lambda: vehicle(driver=lambda t: (0, 0, 0)), TypeError, "function of .t, w."),
        (lambda: vehicle(c=-1), ValueError, "`c` .* must not be negative"),
        (lambda: drag(c=-0.1), ValueError, "`c` .* must not be negative"),
        (lambda: rod(mu=-0.1), ValueError, "`mu` .* must not be negative"),
        (lambda: pendulum_xy(rate=-1.0), ValueError, "`rate` .* must not be negative"),
        (lambda: building(m=-1), ValueError, "`m` .* greater than zero"),
        (lambda: pendulum().solve(project=True), ValueError, "no constraints"),
        (lambda: pendulum().baumgarte(), ValueError, "no Baumgarte"),
        (lambda: pendulum_xy().solve(stabilise="glue"), TypeError, r"write `solve.project=True.`"),
        (lambda: pendulum_xy().ensemble(stabilise=None), TypeError, r"`system.baumgarte\(\)"),
        (lambda: pendulum_xy().solve(project="glue"), TypeError, "True, False or a function"),
        (lambda: projectile().scene(0.0, [0.0] * 6), ValueError, "no view"),
    ],
)
def test_wrong_systems_get_a_sentence(build, error, sentence):
    with pytest.raises(error, match=sentence):
        build()
