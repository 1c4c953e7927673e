"""Periodic orbits and their branches beside published and closed ones."""

import math

import numpy as np
import pytest
from scipy.special import mathieu_a, mathieu_b

from fastdyn import systems
from fastdyn.analysis import NotConvergedError, continuation, periodic_orbit


def van_der_pol(t, y, mu):
    return [y[1], mu * (1 - y[0] ** 2) * y[1] - y[0]]


def hopf(t, y, mu):
    """r' = mu r - r³ with the angle's rate 1: a cycle of r = sqrt(mu), multiplier exp(-4 pi mu)."""
    square = y[0] ** 2 + y[1] ** 2
    return [(mu - square) * y[0] - y[1], (mu - square) * y[1] + y[0]]


def subcritical(t, y, mu):
    """r' = r (mu + 2 r² - r⁴): cycles of r² = 1 ± sqrt(1 + mu), a fold at mu = -1."""
    square = y[0] ** 2 + y[1] ** 2
    rate = mu + 2 * square - square**2
    return [rate * y[0] - y[1], rate * y[1] + y[0]]


def mathieu(t, y, a, q):
    return [y[1], -(a - 2 * q * np.cos(2 * t)) * y[0]]


def duffing(t, y, omega):
    return [y[1], -0.1 * y[1] - y[0] - y[0] ** 3 + 0.3 * math.cos(omega * t)]


def roessler(t, y, c):
    return [-y[1] - y[2], y[0] + 0.2 * y[1], 0.2 + y[2] * (y[0] - c)]


@pytest.mark.parametrize(
    "mu, period", [(1.0, 6.6632868593), (5.0, 11.6122306668), (10.0, 19.0783695664)]
)
def test_the_period_of_van_der_pol(mu, period):
    """Periods of the literature, from a guess and without one."""
    for guess in (period * 1.02, 2 * period, None):
        orbit = periodic_orbit(van_der_pol, [2.0, 0.0], guess, (mu,))
        assert abs(orbit.period - period) < 1e-9 and orbit.stable is True
        assert abs(orbit.multipliers[0] - 1) < 1e-7 and orbit.residual < 1e-9


def test_the_multiplier_of_a_hopf_cycle():
    orbit = periodic_orbit(hopf, [0.5, 0.1], 6.0, (0.09,))
    assert math.isclose(orbit.period, 2 * math.pi, rel_tol=1e-10)
    assert np.allclose(orbit.others(), math.exp(-4 * math.pi * 0.09), rtol=1e-7)
    assert np.allclose(orbit.amplitude, 0.3, rtol=1e-8)
    assert np.allclose(orbit.exponents, [0, -2 * 0.09], atol=1e-8)


def test_the_stability_of_mathieu():
    """Multipliers are 1, or -1, at SciPy's characteristic values; between them on the circle."""
    q = 0.7
    for order, sign, value in ((0, 1, mathieu_a), (1, -1, mathieu_a), (1, -1, mathieu_b)):
        orbit = periodic_orbit(mathieu, [0, 0], math.pi, (float(value(order, q)), q))
        assert np.allclose(orbit.multipliers, sign, atol=1e-5)  # a double one: root of 1e-10
        assert math.isclose(np.prod(orbit.multipliers).real, 1, rel_tol=1e-9)
    inside = periodic_orbit(mathieu, [0, 0], math.pi, (1.0, q))
    assert inside.stable is False and abs(inside.multipliers[0]) > 1.5
    outside = periodic_orbit(mathieu, [0, 0], math.pi, (0.1, 0.1))
    assert outside.stable is None and np.allclose(abs(outside.multipliers), 1, atol=1e-9)


def test_an_orbit_of_a_family():
    """A pendulum has an orbit for each energy; the period belongs to the energy that is found."""
    orbit = periodic_orbit(systems.pendulum(), [1.0, 0.0], 2.1)
    exact = systems.pendulum(theta0=float(np.abs(orbit.y[0]).max()), V0=0.0)
    assert orbit.stable is None and abs(orbit.period - exact.period) < 1e-5


def test_a_forced_orbit_and_its_subharmonic():
    period = 2 * math.pi / 1.2
    orbit = periodic_orbit(duffing, [0.2, 0], period, (1.2,), transient=100)
    assert orbit.forced and orbit.stable is True and orbit.period == period
    product = np.prod(orbit.multipliers).real
    assert math.isclose(product, math.exp(-0.1 * period), rel_tol=1e-8)  # by the divergence
    twice = periodic_orbit(duffing, orbit.y0, 2 * period, (1.2,))
    assert np.allclose(twice.y0, orbit.y0, atol=1e-8)


def test_a_fold_of_cycles():
    """The branch goes around the fold at mu = -1 exactly, and r² = 1 ± sqrt(1 + mu) along it."""
    orbit = periodic_orbit(subcritical, [1.4, 0], 6.3, (0.0,))
    branch = continuation(orbit, "mu", -1.5)
    (fold,) = branch.special
    assert fold.kind == "fold" and abs(fold.value + 1) < 1e-7  # as exact as orbits are
    assert "shrinks to an equilibrium" in branch.message and abs(branch.values[-1]) < 2e-3
    r = branch.amplitudes[0]
    assert np.allclose((r**2 - 1) ** 2, 1 + branch.values, atol=1e-6)
    upper = r > 1.01
    assert branch.stable[upper].all() and not branch.stable[r < 0.99].any()


def test_a_period_doubling():
    """Roessler's cycle doubles its period at c = 2.8324 (a = b = 0.2)."""
    orbit = periodic_orbit(roessler, [2, 2, 0.1], args=(2.4,), transient=300)
    branch = continuation(orbit, "c", 3.0)
    (doubling,) = branch.special
    assert doubling.kind == "period doubling" and abs(doubling.value - 2.83245) < 1e-4
    assert np.abs(doubling.orbit.multipliers + 1).min() < 1e-5
    assert math.isclose(branch.values[-1], 3.0, rel_tol=1e-8) and "reaches 3" in branch.message
    assert branch.stable[0] and not branch.stable[-1]


def test_a_branch_over_the_period_of_the_forcing():
    orbit = periodic_orbit(duffing, [0.2, 0], 2 * math.pi / 1.6, (1.6,), transient=200)
    branch = continuation(orbit, "omega", 1.9, lambda omega: 2 * math.pi / omega)
    assert np.allclose(branch.periods, 2 * math.pi / branch.values)
    with pytest.raises(ValueError, match=r"at omega = 1\.72: give `period` as a function"):
        continuation(orbit, "omega", 1.9)
    with pytest.raises(ValueError, match="`period` gives"):
        continuation(orbit, "omega", 1.9, lambda omega: 1 / omega)


def test_an_end_that_is_not_reached_is_told():
    orbit = periodic_orbit(hopf, [0.5, 0.1], 6.0, (0.25,))
    hopf_point = continuation(orbit, "mu", -1.0)
    assert 0 <= hopf_point.values[-1] < 1e-3 and "shrinks to an equil" in hopf_point.message
    assert "the most" in continuation(orbit, "mu", 9.0, n_orbits=3).message


@pytest.mark.parametrize(
    "arguments, kind, said",
    [
        ((duffing, [0.2, 0], None, (1.2,)), ValueError, "`period` is missing"),
        ((van_der_pol, [0, 0], 6.0, (1.0,)), NotConvergedError, "begins at an equilibrium"),
        ((hopf, [0.01, 0], 6.0, (-0.3,)), NotConvergedError, "orbit"),
        ((lambda t, y: [y[0]], [1.0], 2.0), NotConvergedError, "No periodic orbit was found"),
        ((lambda t, y: [y[0] ** 2], [1.0], 2.0), NotConvergedError, "failed"),
        ((lambda t, y: [y[1], 1.0], [1.0, 0]), NotConvergedError, "does not return"),
        ((lambda t, y: [1.0 + 0 * y[0]], [1.0]), NotConvergedError, "does not return"),
        ((lambda t, y: [-y[1] - np.sign(y[1]), y[0]], [1.0, 0], 6.0), ValueError, "jumps"),
        ((van_der_pol, [2, 0], -1.0, (1.0,)), ValueError, "positive"),
        ((van_der_pol, [2, 0], "6", (1.0,)), TypeError, "must be a number"),
    ],
)
def test_what_is_refused(arguments, kind, said):
    with pytest.raises(kind, match=said):
        periodic_orbit(*arguments)


def test_what_a_branch_refuses():
    orbit = periodic_orbit(hopf, [0.5, 0.1], 6.0, (0.25,))
    for arguments, kind, said in (
        ((None, "mu", 1), TypeError, "PeriodicOrbit"),
        ((orbit, "nu", 1), ValueError, "the parameters are 'mu'"),
        ((orbit, "mu", 0.25), ValueError, "another value"),
        ((orbit, "mu", 1, math.sqrt), ValueError, "depend on the time"),
    ):
        with pytest.raises(kind, match=said):
            continuation(*arguments)
