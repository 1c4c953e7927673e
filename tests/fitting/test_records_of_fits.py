"""What a Record takes: systems, containers, starting times, logarithms; and how it shows."""

import dataclasses
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import curve_fit, least_squares

from fastdyn import Free, Record, fit
from fastdyn.systems.pendulum import Pendulum
from support.fits import tight

TIMES = np.linspace(0.0, 5.0, 40)


def swing(t, y, p):
    return [y[1], -p["stiffness"] * np.sin(y[0]) - p["damping"][0] * y[1]]


def plain(t, y, stiffness, damping):
    return [y[1], -stiffness * np.sin(y[0]) - damping * y[1]]


class Named(NamedTuple):
    stiffness: object
    damping: object


@dataclasses.dataclass
class Fields:
    stiffness: object
    damping: object


def by_names(t, y, p):
    return [y[1], -p.stiffness * np.sin(y[0]) - p.damping * y[1]]


def noisy(fun, y0, args, seed=0, deviation=0.02):
    exact = tight(fun, TIMES, y0, args)[0]
    return exact + deviation * np.random.default_rng(seed).normal(size=exact.shape)


VALUES = noisy(plain, [1.0, 0.0], (9.0, 0.15))


def known():
    record = Record(TIMES, VALUES, [1.0, 0.0], (Free(8.5), Free(0.1)), 0.02, 0)
    return fit(plain, record)


@pytest.mark.parametrize("kind", [Named, Fields])
def test_a_named_tuple_or_a_dataclass_of_free(kind):
    record = Record(TIMES, VALUES, [1.0, 0.0], (kind(Free(8.5), Free(0.1)),), 0.02, 0)
    found, other = fit(by_names, record, starts=3), known()
    assert found.names == ["stiffness", "damping"]
    assert np.allclose(found.x, other.x, rtol=1e-6)
    assert np.allclose(found.covariance, other.covariance, rtol=1e-4)
    (args,) = found.args()
    assert isinstance(args, kind) and args.stiffness == found.x[0]


def test_a_dict_of_free_beside_what_is_observed_and_an_event():
    """The other functions get the dict, too; its lists are arrays."""

    def degrees(t, y, p):
        return y[0] * p["scale"]

    def never(t, y, p):
        return y[0] - 100 * p["stiffness"]

    never.terminal = True
    given = {"stiffness": Free(8.5), "damping": [Free(0.1), 7.0], "scale": 57.0}
    record = Record(TIMES, 57.0 * VALUES, [1.0, 0.0], (given,), 57.0 * 0.02, degrees)
    found, other = fit(swing, record, events=never), known()
    assert found.names == ["stiffness", "damping[0]"]
    assert np.allclose(found.x, other.x, rtol=1e-6)
    (args,) = found.args()
    assert args["damping"].tolist() == [found.x[1], 7.0] and args["scale"] == 57.0
    assert found.predict([1.0], observed=True).y.shape == (1, 1)
    with pytest.raises(TypeError, match="`project` is a function, and the arguments"):
        fit(swing, record, project=lambda t, y, p: y)


def decay(t, y, rate):
    return [-rate * y[0]]


def test_a_starting_time():
    """y = exp(-k (t - t0)) from 1 at t0: curve_fit on the formula."""
    times, rng = np.linspace(0.5, 3.0, 30), np.random.default_rng(2)
    values = np.exp(-0.7 * (times + 0.4)) + 0.01 * rng.normal(size=30)
    record = Record(times, values, [1.0], (Free(1.0),), 0.01, t0=Free(0.0))
    found = fit(decay, record)
    x, covariance = curve_fit(
        lambda t, t0, k: np.exp(-k * (t - t0)), times, values, [0.0, 1.0], np.full(30, 0.01),
        absolute_sigma=True, ftol=1e-13, xtol=1e-13,
    )  # fmt: skip
    at = [found.names.index(name) for name in ("t0", "rate")]
    assert np.allclose(found.x[at], x, atol=1e-5)
    assert np.allclose(found.covariance[np.ix_(at, at)], covariance, rtol=1e-3)
    assert found.t0() == found.values["t0"] and f"t0 = {found.t0():.6g}" in str(found)
    assert found.predict([found.t0(), 1.0]).y[0, 0] == 1.0
    by_differences = fit(decay, record, differences=True)
    assert np.allclose(by_differences.x, found.x, rtol=1e-5)


def test_a_starting_time_of_equations_that_depend_on_the_time():
    """Beside least_squares on solves of its own, with a start that is free, too."""

    def driven(t, y, k):
        return [np.cos(3 * t) - k * y[0] * y[1], y[0] - y[1]]

    times = np.linspace(0.0, 3.0, 25)

    def states(x, t=times):
        t0, first, k = x
        return tight(driven, np.r_[t0, t], [first, 0.2], (k,))[:, 1:]

    values = states([-0.3, 1.0, 0.8]) + 0.01 * np.random.default_rng(0).normal(size=(2, 25))
    record = Record(times, values, [Free(0.8), 0.2], (Free(1.0),), 0.01, t0=Free(-0.2))
    found = fit(driven, record)
    other = least_squares(
        lambda x: ((states(x) - values) / 0.01).ravel(), [-0.3, 1.0, 0.8], "3-point", xtol=1e-12
    )
    at = [found.names.index(name) for name in ("t0", "y0[0]", "rate" if 0 else "k")]
    assert np.all(np.abs(found.x[at] - other.x) < 1e-3 * found.errors[at])
    covariance = np.linalg.inv(other.jac.T @ other.jac)
    assert np.allclose(found.covariance[np.ix_(at, at)], covariance, rtol=1e-3)


def test_a_starting_time_stays_before_the_first_value():
    times = np.linspace(1.0, 3.0, 12)
    record = Record(times, np.ones(12), [1.0], (Free(0.1),), 0.1, t0=Free(0.9))
    found = fit(decay, record)
    assert found.t0() <= 1.0


def test_a_free_in_the_logarithm_is_one_of_the_logarithm():
    """The optimum is the same; errors are those of ln k times k, intervals those of ln k."""
    values = np.exp(-0.7 * TIMES) + 0.05 * np.random.default_rng(4).normal(size=40)
    found = fit(decay, Record(TIMES, values, [1.0], (Free(1e-4, log=True),), 0.05))
    plain = fit(decay, Record(TIMES, values, [1.0], (Free(0.5),), 0.05))
    assert np.isclose(found.x[0], plain.x[0], rtol=1e-5)
    assert np.isclose(found.errors[0], plain.errors[0], rtol=1e-4)
    relative = found.errors[0] / found.x[0]
    ends = found.x[0] * np.exp(found.quantile * relative * np.array([-1, 1]))
    assert not found.curved and np.allclose(found.intervals[0], ends, rtol=1e-6)
    assert np.allclose(found.profile("rate"), plain.profile("rate"), rtol=1e-3)
    band = plain.predict([1.0]).band
    assert np.allclose(found.predict([1.0]).band, band, rtol=1e-4)
    assert found.x[0] > 0 and repr(Free(1e-4, log=True)) == "Free(0.0001, low=0, log=True)"
    with pytest.raises(ValueError, match="`log=True` starts above 0; got -1"):
        Free(-1.0, log=True)


def test_logarithms_find_what_is_orders_of_magnitude_away():
    values = np.exp(-2e-6 * TIMES * 1e6)
    given = [Free(1e-9, log=True), Free(2e-5, log=True, high=1.0)]
    for rate in given:
        record = Record(TIMES, values, [1.0], (rate,), 0.01)
        found = fit(lambda t, y, k: [-k * 1e6 * y[0]], record, starts=8, method="LSODA")
        assert np.isclose(found.x[0], 2e-6, rtol=1e-4)


def test_two_that_are_not_determined_in_logarithms():
    def product(t, y, a, b):
        return [-a * b * y[0]]

    pair = Free(1.0, log=True), Free(0.5, log=True)
    found = fit(product, Record(TIMES, np.exp(-0.7 * TIMES), [1.0], pair, 0.01))
    (row,) = found.unseen
    assert list(row) == ["ln a", "ln b"] and np.isclose(row["ln a"], -row["ln b"], rtol=1e-3)


def test_a_system_by_the_names_of_its_parameters():
    system = Pendulum(l=2.0, V0=1.0)
    run = system.solve((0, 5), t_eval=TIMES, rtol=1e-10, atol=1e-12)
    values = run.y[0] + 0.01 * np.random.default_rng(0).normal(size=40)
    record = Record(TIMES, values, args={"g": Free(9.0)}, noise=0.01, observed="theta")
    found = fit(system, record)
    other = Record(TIMES, values, system.initial_state(), (Free(9.0), 2.0, 1.0), 0.01, 0)
    assert found.names == ["g"] and np.array_equal(found.x, fit(system.rhs, other).x)
    assert np.array_equal(fit(system, other).x, found.x)
    assert "y0 of the system" in repr(record)
    with pytest.raises(ValueError, match="start of the pendulum depends on `l`, which is sought"):
        fit(system, Record(TIMES, values, args={"l": Free(1.5)}, observed="theta"))


def test_a_derived_system():
    pytest.importorskip("sympy")
    from fastdyn.derive.pages import page

    system = page("pendulum").derive().system()
    run = system.solve((0, 2), t_eval=TIMES / 2.5, rtol=1e-10, atol=1e-12)
    name = system.parameter_fields()[0].name
    record = Record(TIMES / 2.5, run.y, args={name: Free(0.9 * getattr(system, name))}, noise=1e-3)
    assert fit(system, record).names == [name]


def test_y0_after_0_without_a_time_is_told():
    """A rate of 0.7 from y(0) = 1, first measured at 1, would be found as 1.7."""
    times = np.linspace(1.0, 3.0, 10)
    values = np.exp(-0.7 * times)
    with pytest.warns(UserWarning, match="state at the first time, t0 = 1.*give `t0=0`"):
        fit(decay, Record(times, values, [1.0], (Free(1.0),), 0.01))
    found = fit(decay, Record(times, values, [1.0], (Free(1.0),), 0.01, t0=0))
    assert np.isclose(found.x[0], 0.7, rtol=1e-6)
    assert "y0 is the state at t0 = 0." in str(found)
    fit(decay, Record(times, values, [Free(1.0)], (Free(1.0),), 0.01))
    fit(decay, Record(times, values, [values[0]], (Free(1.0),), 0.01, t0=1.0))


def test_how_records_and_free_numbers_show():
    record = Record([0.0, 1.0, 2.0], [[1.0, np.nan, 2.0]], [1.0], name="first")
    said = "Record('first': 1 series of 3 values from t = 0 to 2, 1 missing, y0 at t0 = 0)"
    assert repr(record) == said
    assert repr(Free(2.0, prior=(1.0, 0.5))) == "Free(2.0, prior=(1, 0.5))"


def test_a_picture_of_all_records():
    records = [
        Record(TIMES, np.exp(-0.7 * TIMES), [1.0], (Free(1.0),), 0.01, name="first"),
        Record(TIMES, np.exp(-0.3 * TIMES), [1.0], (Free(1.0),), 0.01),
    ]
    found = fit(decay, records, level=0.997)
    assert found.names == ["rate of first", "rate of record 1"]
    figure = found.plot()
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == ["first", "99.7% band of the motion", "record 1"]
    assert len(found.plot(record=1).axes[0].lines) == 2 and "99.7% interval" in str(found)
