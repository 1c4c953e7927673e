"""Claims about WisdomHolman: exact for two bodies, symplectic, corrected, to rounding."""

import itertools
import threading

import numpy as np
import pytest

import fastdyn
from fastdyn.planets import Planets, outer_planets
from fastdyn.planets.corrector import PAIRS, coefficients
from fastdyn.planets.equations import angular_momentum, energy

EPS = np.finfo(float).eps

# J. Wisdom, Astron. J. 131 (2006), table 1: b_i of the corrector of a step that drifts, kicks,
# drifts, with a_i = i sqrt(7/40).
PUBLISHED = {
    3: [-0.024900596027799867],
    5: [-0.041500993379666446, 0.0083001986759332892],
    7: [-0.053964399093127499, 0.018270923246702131, -0.0024926811426922106],
    11: [
        -0.072593394748842739, 0.038121613681288651, -0.012309078592019946,
        0.0023487215292295354, -0.00020361579647854651,
    ],
    17: [
        -0.093056103771425959, 0.065192863576377894, -0.032422198864713581,
        0.012071760822342291, -0.0033132577069380656, 0.00063599983075817659,
        -0.000076436355227935738, 4.3347415473373580e-06,
    ],
}  # fmt: skip


def pair(e, mass=0.3, q=1.0):
    """Two bodies at their smallest distance q, of eccentricity e, G = 1, the sum of masses 1."""
    speed = np.sqrt((1.0 + e) / q)
    masses = np.array([1.0 - mass, mass])
    apart, faster = np.array([[0.0] * 3, [q, 0.0, 0.0]]), np.array([[0.0] * 3, [0.0, speed, 0.0]])
    return Planets(masses, apart - masses @ apart, faster - masses @ faster)


def relative(y):
    (a, b), (u, v) = np.reshape(y, (2, 2, 3))
    return b - a, v - u


def flight_time(x, v, e):
    """The time since the smallest distance 1, from the state alone, modulo a period."""
    a = 1.0 / (1.0 - e)
    r, rising = np.linalg.norm(x), x @ v
    if e == 0.0:
        return np.arctan2(x[1], x[0]) % (2.0 * np.pi)
    if e < 1.0:
        anomaly = np.arctan2(rising / np.sqrt(a), 1.0 - r / a)
        return a**1.5 * (anomaly - rising / np.sqrt(a)) % (2.0 * np.pi * a**1.5)
    anomaly = np.arcsinh(rising / np.sqrt(-a) / e)
    return (-a) ** 1.5 * (rising / np.sqrt(-a) - anomaly)


@pytest.mark.parametrize("e", [0.0, 0.3, 0.9, 0.999, 1.2, 5.0])
@pytest.mark.parametrize("step", [0.05, 0.7, 5.0, 1234.5])
def test_two_bodies_move_exactly_in_steps_of_any_length(e, step):
    """The orbit is kept, and the time of flight along it; errors are relative to their condition.

    An error of one unit in the last place of the state at the start moves the semi-major axis by
    some eps / (1 - e), and the phase by that times the revolutions.
    """
    for sign in (1.0, -1.0):
        run = pair(e).solve((0.0, sign * step), step=step)
        x, v = relative(run.y[:, -1])
        x0, v0 = relative(run.y[:, 0])
        spread = max(1.0, np.linalg.norm(x)) * max(1.0, np.linalg.norm(v))
        assert np.cross(x, v) == pytest.approx(np.cross(x0, v0), rel=0, abs=16 * EPS * spread)
        eccentricity = np.cross(v, np.cross(x, v)) - x / np.linalg.norm(x)
        size = 32 * EPS * spread * (1.0 + e)
        assert eccentricity == pytest.approx([e, 0.0, 0.0], rel=0, abs=size * np.linalg.norm(v + 1))
        axis = 1.0 / abs(1.0 - e)
        period = 2.0 * np.pi * axis**1.5 if e < 1.0 else np.inf
        late = flight_time(x * [1, sign, 1], v * [sign, 1, 1], e) - step % period
        late = min(abs(late), abs(abs(late) - period))
        revolutions = 1.0 + step / min(period, step)
        assert late < 64 * EPS * axis * revolutions * max(1.0, min(period, step)) * (1 + e) ** 2


def test_a_fall_and_a_throw_along_a_line_are_exact():
    """Without angular momentum: energy and line stay; r = (9 t^2 / 2)^(1/3) on the parabola."""
    masses = np.array([1.0, 0.0])
    for speed in (np.sqrt(2.0), 3.0, 0.5):
        run = Planets(masses, [[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [speed, 0, 0]]).solve(
            (0, 0.4), step=0.4
        )
        x, v = relative(run.y[:, -1])
        assert v @ v / 2 - 1 / np.linalg.norm(x) == pytest.approx(speed**2 / 2 - 1, abs=8 * EPS)
        assert (x[1:] == 0).all()
        if speed == np.sqrt(2.0):
            assert x[0] == pytest.approx(
                (4.5 * (0.4 + np.sqrt(2) / 3) ** 2) ** (1 / 3), rel=8 * EPS
            )


@pytest.mark.parametrize("order", [3, 5, 7, 11, 17])
def test_the_corrector_has_the_published_coefficients(order):
    found = coefficients(order, kicks_first=False)
    assert [b for _, b in found] == pytest.approx(PUBLISHED[order], rel=1e-15, abs=1e-21)
    assert [a for a, _ in found] == pytest.approx(np.sqrt(7 / 40) * np.arange(1, PAIRS[order] + 1))


@pytest.mark.parametrize("order", [3, 5, 7, 11, 17])
def test_the_corrector_takes_the_error_of_first_order_away(order):
    """a w(a) = (a/2) coth(a/2) - 1 up to the order; the next term is of the next odd order."""
    pairs = coefficients(order)
    misses = []
    for a in (0.2, 0.1) if order < 11 else (1.6, 0.8):
        w = 4.0 * sum(b * np.sinh(s * a) for s, b in pairs)
        misses.append(abs(a * w - (0.5 * a / np.tanh(0.5 * a) - 1.0)))
    assert np.log2(misses[0] / misses[1]) == pytest.approx(2 * PAIRS[order] + 2, abs=1.0)


def system(scale=1.0, e=0.05):
    """A star of mass 1 and two planets of scale times 1e-3 and 5e-4."""
    m = np.array([1.0, 1e-3 * scale, 5e-4 * scale])
    q = np.array([[0, 0, 0], [1 - e, 0, 0.02], [-1.9, 0.3, 0]])
    v = np.array([[0, 0, 0], [0, np.sqrt((1 + e) / (1 - e)), 0], [-0.1, -0.71, 0.01]])
    return Planets(m, q - m @ q / m.sum(), v - m @ v / m.sum())


def errors(p, corrector, step, n=400, count=97):
    """Relative energy errors over n steps."""
    run = p.solve(
        (0, n * step), step=step, t_eval=np.linspace(0, n * step, count), corrector=corrector
    )
    assert run.success
    found = np.array([energy(0.0, y, *p.args) for y in run.y.T])
    return np.abs(found / found[0] - 1.0).max()


@pytest.mark.parametrize(("corrector", "in_step", "in_mass"), [(0, 2, 1), (3, 4, 1), (17, 4, 2)])
def test_errors_have_the_orders_in_the_step_and_in_the_masses(corrector, in_step, in_mass):
    """Without corrector m h^2, of order 3 m h^4, of order 17 m^2 h^4 is left."""
    coarse, fine = (errors(system(), corrector, h, round(64 / h)) for h in (0.32, 0.16))
    assert np.log2(coarse / fine) > in_step - 0.5
    heavy, light = (errors(system(scale), corrector, 0.24) for scale in (2.0, 0.5))
    assert np.log2(heavy / light) / 2.0 == pytest.approx(in_mass, abs=0.35)


def test_the_corrector_gains_what_it_promises():
    plain, corrected = (errors(outer_planets(), corrector, 0.25) for corrector in (0, 17))
    assert corrected < 1e-5 * plain
    assert corrected < 1e-11


def test_a_motion_goes_back_to_its_start():
    """Back and forth, also between steps; what is left is rounding."""
    p = outer_planets()
    there = p.solve((0.0, 400.1), step=0.25)
    q, v = there.y[:, -1].reshape(2, -1, 3)
    back = Planets(p.masses, q, v, p.G).solve((400.1, 0.0), step=0.25)
    assert back.y[:, -1] == pytest.approx(p.initial_state(), rel=0, abs=1e-9)
    small = system()
    there = small.solve((0.0, 60.0), step=0.3)
    q, v = there.y[:, -1].reshape(2, -1, 3)
    back = Planets(small.masses, q, v).solve((60.0, 0.0), step=0.3)
    assert back.y[:, -1] == pytest.approx(small.initial_state(), rel=0, abs=1e-12)


def test_angular_momentum_and_the_centre_of_mass_keep_to_rounding():
    p = outer_planets()
    moving = Planets(p.masses, p.q0 + np.array([1, 2, 3]), p.v0 + np.array([0.3, -0.1, 0.2]), p.G)
    run = moving.solve((0, 1000), step=0.3, t_eval=np.linspace(0, 1000, 41))
    for y, t in zip(run.y.T, run.t, strict=True):
        centre = p.masses @ y[:18].reshape(6, 3) / p.masses.sum()
        assert centre == pytest.approx(
            np.array([1, 2, 3]) + t * np.array([0.3, -0.1, 0.2]), rel=1e-14
        )
    run = p.solve((0, 1000), step=0.3, t_eval=np.linspace(0, 1000, 41))
    found = [angular_momentum(0.0, y, *p.args) for y in run.y.T]
    assert np.abs(np.array(found) / found[0] - 1).max() < 16 * EPS


@pytest.mark.hunt
def test_the_motion_is_that_of_the_equations():
    """Beside Taylor over a hundred years, outputs between steps, in any order of the bodies."""
    p = outer_planets()
    mixed = [0, 3, 5, 1, 2, 4]
    t = np.linspace(0, 100, 13)
    run = Planets(p.masses[mixed], p.q0[mixed], p.v0[mixed], p.G).solve(
        (0, 100), step=0.1, t_eval=t
    )
    exact = fastdyn.solve_ivp(
        p.rhs, (0, 100), p.initial_state(), "Taylor", t_eval=t, rtol=1e-15, atol=1e-18, args=p.args
    )
    wanted = exact.y.reshape(2, 6, 3, -1)[:, mixed]
    assert run.y.reshape(2, 6, 3, -1) == pytest.approx(wanted, rel=0, abs=2e-10)


def test_outputs_change_nothing_and_keep_the_energy():
    p = outer_planets()
    plain = p.solve((0, 300), step=0.2)
    t = np.sort(np.random.default_rng(3).uniform(0, 300, 40))
    watched = p.solve((0, 300), step=0.2, t_eval=[*t, 300])
    assert (watched.y[:, -1] == plain.y[:, -1]).all()
    found = np.array([energy(0.0, y, *p.args) for y in watched.y.T])
    assert np.abs(found / energy(0.0, p.initial_state(), *p.args) - 1).max() < 4e-12
    fine = p.solve((0, 300), step=0.1, t_eval=t)
    assert watched.y[:, :-1] == pytest.approx(fine.y, rel=0, abs=1e-8)
    assert plain.nfev == 2 + 2 * 1500 and plain.n_accepted == 1500


def test_a_long_run_drifts_as_rounding_does():
    """10^6 steps: a share of Brouwer's 2^-53 sqrt(steps), and no line in time."""
    p = outer_planets()
    t = np.linspace(0, 1e5, 201)
    run = p.solve((0, 1e5), step=0.1, t_eval=t)
    found = np.array([energy(0.0, y, *p.args) for y in run.y.T])
    changes = found / found[0] - 1
    assert np.abs(changes).max() < 8 * 2.0**-53 * 1e3
    run = pair(0.1, 0.0).solve((0, 6e5), step=0.6, t_eval=np.linspace(0, 6e5, 201))
    x, v = run.y.reshape(2, 2, 3, -1)[:, 1]
    found = 0.5 * (v**2).sum(0) - 1 / np.sqrt((x**2).sum(0))
    assert np.abs(found / found[0] - 1).max() < 4 * 2.0**-53 * 1e3


def test_a_stopped_run_goes_on_from_its_checkpoint(tmp_path, monkeypatch):
    from fastdyn.planets import run as module

    p, file = outer_planets(), tmp_path / "planets.npz"
    t = np.linspace(0, 500, 6)
    whole = p.solve((0, 500), step=0.1, t_eval=t)
    begins, calls = [], itertools.count()
    advance = module.PlanetSteps.advance

    def stopped(self, *given):
        begins.append(self.n_steps)
        if next(calls) == 12:
            raise KeyboardInterrupt
        return advance(self, *given)

    monkeypatch.setattr(module.PlanetSteps, "advance", stopped)
    with pytest.raises(KeyboardInterrupt):
        p.solve((0, 500), step=0.1, t_eval=t, checkpoint=file)
    again = p.solve((0, 500), step=0.1, t_eval=t, checkpoint=file)
    assert (again.y == whole.y).all() and again.n_accepted == whole.n_accepted
    assert begins[13] == begins[12] > 0
    with pytest.raises(ValueError, match="another run; what differs: step"):
        p.solve((0, 500), step=0.2, t_eval=t, checkpoint=file)


def test_threads_do_not_disturb_each_other():
    p, found = outer_planets(), {}

    def work(step):
        found[step] = p.solve((0, 200), step=step).y[:, -1]

    threads = [threading.Thread(target=work, args=(step,)) for step in (0.1, 0.2, 0.25, 0.4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for step, y in found.items():
        assert (y == p.solve((0, 200), step=step).y[:, -1]).all()


@pytest.mark.parametrize("n", [1, 2, 4, 5, 9])
def test_any_number_of_planets_fills_its_lanes(n):
    """The first steps agree with the series of the equations."""
    rng = np.random.default_rng(n)
    a, angle = 1.5 ** np.arange(n), rng.uniform(0, 6, n)
    m = np.r_[1.0, 1e-4 * rng.uniform(0.5, 1, n)]
    q = np.r_[[[0, 0, 0]], np.c_[a * np.cos(angle), a * np.sin(angle), 0.01 * a]]
    v = np.r_[[[0, 0, 0]], np.c_[-np.sin(angle), np.cos(angle), 0 * a] / np.sqrt(a)[:, None]]
    p = Planets(m, q, v)
    run = p.solve((0, 1), step=0.02)
    exact = fastdyn.solve_ivp(
        p.rhs, (0, 1), p.initial_state(), "DOP853", rtol=1e-13, atol=1e-14, args=p.args
    )
    assert run.y[:, -1] == pytest.approx(exact.y[:, -1], rel=0, abs=1e-11)
