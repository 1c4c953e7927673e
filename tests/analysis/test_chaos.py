"""Sections and Lyapunov exponents beside closed and published ones."""

import math

import numpy as np
import pytest

from fastdyn import solve_ensemble, systems
from fastdyn.analysis import NotConvergedError, lyapunov, periodic_orbit, poincare


def circle(t, y, w):
    return [w * y[1], -w * y[0]]


def lorenz(t, y, s, r, b):
    return [s * (y[1] - y[0]), y[0] * (r - y[2]) - y[1], y[0] * y[1] - b * y[2]]


def henon_heiles(t, w):
    x, y, u, v = w
    return [u, v, -x - 2 * x * y, -y - x * x + y * y]


def energy(w):
    x, y, u, v = w
    return 0.5 * (u * u + v * v + x * x + y * y) + x * x * y - y**3 / 3


def start(y, v, E=1 / 8):
    return [0.0, y, math.sqrt(2 * E - y * y - v * v + 2 * y**3 / 3), v]


def duffing(t, y, drive):
    return [y[1], -0.3 * y[1] + y[0] - y[0] ** 3 + drive * np.cos(1.2 * t)]


def height(t, y, *args):
    return y[0]


def test_crossings_of_a_circle():
    found = poincare(circle, [0.0, 1.0], height, args=(2.0,), n_points=20, n_skipped=3)
    assert found.complete and np.allclose(np.diff(found.t), math.pi, atol=1e-8)
    assert np.allclose(found.y[0], 0, atol=1e-8) and np.allclose(found.y[1], 1, atol=1e-7)
    both = poincare(circle, [0.0, 1.0], height, args=(2.0,), n_points=20, direction=0)
    assert np.allclose(np.diff(both.t), math.pi / 2, atol=1e-8)
    down = poincare(circle, [0.0, 1.0], height, args=(2.0,), n_points=5, direction=-1)
    assert np.allclose(down.y[1], -1, atol=1e-7)


def test_once_in_a_period():
    found = poincare(circle, [[0, 1.0], [0, 2.0]], period=math.pi, args=(2.0,), n_points=4)
    assert found.y.shape == (2, 8) and list(found.start) == [0] * 4 + [1] * 4
    assert np.allclose(found.y[1], np.repeat([1, 2], 4), atol=1e-8)
    assert np.allclose(found.t, np.tile(math.pi * np.arange(4), 2))


def test_the_section_of_henon_heiles():
    """The energy is kept at all points; the section has the symmetry of the equations."""
    starts = [start(0.1, 0.05), start(0.3, 0.0)]
    found = poincare(henon_heiles, starts, height, n_points=1000)
    assert found.complete and len(found.t) == 2000
    assert np.abs(energy(found.y) - 1 / 8).max() < 1e-7
    assert np.abs(found.y[0]).max() < 1e-8 and (found.y[2] > 0).all()


def test_the_chain_of_five_islands_of_henon_and_heiles():
    """Figure 5 of Astron. J. 69 (1964) 73, at E = 1/8: each fifth point is in the same island."""
    found = poincare(henon_heiles, [start(0.57, 0.0)], height, n_points=300)
    points = found.y[[1, 3]]
    assert found.t[-1] > 1800
    centres = np.array([points[:, k::5].mean(1) for k in range(5)])
    for k in range(5):
        assert np.ptp(points[:, k::5], axis=1).max() < 0.03
        others = np.linalg.norm(np.delete(centres, k, 0) - centres[k], axis=1)
        assert others.min() > 0.1


def test_the_share_of_regular_orbits_of_henon_and_heiles():
    """Figure 7 of Astron. J. 69 (1964) 73: 1 at E = 1/12, a steep fall from 0.11 on, 0 at 1/6.

    An orbit counts as regular if a neighbour has not parted by a factor of 10^5 at t = 500: on a
    curve they part in proportion to t.
    """

    def varied(t, w):
        x, y, u, v, a, b, c, d = w
        rates = [u, v, -x - 2 * x * y, -y - x * x + y * y]
        return [*rates, c, d, -a - 2 * (a * y + x * b), -b - 2 * x * a + 2 * y * b]

    rng, n = np.random.default_rng(0), 400
    shares = []
    for E in (1 / 12, 0.11, 1 / 8, 0.14, 1 / 6):
        y, v = rng.uniform(-0.6, 1.0, 20 * n), rng.uniform(-0.6, 0.6, 20 * n)
        allowed = np.flatnonzero(2 * E - y * y - v * v + 2 * y**3 / 3 > 0)[:n]
        states = [[*start(y[i], v[i], E), 1.0, 0.0, 0.0, 1.0] for i in allowed]
        assert len(states) == n
        given = {"rtol": 1e-8, "atol": 1e-10}
        found = solve_ensemble(varied, (0, 500), states, **given)
        shares.append((np.linalg.norm(found.y_end[:, 4:], axis=1) < 1e5).mean())
    # A share of 400 starts has a standard deviation of at most 0.025; three times this.
    for share, expected in zip(shares, (1.0, 0.85, 0.5, 0.3, 0.0), strict=True):
        assert abs(share - expected) < 0.075
    assert shares == sorted(shares, reverse=True)


def test_an_event_of_a_system():
    found = poincare(systems.pendulum(), section="turning", n_points=4, direction=0)
    period = systems.pendulum().period
    assert np.allclose(np.diff(found.t), period / 2, rtol=1e-7)


def test_a_run_that_stops_crossing():
    def decay(t, y):
        return [-y[0]]

    found = poincare(duffing, [1.0, 3.0], height, args=(0.0,), n_points=50, max_steps=3000)
    assert not found.complete and "Start 0 has" in found.message and "max_steps" in found.message
    for wanted in (5, 200):
        none = poincare(decay, [1.0], lambda t, y: y[0] + 1, n_points=wanted)
        assert none.y.shape == (1, 0) and not none.complete and none.plot((0, 0))
        said = f"Start 0 has 0 points of {wanted}: the solution does not cross the section"
        assert said in none.message and "Radau" not in str(none)


def test_a_motion_that_only_drifts_away_crosses_no_more():
    found = poincare(lambda t, y: [y[1], 1.0], [-1.0, 0], height, n_points=3, max_steps=5000)
    assert len(found.t) == 1 and "does not cross the section again" in found.message


@pytest.mark.parametrize("period", [3.0, 2 * math.pi, math.pi])
def test_a_period_that_the_equations_do_not_have(period):
    def forced(t, y):
        return [y[1], -y[0] - 0.1 * y[1] + math.cos(2 * t)]

    if period != 3.0:
        assert poincare(forced, [0.0, 1.0], period=period, n_points=3).complete
        return
    with pytest.raises(ValueError, match=r"does not have the period 3: component 1 .* a multiple"):
        poincare(forced, [0.0, 1.0], period=period)
    with pytest.raises(ValueError, match="does not have the period 3"):
        periodic_orbit(forced, [0.0, 1.0], period)
    with pytest.raises(ValueError, match="does not have the period 3"):
        periodic_orbit(lambda t, y: [-y[0] + (0.3 < t % math.pi < 0.5)], [0.0], period)


@pytest.mark.parametrize(
    "given, kind, said",
    [
        ({}, ValueError, "Give a `section`"),
        ({"section": 3}, TypeError, "must be a function"),
        ({"section": "floor"}, ValueError, "no event 'floor'"),
        ({"section": height, "direction": 2}, ValueError, "`direction`"),
        ({"section": height, "n_points": 0}, ValueError, "`n_points`"),
        ({"period": math.nan}, ValueError, "`period`"),
        ({"period": 1.0, "t_eval": [1]}, TypeError, "the analysis sets it"),
    ],
)
def test_what_a_section_refuses(given, kind, said):
    with pytest.raises(kind, match=said):
        poincare(circle, [0.0, 1.0], args=(2.0,), **given)


def test_a_function_in_python():
    seen = []

    def counted(t, y):
        seen.append(t)
        return [y[1], -y[0]]

    with pytest.warns(UserWarning):
        found = poincare(counted, [0.0, 1.0], lambda t, y: y[0], n_points=3)
    assert np.allclose(np.diff(found.t), 2 * math.pi, atol=1e-8) and seen


def test_exponents_of_linear_equations():
    found = lyapunov(lambda t, y, A: A @ y, [1.0, 1, 1], (np.diag([-0.5, -1.0, -3.0]),), t_end=200)
    assert np.allclose(found.values, [-0.5, -1, -3], atol=1e-6)
    assert not found.chaotic and found.dimension == 0.0


def test_the_exponents_of_lorenz():
    """0.9056, 0, -14.5723 (Viswanath 1998; Sprott 2003); their sum is the divergence."""
    found = lyapunov(lorenz, [1.0, 1, 1], (10.0, 28.0, 8 / 3), t_end=800)
    assert found.errors.max() < 0.02 and found.chaotic
    published = np.array([0.90563, 0, -14.57219])
    assert (np.abs(found.values - published) < 4 * found.errors + 1e-3).all()
    assert math.isclose(found.values.sum(), -(10 + 1 + 8 / 3), rel_tol=1e-6)
    assert abs(found.dimension - 2.062) < 0.01
    assert found.running.shape == (3, len(found.t)) and np.isclose(found.t[-1], 800)


def test_the_exponents_of_henon_heiles():
    """Pairs of opposite sign; positive in the sea of chaos, zero on an island.

    A pair agrees up to the first and last frames, which count as 1 / t_end.  Chaotic orbits stay
    near islands for long: 60 starts 1e-12 apart have exponents from 0.023 to 0.072.
    """
    chaos = lyapunov(henon_heiles, start(-0.15, 0.0), t_end=1500)
    island = lyapunov(henon_heiles, start(0.3, 0.0), t_end=1500)
    for found in (chaos, island):
        assert np.allclose(found.values, -found.values[::-1], atol=5 / 1500)
        assert abs(found.values.sum()) < 1e-5
    assert chaos.chaotic and 0.01 < chaos.values[0] < 0.09
    assert abs(island.values).max() < 0.01


def test_the_exponents_of_forced_equations():
    found = lyapunov(duffing, [0.1, 0.0], (0.5,), t_end=5000)  # at 1000 off by up to 0.03
    assert found.chaotic and math.isclose(found.values.sum(), -0.3, rel_tol=1e-6)
    assert 0.08 < found.values[0] < 0.16


@pytest.mark.parametrize("t_end", [100, 500, 3000])
@pytest.mark.parametrize(
    "fun, y0",
    [
        (lambda t, y: [y[1], -np.sin(y[0])], [1.0, 0]),
        (lambda t, y: [y[1], -y[0] - y[0] ** 3], [2.0, 0]),
        (henon_heiles, start(0.3, 0.0)),
    ],
)
def test_regular_motion_has_no_exponent(fun, y0, t_end):
    """Neighbours part in proportion to the time: the exponents approach 0 as log(t) / t."""
    found = lyapunov(fun, y0, t_end=t_end)
    assert not found.chaotic and (np.abs(found.values) < 2.5 * found.errors).all()


def test_kinks_are_followed():
    """A spring that is stiff on one side: no damping, and all exponents are zero."""
    found = lyapunov(lambda t, y: [y[1], -4 * y[0] if y[0] > 0 else -y[0]], [1.0, 0], t_end=100)
    assert np.abs(found.values).max() < 0.05 and np.isclose(found.values.sum(), 0, atol=1e-6)


@pytest.mark.parametrize(
    "given, kind, said",
    [
        ({"fun": lambda t, y: [y[0] ** 2]}, NotConvergedError, "blows up"),
        ({"fun": lambda t, y: [y[0] ** 2], "transient": 0}, NotConvergedError, "fails"),
        ({"fun": lambda t, y: [y[1], -np.sign(y[0])], "y0": [1.0, 0]}, ValueError, "jumps at"),
        ({"fun": lambda t, y: [-np.sign(y[0])]}, NotConvergedError, "max_steps"),
        ({"fun": lambda t, y: [float(str(y[0]))]}, ValueError, "can be traced"),
        ({"fun": lambda t, y: [-y[0]], "t_end": -1}, ValueError, "`t_end`"),
        ({"fun": lambda t, y: [-y[0]], "interval": 1e-9}, ValueError, "too many"),
        ({"fun": lambda t, y: [-y[0]], "method": "RK5"}, ValueError, "RK5"),
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_what_exponents_refuse(given, kind, said):
    with pytest.raises(kind, match=said):
        lyapunov(**{"y0": [1.0]} | given)
