"""What no hand derives: invariants held, and exact or published values."""

import functools
import math

import numpy as np
import pytest

from fastdyn.derive import Model, dot, i, j
from fastdyn.derive.pages import PAGES, page
from support import few

EPS = np.finfo(float).eps
TIGHT = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}
NEW = (
    "double_pendulum", "triple_pendulum", "closed_chain", "four_bar", "spherical_pendulum",
    "heavy_top", "rolling_disc", "chaplygin_sleigh",
)  # fmt: skip
TWICE = (
    "double_pendulum", "spherical_pendulum", "chaplygin_sleigh", "heavy_top", "rolling_disc",
)  # fmt: skip


@functools.cache
def system_of(name, law="derive"):
    return getattr(page(name), law)().system


def random_states(system, count, seed=3):
    rng = np.random.default_rng(seed)
    start = np.array(system.initial_state())
    for _ in range(count):
        y = start + 0.2 * rng.normal(size=len(start))
        for _ in range(4 if system.constraints else 0):
            y = np.array(system.project(0.0, y, *system.args))
        yield y


def slopes(system, y):
    """The Jacobian of the right-hand side by central differences, to about 1e-9."""
    h, columns = 1e-5, []
    for n in range(len(y)):
        ahead, behind = np.array(y, float), np.array(y, float)
        ahead[n] += h
        behind[n] -= h
        there, here = (system.rhs(0.0, one, *system.args) for one in (ahead, behind))
        columns.append((np.array(there) - here) / (2 * h))
    return np.array(columns).T


def frequencies(system, y):
    """Squares of the frequencies of small motions about a rest."""
    values = np.linalg.eigvals(slopes(system, y))
    return np.sort(-np.real(values**2))[::2]


@pytest.mark.parametrize("name", few.hunts(NEW, "four_bar", "chaplygin_sleigh"))
def test_motion_keeps_its_invariants_and_constraints(name):
    system = system_of(name)()
    run = system.solve((0.0, 3.0), project=True if system.constraints else None, **TIGHT)
    assert run.success and "energy" in system.invariants
    for values in run.invariants().values():
        assert np.ptp(values) <= 1e-7 * max(1.0, np.abs(values).max())
    for values in run.residuals().values():
        assert np.abs(values).max() <= 1e-12


@pytest.mark.parametrize("name", few.hunts(TWICE, "spherical_pendulum"))
def test_newton_and_lagrange_give_the_same_motion(name):
    newton, lagrange = system_of(name, "newton")(), system_of(name, "lagrange")()
    assert newton.derivation.law == "newton" and lagrange.derivation.law == "lagrange"
    for y in random_states(newton, 10):
        a, b = (np.array(one.rhs(0.5, y, *one.args)) for one in (newton, lagrange))
        assert np.abs(a - b).max() <= 1e5 * EPS * np.abs(a).max()


@pytest.mark.parametrize("name", ["double_pendulum", "triple_pendulum"])
def test_small_swings_have_the_zeros_of_laguerre_polynomials(name):
    """M. Braun, Archive of Applied Mechanics 72 (2003) 899: equal masses and lengths."""
    system, n = system_of(name)(), len(system_of(name).states) // 2
    zeros = np.polynomial.laguerre.lagroots([0] * n + [1])
    assert frequencies(system, np.zeros(2 * n)) == pytest.approx(9.81 * zeros, rel=1e-7)


def test_rods_of_the_double_pendulum_carry_the_weight():
    system = system_of("double_pendulum")(m1=2.0, m2=3.0)
    forces = [system.quantities[name](0.0, np.zeros(4), *system.args) for name in ("R1", "R2")]
    assert forces == pytest.approx([5.0 * 9.81, 3.0 * 9.81], rel=8 * EPS)


def chain_by_places():
    """The closed chain in x and y of its masses, with four forces in its rods."""
    board = Model("by_places")
    m, l, g, d = board.parameters(m=(1.0, ""), l=(1.0, ""), g=(9.81, ""), d=(2.5, ""))
    coordinates = board.coordinates("x1 y1 x2 y2 x3 y3")
    R = board.reactions("R1 R2 R3 R4")
    places = [0 * i, *(coordinates[n] * i + coordinates[n + 1] * j for n in (0, 2, 4)), d * i]
    masses = [board.particle(m, r) for r in places[1:4]]
    board.gravity(-g * j)
    for n in range(4):
        rod = places[n + 1] - places[n]
        if n:
            masses[n - 1].force(R[n] * rod / l)
        if n < 3:
            masses[n].force(-R[n] * rod / l)
        board.constrain((dot(rod, rod) - l**2) / (2 * l))
    angles = system_of("closed_chain")().initial_state()[:3]
    start = np.cumsum([(math.sin(a), -math.cos(a)) for a in angles], axis=0).ravel()
    board.guess(**{str(q.func): value for q, value in zip(coordinates, start, strict=True)})
    return board.newton().system()


@pytest.mark.hunt
def test_closed_chain_is_that_of_its_masses():
    by_angles, by_places = system_of("closed_chain")(), chain_by_places()
    for y in random_states(by_angles, 5):
        angle, rate = y[:3], y[3:]
        across = np.array([np.cos(angle), np.sin(angle)]).T
        places = np.cumsum(np.array([np.sin(angle), -np.cos(angle)]).T, axis=0).ravel()
        speeds = np.cumsum(across * rate[:, None], axis=0).ravel()
        turn = np.array(by_angles.rhs(0.0, y, *by_angles.args))[3:]
        inwards = np.array([-np.sin(angle), np.cos(angle)]).T
        expected = np.cumsum(across * turn[:, None] + inwards * rate[:, None] ** 2, axis=0).ravel()
        there = np.concatenate([places, speeds])
        found = np.array(by_places.rhs(0.0, there, *by_places.args))[6:]
        assert found == pytest.approx(expected, rel=1e-11, abs=1e-11 * np.abs(expected).max())
        multiplier = by_angles.quantities["lambda_fourth_rod"](0.0, y, *by_angles.args)
        rod = by_places.quantities["R4"](0.0, there, *by_places.args)
        assert multiplier == pytest.approx(-rod, rel=1e-10)


def test_crank_of_the_four_bar_comes_round_with_its_speed():
    """Freudenstein's equation on the way; after a turn all is as before."""
    system = system_of("four_bar")()
    round_again = lambda t, y, *_: y[0] - 0.5 - 2 * math.pi  # noqa: E731
    round_again.terminal = True
    run = system.solve((0.0, 10.0), project=True, events=round_again, **TIGHT)
    assert run.status == 1
    assert run.y[3:, -1] == pytest.approx(run.y[3:, 0], rel=1e-7)
    a, b, c, d = system.args[:4]
    th, ps = run.y[0], run.y[2]
    off = d / a * np.cos(ps) - d / c * np.cos(th) + (a * a - b * b + c * c + d * d) / (2 * a * c)
    assert np.abs(off - np.cos(th - ps)).max() <= 1e-12


def test_spherical_pendulum_as_a_cone():
    """tan a = w² r / g: the mass stays at its height, the cable carries m g / cos a."""
    lean, g = 0.7, 9.81
    speed = math.sin(lean) * math.sqrt(g / math.cos(lean))
    system = system_of("spherical_pendulum")(x0=math.sin(lean), v0=speed)
    run = system.solve((0.0, 5.0), project=True, **TIGHT)
    assert run.y[2] == pytest.approx(-math.cos(lean), rel=1e-9)
    assert run.quantities()["R"] == pytest.approx(g / math.cos(lean), rel=1e-8)


def test_steady_precession_of_the_top():
    """A phi'² cos - C w3 phi' + m g l = 0 with A at the pivot (Goldstein, chapter 5)."""
    system = system_of("heavy_top")(tilt=0.5)
    m, l, g, A, C = system.args
    about, turn = A + m * l * l, 8.0
    w3 = (about * turn**2 * math.cos(0.5) + m * g * l) / (C * turn)
    start = [0.0, 0.5, 0.0, turn, 0.0, w3 - turn * math.cos(0.5)]
    run = system.solve((0.0, 2.0), start, **TIGHT)
    assert run.y[1] == pytest.approx(0.5, abs=1e-8)
    forces = run.quantities()
    inwards = np.hypot(forces["X"], forces["Y"])
    assert forces["Z"] == pytest.approx(m * g, rel=1e-7)
    assert inwards == pytest.approx(m * l * math.sin(0.5) * turn**2, rel=1e-7)


def test_released_top_nuts_as_deep_as_its_cubic_says():
    """(u0 - u) (alpha (1 - u²) - a² (u0 - u)) = 0 with u = cos theta (Goldstein, chapter 5)."""
    system = system_of("heavy_top")(tilt=0.5, spin=60.0)
    m, l, g, A, C = system.args
    about, u0 = A + m * l * l, math.cos(0.5)
    a, alpha = C * 60.0 / about, 2 * m * g * l / about
    p = a * a / (2 * alpha)
    deepest = math.acos(p - math.sqrt(1.0 - 2.0 * p * u0 + p * p))
    run = system.solve((0.0, 2.0), dense_output=True, events=lambda t, y, *_: y[4], **TIGHT)
    turns = np.concatenate(run.y_events)[:, 1]
    assert turns.max() == pytest.approx(deepest, rel=1e-8)
    assert run.y[1].max() <= deepest * (1.0 + 1e-8)


@pytest.mark.parametrize(("faster", "stable"), [(1.01, True), (0.99, False)])
def test_disc_stays_upright_above_its_critical_spin(faster, stable):
    """spin² > g/(3 a) for a thin uniform disc (Neimark and Fufaev, Nonholonomic Systems)."""
    system = system_of("rolling_disc")()
    spin = faster * math.sqrt(9.81 / (3.0 * system.a))
    upright = [0.0, 0.0, 0.0, 0.0, 0.0, system.a * spin, 0.0, 0.0, 0.0, spin]
    growth = np.linalg.eigvals(slopes(system, upright)).real.max()
    assert (growth < 1e-3) == stable  # the neutral modes are zero to the root of 1e-9


def test_chaplygin_sleigh_is_its_hyperbolic_functions():
    """u = V tanh, w = w0 / cosh (A. M. Bloch, Nonholonomic Mechanics and Control, 1.7)."""
    system = system_of("chaplygin_sleigh")(u0=0.0, w0=2.0)
    m, I, a = system.args
    J = I + m * a * a
    run = system.solve((0.0, 6.0), project=True, **TIGHT)
    V = 2.0 * math.sqrt(J / m)
    s = m * a / J * V * run.t
    u, w = V * np.tanh(s), 2.0 / np.cosh(s)
    heading = run.y[2]
    assert run.y[5] == pytest.approx(w, abs=1e-8)
    assert run.y[3] * np.cos(heading) + run.y[4] * np.sin(heading) == pytest.approx(u, abs=1e-8)
    assert run.quantities()["R"] == pytest.approx(m * u * w * I / J, abs=1e-7)


def test_every_page_is_asked_for_somewhere():
    from test_derived_course import SAME

    assert {*SAME, *NEW} == set(PAGES)
