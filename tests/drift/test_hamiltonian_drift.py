"""Energy over long runs of systems that are not separable, and of chaotic ones."""

import math

import numpy as np
import pytest

import fastdyn


def double_pendulum(t, w):
    """Two equal pendulums on one another, in angles and their momenta: not separable."""
    a, b, p, q = w
    s, c = math.sin(a - b), math.cos(a - b)
    d = 1.0 + s * s
    h = p * q * s / d - (p * p + 2.0 * q * q - 2.0 * p * q * c) * s * c / (d * d)
    return [(p - q * c) / d, (2.0 * q - p * c) / d, -2.0 * math.sin(a) - h, h - math.sin(b)]


def its_energy(t, w):
    a, b, p, q = w
    kinetic = (p * p + 2.0 * q * q - 2.0 * p * q * np.cos(a - b)) / (
        2.0 * (1.0 + np.sin(a - b) ** 2)
    )
    return kinetic - 2.0 * np.cos(a) - np.cos(b)


def henon_heiles(t, w):
    x, y, vx, vy = w
    return [vx, vy, -x - 2.0 * x * y, -y - x * x + y * y]


def energy_of_henon_heiles(t, w):
    x, y, vx, vy = w
    return 0.5 * (vx * vx + vy * vy + x * x + y * y) + x * x * y - y**3 / 3.0


@pytest.mark.parametrize("method", ["Gauss4", "Gauss8", "Gauss16", "EnergyConserving4"])
def test_a_system_that_is_not_separable_keeps_its_energy(method):
    step = {"Gauss4": 0.01, "Gauss8": 0.05}.get(method, 0.1)
    study = fastdyn.energy_drift(
        double_pendulum, method, step=step, t_end=2000.0, y0=[1.0, 0.5, 0.3, -0.2],
        invariants={"energy": its_energy},
    )  # fmt: skip
    energy = study.drifts["energy"]
    bound = {"Gauss4": 1e-7, "Gauss8": 1e-8}.get(method, 2e-13)
    assert energy.largest < bound and energy.growth.verdict != "quadratic or worse"


@pytest.mark.parametrize("method", ["BlanesMoan6", "SofroniouSpaletta10", "Gauss16"])
def test_henon_heiles_keeps_its_energy(method):
    study = fastdyn.energy_drift(
        henon_heiles, method, step=0.15, t_end=5000.0, y0=[0.1, 0.2, 0.3, 0.0],
        invariants={"energy": energy_of_henon_heiles},
    )  # fmt: skip
    assert study.drifts["energy"].largest < {"BlanesMoan6": 1e-9}.get(method, 1e-13)


def test_an_explicit_splitting_refuses_what_it_is_not_made_for():
    for name in ("BlanesMoan6", "KahanLi8"):
        with pytest.raises(ValueError, match=f"{name} takes y = .q, v. with q' = v"):
            fastdyn.solve_ivp(double_pendulum, (0, 1), [1.0, 0.5, 0.3, -0.2], name, step=0.1)
        with pytest.raises(ValueError, match="depends on the velocity; take Gauss16"):
            fastdyn.solve_ivp(
                lambda t, w: [w[1], -w[0] - 0.1 * w[1]], (0, 1), [1.0, 0.0], name, step=0.1
            )
        with pytest.raises(ValueError, match="the first half"):
            fastdyn.energy_drift(
                double_pendulum, name, step=0.1, t_end=1.0, y0=[1.0, 0.5, 0.3, -0.2],
                invariants={"energy": its_energy},
            )  # fmt: skip
