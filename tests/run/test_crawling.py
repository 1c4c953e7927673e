"""Steps that crawl along a switch are told of, by one mechanism for all solvers."""

import warnings

import numpy as np
import pytest
import scipy.integrate

from fastdyn import Stepper, StiffnessWarning, prepare, solve_dae, solve_ensemble, solve_ivp
from fastdyn.run.functions import crawling
from fastdyn.run.functions.crawling import SAMPLES, Samples, crawl

ENOUGH = crawling.MOST + crawling.MOST // 2
TWISTS = "2 switches of `fun` at once, ever faster"


def twisting(t, y, a):
    return [y[1], -2.0 * np.sign(y[0]) - a * np.sign(y[1])]


@pytest.mark.parametrize("method", ["auto", "Tsit5", "RK45", "DOP853", "LSODA", "Radau", "Rodas5P"])
def test_second_order_sliding_is_told_by_each_method(method):
    with pytest.warns(StiffnessWarning, match=TWISTS) as caught:
        solve_ivp(twisting, (0, 20), [1.0, 0.0], method, args=(1.0,), max_steps=ENOUGH)
    assert len(caught) == 1


def test_a_solution_that_goes_on_is_told_of_and_ends():
    def twists(t, y):
        return [y[1], -2.0 * np.sign(y[0]) - np.sign(y[1])]

    with pytest.warns(StiffnessWarning, match=TWISTS):
        run = solve_ivp(twists, (0, 12), [1.0, 0.0], "Tsit5")
    assert run.status == 0 and np.abs(run.y[:, -1]).max() < 1e-3


def test_prepared_solves_and_ensembles_tell():
    def prepared(t, y, a):
        return [y[1], -3.0 * np.sign(y[0]) - a * np.sign(y[1])]

    solve = prepare(prepared, (0, 20), [1.0, 0.0], args=(1.0,), max_steps=ENOUGH)
    with pytest.warns(StiffnessWarning, match=TWISTS):
        solve()
    starts = np.array([[1.0, 0.0], [0.01, 0.0]])
    with pytest.warns(StiffnessWarning, match=f"Tsit5 took .*{TWISTS}"):
        solve_ensemble(
            prepared, (0, 20), starts, args=(1.0,), method="Tsit5", max_steps=ENOUGH
        )  # fmt: skip


def test_residuals_end_where_they_crawl():
    def residual(t, y, yp):
        return [yp[0] - y[1], yp[1] + 2.0 * np.sign(y[0]) + np.sign(y[1])]

    with pytest.warns(StiffnessWarning, match="changes as at a switch"):
        run = solve_dae(residual, (0, 20), [1.0, 0.0])
    assert run.status == -1 and run.n_accepted < ENOUGH


def test_classes_of_scipy_tell(monkeypatch):
    monkeypatch.setattr(crawling, "MOST", 3000)

    class Other(scipy.integrate.RK45):
        pass

    def asked():
        return solve_ivp(twisting, (0, 4.65), [1.0, 0.0], Other, args=(1.0,))

    with pytest.warns(StiffnessWarning, match="Other took .* changes as at a switch"):
        run = asked()
    plain = scipy.integrate.solve_ivp(twisting, (0, 4.65), [1.0, 0.0], "RK45", args=(1.0,))
    assert run.nfev == plain.nfev and np.array_equal(run.y, plain.y)


@pytest.mark.parametrize("method", ["Taylor", "LSODA"])
def test_a_stepper_that_chatters_ends_with_a_sentence(method):
    stepper = Stepper(twisting, 0.0, [1.0, 0.0], 20.0, method=method, args=(1.0,))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StiffnessWarning)
        for _ in range(ENOUGH):
            message = stepper.step()
            if stepper.status != "running":
                break
    assert stepper.status == "failed" and "no step is short enough" in message


@pytest.mark.parametrize("method", ["Tsit5", "RK45", "DOP853", "Radau"])
@pytest.mark.parametrize("rtol", [1e-3, 1e-8])
def test_what_is_resolved_is_not_told(method, rtol):
    """A relay, a stiff oscillation and one at the limit of stability take as many steps."""

    def relay(t, y):
        return [y[1], -np.sign(y[0] - 20.0)]

    def van_der_pol(t, y):
        return [y[1], 1000.0 * (1.0 - y[0] ** 2) * y[1] - y[0]]

    def oscillates(t, y):
        return [y[1], -y[0]]

    for fun, y0 in ((relay, [20.5, 0.0]), (van_der_pol, [2.0, 0.0]), (oscillates, [1.0, 0.0])):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            solve_ivp(fun, (0, 1e5), y0, method, rtol=rtol, t_eval=[0.0], max_steps=2 * ENOUGH)
        assert not [each for each in caught if "switch" in str(each.message)]


def test_samples_are_steps_in_a_row_and_end_with_a_crawl():
    seen = []
    samples = Samples(lambda times, states: seen.append(times) or len(seen) == 2)
    found = []
    for done in range(1, 2 * crawling.MOST):
        assert samples.left(done) >= 1
        found.append(samples.take(done, float(done), np.zeros(2)))
    assert [len(times) for times in seen] == [SAMPLES, SAMPLES] and seen[0][0] == crawling.MOST
    assert [each for each in found if each is not None] == [1.0]


@pytest.mark.parametrize(
    ("shape", "crawls"),
    [(np.sign, True), (lambda x: np.tanh(30.0 * x), True), (lambda x: x, False),
     (lambda x: np.tanh(0.003 * x), False)],
)  # fmt: skip
def test_a_slope_that_grows_beyond_the_steps_is_none_of_a_switch(shape, crawls):
    """States that zigzag within a tolerance of 1; a stiff slope is proportional to the distance."""
    times = np.arange(SAMPLES) / 10.0
    states = np.where(np.arange(SAMPLES) % 2, 0.5, -0.5)[:, None]
    assert crawl(times, states, np.ones(1), lambda y: -100.0 * shape(y)) is crawls
