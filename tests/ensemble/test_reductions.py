"""Events and reductions of an ensemble against formulas."""

import numpy as np
import pytest

from fastdyn import solve_ensemble
from support.many import crossing, oscillator


def falling(t, w, k):
    return w[0] + 0.5


falling.direction, falling.terminal = -1, True


@pytest.mark.parametrize("method", ["RK45", "Taylor", "LSODA", "ode45", "Radau"])
def test_what_follows_the_state_takes_no_part_in_the_steps(method):
    """By methods whose norm is a mean, and by those whose norm is the largest error."""
    given = {"method": method, "rtol": 1e-6, "atol": 1e-9}
    plain = solve_ensemble(oscillator, (0, 10), [1.0, 0.3], ([1.0, 2.0],), **given)
    means = solve_ensemble(oscillator, (0, 10), [1.0, 0.3], ([1.0, 2.0],), reduce="rms", **given)
    assert np.array_equal(plain.n_accepted, means.n_accepted)


@pytest.mark.parametrize("simd", [True, False])
def test_events_and_reductions_against_formulas(simd):
    k = np.linspace(1, 4, 13)
    names = ("max", "max_time", "min", "mean", "rms")
    tolerance = {"rtol": 1e-9, "atol": 1e-11}
    result = solve_ensemble(
        oscillator, (0, 10), [1.0, 0.3], (k,), events=crossing, reduce=names, simd=simd,
        **tolerance,
    )  # fmt: skip
    w = np.sqrt(k)
    a, phase = np.sqrt(1 + 0.09 / k), np.arctan2(0.3 / w, 1.0)
    found = result.reduced
    close = {"rtol": 0, "atol": 1e-7}
    np.testing.assert_allclose(found["max"], np.c_[a, a * w], **close)
    np.testing.assert_allclose(found["min"], -np.c_[a, a * w], **close)
    np.testing.assert_allclose(np.cos(w * found["max_time"][:, 0] - phase), 1.0, **close)
    mean = a * (np.sin(10 * w - phase) + np.sin(phase)) / (10 * w)
    np.testing.assert_allclose(found["mean"][:, 0], mean, **close)
    square = 0.5 + (np.sin(2 * (10 * w - phase)) + np.sin(2 * phase)) / (40 * w)
    np.testing.assert_allclose(found["rms"][:, 0], a * np.sqrt(square), **close)
    first = (np.pi / 2 + phase) / w
    np.testing.assert_allclose([t[0] for t in result.t_events[0]], first, **close)
    plain = solve_ensemble(oscillator, (0, 10), [1.0, 0.3], (k,), simd=simd, **tolerance)
    assert np.array_equal(plain.n_accepted, result.n_accepted)  # means take no part in the steps
    assert result.y_end.shape == (13, 2)
    stopped = solve_ensemble(
        oscillator, (0, 10), [1.0, 0.3], (k,), events=falling, reduce=["first_event", "min"],
        simd=simd, **tolerance,
    )  # fmt: skip
    assert (stopped.status == 1).all()
    np.testing.assert_allclose(stopped.reduced["first_event"][:, 0], stopped.t_end, rtol=1e-14)
    np.testing.assert_allclose(stopped.y_end[:, 0], -0.5, **close)
    np.testing.assert_allclose(stopped.reduced["min"][:, 0], -0.5, **close)


def test_extrema_at_constant_steps():
    k = np.linspace(1, 4, 9)
    result = solve_ensemble(
        oscillator, (0, 9.97), [1.0, 0.3], (k,), "BlanesMoan6", reduce="max", step=0.02
    )
    amplitude = np.sqrt(1 + 0.09 / k)
    # the cubic of a step: h^4/384 of the fourth derivative
    assert abs(result.reduced["max"][:, 0] - amplitude).max() < 0.02**4 / 384 * 16 * 1.1
