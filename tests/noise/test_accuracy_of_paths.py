"""Exact solutions on paths, moments of one step, orders of the methods."""

import math

import numpy as np
import pytest

from fastdyn import solve_langevin, solve_sde
from fastdyn.noise.methods import METHODS

A, B = 0.3, 0.4
# (drift, diffusion, start, solution(t, w)): residuals of Ito's formula are zero.
EXACT = {
    "linear": (
        lambda t, y: A * y, lambda t, y: B * y, 1.0,
        lambda t, w: np.exp((A - B * B / 2) * t + B * w),
    ),
    "cubic": (
        lambda t, y: -y * (1 - y * y) / 4, lambda t, y: (1 - y * y) / 2, 0.2,
        lambda t, w: (1.2 * np.exp(w) + 0.2 - 1) / (1.2 * np.exp(w) + 1 - 0.2),
    ),
    "wave": (
        lambda t, y: -np.sin(y) * np.cos(y) ** 3 / 100, lambda t, y: np.cos(y) ** 2 / 10, 0.5,
        lambda t, w: np.arctan(w / 10 + math.tan(0.5)),
    ),
    "additive": (
        lambda t, y: [B / np.sqrt(1 + t) - y[0] / (2 * (1 + t))],
        lambda t, y: [A * B / np.sqrt(1 + t)], 1.0,
        lambda t, w: 1 / np.sqrt(1 + t) + B * (t + A * w) / np.sqrt(1 + t),
    ),
}  # fmt: skip
SHARE = 0.2  # largest error of a measured order: of a slope over four halvings


def slope(errors):
    """The order: the slope of the logarithm of errors of steps that are halved."""
    return -np.polyfit(np.arange(len(errors)), np.log2(errors), 1)[0]


EACH_RUN = {("linear", m) for m in ("EulerMaruyama", "Milstein", "Platen")}
EACH_RUN |= {("cubic", "Milstein"), ("additive", "SRA1")}


@pytest.mark.parametrize(
    ("name", "method"),
    [
        pytest.param(name, method, marks=[] if (name, method) in EACH_RUN else pytest.mark.hunt)
        for name in EXACT
        for method in ("EulerMaruyama", "Milstein", "Platen", "SRA1")
        if METHODS[method].noise != "additive" or name == "additive"
    ],
)
def test_paths_converge_with_the_order_of_the_method(name, method):
    drift, diffusion, start, solution = EXACT[name]
    errors = []
    for refine in range(1, 6):
        found = solve_sde(
            drift, diffusion, (0, 1), [start], step=0.25, refine=refine, paths=4096, rng=1,
            method=method,
        )  # fmt: skip
        w = found.brownian()[:, 0, -1]
        errors.append(np.sqrt(np.mean((found.y_end[:, 0] - solution(1.0, w)) ** 2)))
    assert slope(errors) > METHODS[method].strong - SHARE
    if name == "linear":
        assert slope(errors) < METHODS[method].strong + SHARE


@pytest.mark.parametrize("method", ["EulerHeun", "Milstein"])
def test_stratonovich_follows_the_chain_rule(method):
    errors = []
    for refine in range(5):
        found = solve_sde(
            lambda t, y: A * y, lambda t, y: B * y, (0, 1), [1.0], step=1 / 8, refine=refine,
            paths=2048, rng=2, method=method, calculus="stratonovich",
        )  # fmt: skip
        w = found.brownian()[:, 0, -1]
        errors.append(np.sqrt(np.mean((found.y_end[:, 0] - np.exp(A + B * w)) ** 2)))
    assert 0.8 < slope(errors) < 1.2  # one source commutes: order 1, for Heun's method, too


def mixed(t, y):
    return np.array([[0.3 * y[0], 0.1 * y[1]], [0.0, 0.2 * y[1]]])


def test_a_matrix_of_noise_keeps_the_moments():
    """dy = 0 dt + G(y) dW: the mean stays, and E[y y'] solves linear equations."""
    n = 200_000
    found = solve_sde(lambda t, y: 0.0 * y, mixed, (0, 1), [1.0, 2.0], step=1 / 64, paths=n, rng=3)
    assert (found.method, found.noise) == ("EulerMaruyama", "general")
    y = found.y_end
    assert (np.abs(y.mean(axis=0) - [1.0, 2.0]) < 5 * y.std(axis=0) / np.sqrt(n)).all()
    # P = E[y y']: P_11' = 0.09 P_11 + 0.01 P_22, P_22' = 0.04 P_22, P_12' = 0.1 0.2 P_22
    h, p11, p12, p22 = 1 / 64, 1.0, 2.0, 4.0
    for _ in range(64):  # the recurrence of the moments by the method itself is exact
        p11 += h * (0.09 * p11 + 0.01 * p22)
        p12 += h * 0.02 * p22
        p22 *= 1 + 0.04 * h
    for product, expected in ((y[:, 0] ** 2, p11), (y[:, 0] * y[:, 1], p12), (y[:, 1] ** 2, p22)):
        assert abs(product.mean() - expected) < 5 * product.std() / np.sqrt(n)


@pytest.mark.parametrize("calculus", ["ito", "stratonovich"])
def test_one_source_turns_both_components(calculus):
    """dy = 0.2 J y dW by one source: |y| stays, or |y|^2 grows by e^(0.04) in Ito's calculus."""

    def turned(t, y):
        return [-0.2 * y[1], 0.2 * y[0]]

    found = solve_sde(
        lambda t, y: 0.0 * y, turned, (0, 1), [1.0, 0.0], step=1 / 512, paths=512, rng=4,
        noise="scalar", calculus=calculus,
    )  # fmt: skip
    assert found.method == "Milstein"
    size = (found.y_end**2).sum(axis=1)
    growth = 0.04 if calculus == "ito" else 0.0
    assert np.abs(size - np.exp(growth)).max() < 0.04 * 5 * np.sqrt(2 / 512)


def test_one_step_of_platen_has_two_orders_of_the_moments():
    n, h = 1_000_000, 0.5
    for method, mean in (("Platen", 1 + A * h + (A * h) ** 2 / 2), ("EulerMaruyama", 1 + A * h)):
        found = solve_sde(
            lambda t, y: A * y, lambda t, y: B * y, (0, h), [1.0], step=h, paths=n, rng=5,
            method=method,
        )  # fmt: skip
        y = found.y_end[:, 0]
        assert abs(y.mean() - mean) < 5 * y.std() / np.sqrt(n)
        third_order = (2 * A + B * B) ** 3 * h**3 / 6
        error = abs((y**2).mean() - np.exp((2 * A + B * B) * h))
        noise = 5 * (y**2).std() / np.sqrt(n)
        assert (error < third_order + noise) == (method == "Platen")


@pytest.mark.parametrize("method", ["SRA1", "EulerMaruyama"])
def test_an_ornstein_uhlenbeck_process_has_its_variance(method):
    n, h = 100_000, 1 / 16
    found = solve_sde(
        lambda t, y: -y, 0.5, (0, 8), [0.0], step=h, paths=n, rng=6, method=method,
        reduce=["mean", "variance"],
    )  # fmt: skip
    z = -h
    if method == "SRA1":  # R = 1 + z + z^2 / 2; the noise of a step: g (W + z (W / 2 + H) h / h)
        factor, added = 1 + z + z * z / 2, 0.25 * h * (1 + z + z * z / 3)
    else:
        factor, added = 1 + z, 0.25 * h
    variance = added / (1 - factor**2) * (1 - factor ** (2 * 128))
    found_variance = found.reduced["variance"][0, 0]
    assert abs(found_variance / variance - 1) < 5 * np.sqrt(2 / n)
    if method == "SRA1":
        assert abs(variance / (0.125 * (1 - np.exp(-16))) - 1) < h**2
    assert abs(found.reduced["mean"][0, 0]) < 5 * np.sqrt(variance / n)


@pytest.mark.parametrize("step", [0.25, 1.0])
def test_baoab_has_the_exact_variance_of_a_harmonic_well(step):
    n = 200_000
    found = solve_langevin(
        lambda t, q: -q, (0, 48), [0.0], [0.0], friction=1.0, sigma=math.sqrt(2.0), step=step,
        paths=n, rng=7, reduce="variance",
    )  # fmt: skip
    assert abs(found.reduced["variance"][0, 0] - 1.0) < 5 * np.sqrt(2 / n)


def test_obabo_has_the_variance_of_its_shadow():
    """Positions of OBABO in a well of unit stiffness have variance 1 / (1 - h^2 / 4)."""
    n, h = 200_000, 0.5
    found = solve_langevin(
        lambda t, q: -q, (0, 48), [0.0], [0.0], friction=1.0, sigma=math.sqrt(2.0), step=h,
        paths=n, rng=8, reduce="variance", method="OBABO",
    )  # fmt: skip
    position, velocity = found.reduced["variance"][:, 0]
    assert abs(position * (1 - h * h / 4) - 1.0) < 5 * np.sqrt(2 / n)
    assert abs(velocity - 1.0) < 5 * np.sqrt(2 / n)


def test_without_friction_and_noise_a_splitting_is_velocity_verlet():
    from fastdyn.solve import solve_second_order

    options = {"step": 0.1, "t_eval": np.arange(21) / 10}
    for method in ("BAOAB", "OBABO"):
        found = solve_langevin(
            lambda t, q: [-math.sin(q[0])], (0, 2), [1.0], [0.0], friction=0.0, sigma=0.0,
            method=method, **options,
        )  # fmt: skip
        other = solve_second_order(lambda t, q: [-math.sin(q[0])], (0, 2), [1.0], [0.0], **options)
        np.testing.assert_allclose(found.y, other.y, rtol=0, atol=1e-13)
