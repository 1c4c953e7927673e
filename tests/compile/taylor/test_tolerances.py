"""What rtol means: the error at the end is about the tolerance."""

import functools

import numpy as np
import pytest

from bench.groups.tolerance import exact, off, solved, times_of
from bench.problems.unlike import UNLIKE
from fastdyn import Stepper, solve_ensemble, solve_ivp
from support.steppers import ended
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


FEW = 3.0  # tolerances
EPIDEMIC = UNLIKE[0]


@pytest.fixture(scope="module")
def true_states():
    """The exact states of a problem with components of unlike size."""
    return functools.cache(exact)


@pytest.mark.few(4)
@pytest.mark.parametrize("tol", [1e-4, 1e-6, 1e-10])
@pytest.mark.parametrize("problem", UNLIKE[:-1], ids=lambda problem: problem.name)
def test_each_component_has_its_own_tolerance(problem, tol, true_states):
    """At all times; the first step, whose length nothing has tried, is the one that went wrong."""
    run = solved(problem, "Taylor", tol)
    assert off(problem, run.y, true_states(problem), tol).max() < FEW


@pytest.mark.few(2)
@pytest.mark.parametrize("problem", UNLIKE[:8], ids=lambda problem: problem.name)
def test_in_lanes_and_long_states_too(problem, true_states):
    p, tol, true, copies = problem, 1e-6, true_states(problem), 70
    options = {"t_eval": times_of(p), "rtol": tol}
    atol = tol * np.array(p.floors)
    many = solve_ensemble(p.fun, (0, p.end), [p.y0] * 9, method="Taylor", atol=atol, **options)
    assert off(p, many.y[0], true, tol).max() < FEW

    def regions(t, y):
        return np.concatenate(p.fun(t, y.reshape(-1, copies)))

    y0, atol = np.repeat(p.y0, copies), np.repeat(atol, copies)
    run = solve_ivp(regions, (0, p.end), y0, "Taylor", atol=atol, **options)
    assert off(p, run.y[::copies], true, tol).max() < FEW


def test_sensitivities_and_continued_runs_too(true_states):
    p, tol, true = EPIDEMIC, 1e-6, true_states(EPIDEMIC)
    options = {"rtol": tol, "atol": tol}
    run = solve_ivp(
        p.fun, (0, p.end), p.y0, "Taylor", sensitivity="y0", t_eval=times_of(p), **options
    )
    assert off(p, run.y, true, tol).max() < FEW
    stepper = ended(Stepper(p.fun, 0.0, p.y0, p.end, method="Taylor", **options))
    assert off(p, stepper.y[:, None], true[:, -1:], tol).max() < FEW


def test_a_state_that_an_event_makes_small(true_states):
    """Beyond the event the epidemic begins anew, with the length of step of its end."""
    p, tol = EPIDEMIC, 1e-6
    times = np.linspace(p.end, 2.0 * p.end, 201)

    def anew(t, y):
        return t - p.end

    anew.terminal = 2

    def again(t, y):
        return p.y0

    run = solve_ivp(
        p.fun, (0, 2.0 * p.end), p.y0, "Taylor", rtol=tol, atol=tol, t_eval=times[1:],
        events=anew, on_event=again,
    )  # fmt: skip
    assert off(p, run.y, true_states(p)[:, 1:], tol).max() < FEW
