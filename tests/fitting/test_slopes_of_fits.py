"""Slopes of residuals: beside exact formulas, complex steps, and the fit's own differences."""

import numpy as np
import pytest

from fastdyn import Free, Record
from fastdyn.fitting.model import model_of
from fastdyn.fitting.motion import Failed, options_of
from fastdyn.fitting.noise import Normal, Poisson
from support.fits import tight

T = np.linspace(0.5, 3.0, 6)
TOLERANCE = 1e-8  # of the solves
GROWTH = 100.0  # of their error along the motion, and by squares and products of what is observed


def decay(t, y, rate, other):
    return [-rate * y[0] + 0 * other[0]]


def seen(t, y, rate, other):
    return [other[0] * y[0] ** 2 + rate, np.where(t > 1.0, np.sin(y[0]) * other[1], y[0])]


def exact(p):
    """What `seen` sees at t, of y = start exp(-rate t), for complex parameters, too."""
    start, rate, factor, other = p
    y = start * np.exp(-rate * T)
    return np.stack([factor * y**2 + rate, np.where(T > 1.0, np.sin(y) * other, y)])


def record(observed=seen):
    start, rate = Free(2.0), Free(0.4)
    args = rate, [Free(1.3), Free(0.8)]
    return Record(T, np.zeros((2, 6)), [start], args, 0.5, observed, t0=0.0)


@pytest.mark.parametrize("traced", [True, False])
def test_what_is_observed_has_exact_slopes(traced):
    def untraceable(t, y, rate, other):
        return seen(float(str(t)), y, rate, other)

    model = model_of(decay, record(seen if traced else untraceable), options_of({}), False)
    x = np.array([2.0, 0.4, 1.3, 0.8])
    found = model.residuals(x)
    steps = x + 1e-30j * np.eye(4)
    slopes = np.array([exact(p).imag.ravel() / 1e-30 for p in steps]).T / 0.5
    own = 0.0 if traced else (2.0**-52) ** (2 / 3)  # of central differences
    bound = GROWTH * (TOLERANCE + own)
    assert np.abs(found.r - exact(x).ravel() / 0.5).max() < bound
    assert np.abs(found.jac - slopes).max() < bound
    assert model.chi2(x) == pytest.approx(found.chi2, rel=bound)


def test_differences_of_solves_have_the_accuracy_they_claim():
    model = model_of(decay, record(), options_of({}), True)
    x = np.array([2.0, 0.4, 1.3, 0.8])
    steps = x + 1e-30j * np.eye(4)
    slopes = np.array([exact(p).imag.ravel() / 1e-30 for p in steps]).T / 0.5
    assert np.abs(model.residuals(x).jac - slopes).max() < GROWTH * model.motions[0].accuracy


@pytest.mark.parametrize("data", [0.0, 1.0, 7.0])
def test_the_slope_of_a_poisson_residual(data):
    """Beside complex steps of the signed root of the deviance, and its limit where both meet."""
    mean = np.array([0.3, 1.0, 7.0, 12.0, 900.0])
    r, slope, information = Poisson().residuals(mean, np.full(5, data))
    z = mean + 1e-30j
    deviance = 2 * (z - data + (data * np.log(data / z) if data else 0.0))
    apart = mean != data
    found = np.sqrt(deviance[apart]).imag / 1e-30 * np.sign(mean[apart] - data)
    assert np.allclose(slope[apart], found, rtol=1e-12)
    assert np.allclose(slope[~apart], 1 / np.sqrt(mean[~apart]))
    assert np.allclose(r**2, deviance.real) and np.array_equal(np.sign(r), np.sign(mean - data))
    assert np.allclose(information, mean**-0.5)


def test_a_mean_of_counts_is_negative_by_the_error_of_a_solve_only():
    r, slope, _ = Poisson().residuals(np.array([-1e-9, 0.0, 3.0]), np.full(3, 3.0))
    assert np.isfinite(r).all() and (r[:2] < -5).all() and (slope > 0).all()
    with pytest.raises(Failed, match="negative, -1,"):
        Poisson().residuals(np.array([-1.0, 3.0]), np.array([3.0, 3.0]))
    r, _, _ = Normal(np.array([0.5])).residuals(np.array([2.0]), np.array([1.0]))
    assert r == [2.0]


def test_one_free_in_two_places_adds_up():
    def turning(t, y, both, c):
        return [both[0] * y[1], -both[1] * y[0] - 0.1 * c * y[1]]

    same = Free(1.5)
    given = Record(T, np.zeros((2, 6)), [1.0, same], ([same, same], same), 1.0, t0=0.0)
    model = model_of(turning, given, options_of({"rtol": 1e-10}), False)
    assert model.parameters.names == ["y0[1]"]

    def states(w):
        return tight(turning, np.r_[0.0, T], [1.0, w], ([w, w], w))[:, 1:]

    h = 1e-4  # error of the fourth-order formula: h^4; of the solves: 1e-11 / h
    found = 8 * (states(1.5 + h) - states(1.5 - h)) - (states(1.5 + 2 * h) - states(1.5 - 2 * h))
    jac = model.residuals(np.array([1.5])).jac
    assert np.abs(jac[:, 0] - (found / (12 * h)).ravel()).max() < 1e-6
