"""Frequency responses beside formulas, and Duffing's two branches beside its folds."""

import math

import numpy as np
import pytest

from fastdyn import systems
from fastdyn.analysis import continuation, frequency_response, periodic_orbit


def oscillator(t, y, omega, zeta):
    return [y[1], -2 * zeta * y[1] - y[0] + 0.3 * math.cos(omega * t)]


def duffing(t, y, omega, cubic):
    return [y[1], -0.1 * y[1] - y[0] - cubic * y[0] ** 3 + 0.3 * math.cos(omega * t)]


def test_a_linear_oscillator():
    w = np.linspace(0.2, 3.0, 15)
    found = frequency_response(oscillator, w, args=(1.0, 0.05), y0=[0, 0])
    exact = 0.3 / (1 - w**2 + 0.1j * w)
    assert found.linear and np.allclose(found.amplitude[0], abs(exact), rtol=1e-7)
    assert np.allclose(found.sweeps["exact"].harmonic[0], exact, rtol=1e-12)
    late = frequency_response(oscillator, w, args=(1.0, 0.05), y0=[0, 0], reference="sin")
    assert np.allclose(late.sweeps["exact"].harmonic[0], 1j * exact, rtol=1e-12)


def test_the_building():
    w = np.array([3.0, 9.0, 14.0, 25.0])
    found = frequency_response(systems.building(), w, reference="sin")
    exact = np.array([systems.building(omega=one).steady_amplitudes for one in w]).T
    assert found.linear and np.allclose(found.amplitude[:2], abs(exact), rtol=1e-7)
    assert np.allclose(found.sweeps["exact"].harmonic[:2], exact, rtol=1e-9)


def test_shooting_and_formula_agree():
    """A cubic term of no weight makes the equations nonlinear, and changes nothing."""
    w = [0.5, 0.9, 1.3]
    found = frequency_response(duffing, w, args=(1.0, 1e-9), y0=[0.1, 0], transient=5)
    exact = 0.3 / (1 - np.square(w) + 0.1j * np.array(w))
    assert not found.linear and found.message == ""
    for sweep in found.sweeps.values():
        assert np.allclose(sweep.harmonic[0], exact, rtol=1e-6)
        assert np.allclose(sweep.amplitude[0], abs(exact), rtol=1e-6)


def test_duffing_jumps_at_its_folds():
    w = np.linspace(1.1, 2.1, 21)
    found = frequency_response(duffing, w, args=(1.0, 1.0), y0=[0, 0], transient=30)
    orbit = periodic_orbit(duffing, [0.2, 0], 2 * math.pi / 1.0, (1.0, 1.0), transient=200)
    branch = continuation(orbit, "omega", 2.1, lambda omega: 2 * math.pi / omega)
    upper, lower = (special.value for special in branch.special)
    jumps = found.jumps()
    assert len(jumps["up"]) == 1 and 0 <= jumps["up"][0] - upper < 0.05
    assert len(jumps["down"]) == 1 and 0 <= lower - jumps["down"][0] < 0.05
    up, down = found.sweeps["up"], found.sweeps["down"]
    both = (w > lower + 0.05) & (w < upper - 0.05)
    assert (up.amplitude[0] > 1.5 * down.amplitude[0])[both].all()
    assert np.allclose(up.amplitude[:, ~both][:, 0], down.amplitude[:, 0], rtol=1e-6)


def test_a_response_that_has_not_the_period_is_no_number():
    """A chaotic Duffing oscillator has no stable orbit of the period."""

    def chaotic(t, y, omega):
        return [y[1], -0.3 * y[1] + y[0] - y[0] ** 3 + 0.5 * math.cos(omega * t)]

    found = frequency_response(chaotic, [1.2], args=(1.0,), y0=[0.1, 0], sweep="up", transient=20)
    assert np.isnan(found.amplitude).all() and "1 steady states were not found" in found.message


def test_forcing_that_jumps():
    """A square wave has a time, though no derivative; its harmonics do not fade."""

    def square(t, y, omega, soft):
        wave = math.sin(omega * t)
        return [y[1], -y[0] - 0.3 * y[1] + (wave * abs(wave) if soft else 1 if wave > 0 else -1)]

    w = np.array([0.5, 1.0, 1.5])
    for soft, first in ((0, 4 / math.pi), (1, 8 / (3 * math.pi))):
        found = frequency_response(square, w, args=(1.0, soft), y0=[0, 0], reference="sin")
        exact = first / (1 - w**2 + 0.3j * w)
        assert np.allclose(found.sweeps["exact"].harmonic[0], exact, rtol=1e-3 * (1 - soft) + 1e-7)
        assert ("jumps or kinks" in found.message) is not bool(soft)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("damping, known, said", [
    (0.1, [1, 1, 1], ""),
    (0.0, [1, 0, 1], "1 steady states were not found (1: resonance without damping)"),
    (-0.1, [0, 0, 0], "3 steady states were not found (3: the equations have motions that grow)"),
])  # fmt: skip
def test_linear_equations_without_a_steady_state(damping, known, said):
    def linear(t, y, omega, damping):
        return [y[1], -y[0] - damping * y[1] + 0.3 * math.cos(omega * t), -y[2]]

    found = frequency_response(linear, [0.5, 1.0, 1.5], args=(1.0, damping), y0=[0, 0, 0])
    assert found.amplitude.shape == (3, 3) and found.linear
    assert np.isfinite(found.amplitude).all(axis=0).tolist() == [bool(one) for one in known]
    assert found.message.startswith(said) and bool(found.message) == bool(said)
    assert found.plot()


@pytest.mark.parametrize(
    "given, kind, said",
    [
        ({"frequencies": [1.0, 0.5]}, ValueError, "increasing"),
        ({"frequencies": [0.0, 0.5]}, ValueError, "positive"),
        ({"frequencies": [math.nan]}, ValueError, "finite"),
        ({"parameter": "nu"}, ValueError, "the parameters are 'omega', 'zeta'"),
        ({"parameter": "zeta"}, ValueError, "does not have the period"),
        ({"args": ()}, ValueError, "has 'omega', 'zeta' after t and y, but `args` is empty"),
        (
            {"fun": lambda t, y, w: [y[1], -y[0] + math.cos(w * t)], "args": ()},
            ValueError,
            "has 'w' after t and y, but `args` is empty",
        ),
        ({"sweep": "left"}, ValueError, "`sweep`"),
        ({"reference": "tan"}, ValueError, "`reference`"),
        ({"fun": lambda t, y, omega, zeta: [y[1], -y[0]]}, ValueError, "nothing forces it"),
    ],
)
def test_what_is_refused(given, kind, said):
    given = {"fun": oscillator, "frequencies": [0.5, 1.0], "args": (0.7, 0.1), "y0": [0, 0]} | given
    with pytest.raises(kind, match=said):
        frequency_response(**given)
