"""Stiff delay equations by Rodas5P and Radau: examples of RADAR5, beside precise references.

N. Guglielmi and E. Hairer, "Implementing Radau IIA methods for stiff delay differential equations",
Computing 67 (2001), and the examples that come with their code.
"""

import functools

import numpy as np
import pytest

from fastdyn import solve_ivp
from fastdyn.delays import solve_dde
from fastdyn.delays.equation import STIFF

TENFOLD = 10.0


def enzyme(t, y, past):
    """Hairer, Norsett and Wanner, "Solving ODEs I", section II.17, after Okamoto and Hayashi."""
    z = 1.0 / (1.0 + 0.0005 * past(t - 4.0)[3] ** 3)
    return [10.5 - z * y[0], z * y[0] - y[1], y[1] - y[2], y[2] - 0.5 * y[3]]


def robertson(t, y, past, tau):
    late = past(t - tau)[1]
    return [
        -0.04 * y[0] + 1e4 * late * y[2],
        0.04 * y[0] - 1e4 * late * y[2] - 3e7 * y[1] ** 2,
        3e7 * y[1] ** 2,
    ]


def oregonator(t, y, past):
    """Epstein and Luo (1991): rates of 1e9 beside 1e-1."""
    k1, k2, k3, k4, a, b = 1.34, 1.6e9, 8000.0, 4e7, 0.06, 0.06
    late = past(t - 0.15)[1]
    common = -k1 * a * y[1] - k2 * y[0] * late + k3 * b * y[0]
    return [common - 2.0 * k4 * y[0] ** 2, common]


@functools.cache
def reference(name):
    """The end by an explicit method, 1000 times as precise as the tests."""
    fun, t_end, start, args = {
        "enzyme": (enzyme, 160, (60.0, 10.0, 10.0, 20.0), ()),
        "robertson": (robertson, 1.0, (1.0, 0.0, 0.0), (0.01,)),
        "oregonator": (oregonator, 0.5, (1e-10, 1e-5), ()),
    }[name]
    found = solve_dde(fun, (0, t_end), start, "Vern9", args=args, rtol=1e-11, atol=1e-22)
    return fun, t_end, start, args, found.y[:, -1]


@pytest.mark.parametrize("method", STIFF)
@pytest.mark.parametrize("name", ["enzyme", "robertson", "oregonator"])
def test_beside_an_explicit_method(method, name):
    fun, t_end, start, args, exact = reference(name)
    for rtol in (1e-4, 1e-6, 1e-8):
        found = solve_dde(fun, (0, t_end), start, method, args=args, rtol=rtol, atol=1e-9 * rtol)
        assert found.success
        assert np.abs(found.y[:, -1] / exact - 1).max() < TENFOLD * rtol


@pytest.mark.parametrize("method", STIFF)
def test_the_fast_mode_is_no_bound_of_the_steps(method):
    """y = cos t for all rates; an explicit method takes steps of 3 / 1e6."""

    def fun(t, y, past):
        apart = past(t - 1.0)[0] - np.cos(t - 1.0)
        return [-1e6 * (y[0] - np.cos(t)) + 5e5 * apart - np.sin(t)]

    found = solve_dde(fun, (0, 10), lambda t: [np.cos(t)], method, rtol=1e-6, atol=1e-6)
    assert abs(found.y[0, -1] - np.cos(10)) < TENFOLD * 1e-6
    assert len(found.t) < 500


def test_steps_far_longer_than_the_delay_take_its_slope():
    """RADAR5's Robertson to 1e10: steps of 1e9 with a delay of 0.01.

    The past within the step moves with the stages, and so is part of the Jacobian.  At the end, the
    solution is that without a delay.
    """
    without = solve_ivp(
        lambda t, y: robertson(t, y, lambda s: y, 0.0), (0, 1e10), [1.0, 0, 0], "Radau",
        rtol=1e-9, atol=1e-20,
    ).y[:, -1]  # fmt: skip
    for rtol in (1e-3, 1e-5):
        found = solve_dde(
            robertson, (0, 1e10), [1.0, 0, 0], "Radau", args=(0.01,), rtol=rtol, atol=1e-9 * rtol
        )
        assert found.success and len(found.t) < 2000
        assert np.abs(found.y[:, -1] / without - 1).max() < TENFOLD * rtol


@pytest.mark.parametrize("method", STIFF)
def test_delays_of_the_state_and_vanishing_ones(method):
    def fun(t, y, past):
        early = t - 0.4 * y[0] ** 2  # vanishes where sin t = 0
        return [-50.0 * (y[0] - np.sin(t)) + 10.0 * (past(early)[0] - np.sin(early)) + np.cos(t)]

    for rtol in (1e-4, 1e-7):
        found = solve_dde(fun, (0, 10), lambda t: [np.sin(t)], method, rtol=rtol, atol=rtol)
        assert found.success
        assert abs(found.y[0, -1] - np.sin(10)) < TENFOLD * rtol
