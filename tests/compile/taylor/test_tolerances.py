"""What rtol means: the error at the end is about the tolerance."""

import numpy as np
import pytest

from fastdyn import solve_ensemble, solve_ivp
from tests.support import detest

EXPONENTS = np.arange(3.0, 11.5, 0.5)


def end_of(fun, span, y0):
    return solve_ivp(fun, span, y0, "Vern9", rtol=1e-13, atol=1e-14, t_eval=[span[1]]).y[:, -1]


@pytest.fixture(scope="module")
def errors():
    """By problem, the errors over the tolerance."""
    found = {}
    for name, fun, span, y0 in detest.problems(end_of):
        exact = end_of(fun, span, y0)
        size, found[name] = max(1.0, np.abs(exact).max()), []
        for tol in 10.0**-EXPONENTS:
            run = solve_ivp(fun, span, y0, "Taylor", rtol=tol, atol=tol, t_eval=[span[1]])
            assert run.status == 0
            found[name].append(np.abs(run.y[:, -1] - exact).max() / size / tol)
    return found


@pytest.mark.few(1)
@pytest.mark.parametrize("tols", [slice(0, 3), slice(3, 11), slice(11, None)])  # one of each order
def test_errors_are_below_the_tolerance(errors, tols):
    found = np.array([each[tols] for each in errors.values()])
    assert np.median(found) < 1.0 and np.quantile(found, 0.9) < 10.0
    assert np.quantile(found, 0.9) > 0.1  # and the steps not needlessly short


def test_errors_are_proportional_to_the_tolerance(errors):
    slopes = []
    for each in errors.values():
        found = np.array(each) * 10.0**-EXPONENTS
        clear = found > 1e-12  # above the error of the reference
        if clear.sum() > 8:
            slopes.append(np.polyfit(-EXPONENTS[clear], np.log10(found[clear]), 1)[0])
    assert 0.9 < np.median(slopes) < 1.1 and np.mean(np.abs(np.array(slopes) - 1) < 0.15) > 0.8


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["A5", "B1", "D2", "E1"])
def test_ensembles_too(name):
    fun, y0 = detest.SYSTEMS[name]
    exact = end_of(fun, (0.0, 20.0), y0)
    for tol in (1e-4, 1e-7, 1e-10):
        many = solve_ensemble(fun, (0.0, 20.0), [y0] * 9, method="Taylor", rtol=tol, atol=tol)
        assert np.abs(many.y_end - exact).max() < 10.0 * tol * max(1.0, np.abs(exact).max())
