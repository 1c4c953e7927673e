"""Truth values that depend on the state: as keys, beside `is True`, in sums."""

import warnings

import numpy as np
import pytest
from scipy.integrate import solve_ivp as reference

import fastdyn

pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture(autouse=True)
def _without_comparisons(monkeypatch):
    """Code is used as it is: a comparison would leave a function to Python that it gets wrong."""
    monkeypatch.setattr("fastdyn.compile.traced.make.compare_around", lambda *_: None)
    monkeypatch.setattr("fastdyn.compile.bind.compare_around", lambda *_: None)
    monkeypatch.setattr("fastdyn.run.functions.compared.WHEN", "never")


def as_in_scipy(rate, start=(1.0, 0.5)):
    def fun(t, y):
        return [rate(y), -y[1]]

    span = 0.0, 0.09  # y[0] stays above the numbers with which it is compared
    mine = fastdyn.solve_ivp(fun, span, start)
    theirs = reference(fun, span, start)
    assert np.allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-9, atol=0)


def by_match(y):
    match float(y[0]) > 0.1:
        case True:
            return -9.0
    return -5.0


def by_tolerance(y):  # a loop that tracing refuses and Numba compiles
    x = 1.0
    while abs(x * x - 2.0 - y[0]) > 1e-9:
        x = 0.5 * (x + (2.0 + y[0]) / x)
    return -x if (y[0] > 0.1) is True else -9.0


@pytest.mark.parametrize(
    "rate",
    [
        lambda y: {True: -9.0, False: -5.0}.get(y[0] > 0.1, 3.0),
        lambda y: -9.0 if (y[0] > 0.1) in {True} else -5.0,
        lambda y: -3.0 * len({y[0] > 0.1, y[0] > 0.2, y[0] > 7.0}),
        lambda y: -9.0 if (float(y[0]) > 0.1) is True else -5.0,
        lambda y: -9.0 if (y[0] > 0.1) is True else -5.0,
        lambda y: -9.0 if (float(y[0]) > 9.0) is not False else -5.0,
        lambda y: -9.0 if True is (float(y[0]) > 0.1) else -5.0,
        by_match,
        by_tolerance,
    ],
)
def test_a_truth_value_is_itself(rate):
    as_in_scipy(rate)


def test_numpys_truth_values_that_no_state_decides():
    limits = np.array([2.0, 3.0])
    as_in_scipy(lambda y: -9.0 * ((limits[0] > 1.0) + (limits[1] > 1.0)))
    as_in_scipy(lambda y: -5.0 if ~(limits[0] > 1.0) else -9.0)


def test_a_switch_of_the_user_is_compiled():
    class Model:
        fast = True

        def fun(self, t, y):
            return -9.0 * y if self.fast is True else -5.0 * y

    model = Model()
    with warnings.catch_warnings():
        warnings.simplefilter("error", fastdyn.CompileWarning)
        first = fastdyn.solve_ivp(model.fun, (0.0, 1.0), [1.0, 0.5])
    model.fast = False
    assert fastdyn.solve_ivp(model.fun, (0.0, 1.0), [1.0, 0.5]).y[0, -1] > 5 * first.y[0, -1]


def test_a_complex_number_is_no_key():
    as_in_scipy(lambda y: {1j: -1.0}.get(y[0], -5.0) * y[0], start=[1j, 2.0])
