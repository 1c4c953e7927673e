"""fit of delay equations: delays, rates and constant histories from measured values."""

import numpy as np
import pytest

from fastdyn import Free, Record, fit
from fastdyn.delays import solve_dde


def regulated(t, y, past, rate, tau):
    """Hutchinson's logistic growth with a delay."""
    return [rate * y[0] * (1.0 - past(t - tau)[0])]


TRUE = (1.3, 0.9, 0.4)  # rate, delay, history
TIMES = np.linspace(0.5, 12, 40)


def measured(noise, seed=5):
    exact = solve_dde(
        regulated, (0, 12), [TRUE[2]], t_eval=TIMES, args=TRUE[:2], rtol=1e-11, atol=1e-12
    )  # fmt: skip
    return exact.y[0] + noise * np.random.default_rng(seed).normal(size=len(TIMES))


def record(noise, values):
    args = Free(1.0, low=0.1), Free(0.7, low=0.1, high=2.0)
    return Record(TIMES, values, [Free(0.5, low=0.01)], args, noise=noise, t0=0.0)


def test_exact_values_give_the_parameters_back():
    found = fit(regulated, record(1e-3, measured(0.0)), history="constant")
    assert found.success
    np.testing.assert_allclose(
        [found.values["rate"], found.values["tau"], found.values["y0[0]"]], TRUE, rtol=1e-6
    )


def test_errors_are_those_of_the_noise():
    """The deviations of four fits, in their standard errors: chi-square of 12 numbers."""
    total = 0.0
    for seed in range(4):
        found = fit(regulated, record(0.01, measured(0.01, seed)), history="constant")
        values = np.array([found.values[name] for name in ("rate", "tau", "y0[0]")])
        d = values - TRUE
        at = [[*found.values].index(name) for name in ("rate", "tau", "y0[0]")]
        total += d @ np.linalg.solve(found.covariance[np.ix_(at, at)], d)
    assert 1.1 < total < 40.0  # beyond these, one of 10^4 draws


def test_derivatives_are_those_of_differences():
    """The values agree to a share of their errors, which the search leaves."""
    given = record(0.01, measured(0.01))
    exact = fit(regulated, given, history="constant")
    other = fit(regulated, given, history="constant", differences=True)
    errors = np.sqrt(np.diag(exact.covariance))
    moved = np.array([exact.values[n] - other.values[n] for n in exact.values])
    assert (np.abs(moved) < 1e-3 * errors).all()
    np.testing.assert_allclose(np.sqrt(np.diag(other.covariance)), errors, rtol=1e-3)


def test_what_is_refused():
    values = measured(0.01)
    with pytest.raises(ValueError, match='must be "constant"'):
        fit(regulated, record(0.01, values), history=lambda t: [1.0])
    free = Record(TIMES, values, [0.4], (1.3, Free(0.7)), noise=0.01, t0=Free(0.0, high=0.4))
    with pytest.raises(ValueError, match="no Free in `t0`"):
        fit(regulated, free, history="constant")
