"""Units do not decide where a fit ends: large and tiny numbers, bounds, masks, digits."""

import numpy as np
import pytest
from scipy.optimize import curve_fit

from fastdyn import Free, Record, fit

TIMES = np.linspace(0.0, 0.3, 30)
NOISE = 0.01
VALUES = np.exp(-8.0 * TIMES) + NOISE * np.random.default_rng(0).normal(size=30)


def in_units(unit):
    """Decay whose rate is in units of 1/unit."""

    def decay(t, y, rate):
        return [-rate * unit * y[0]]

    return decay


def by_curve_fit():
    deviations = np.full(30, NOISE)
    given = {"sigma": deviations, "absolute_sigma": True, "ftol": 1e-12, "xtol": 1e-12}
    found = curve_fit(lambda t, rate: np.exp(-rate * t), TIMES, VALUES, 6.0, **given)
    return found[0][0], np.sqrt(found[1][0, 0])


@pytest.mark.parametrize("unit", [1e-15, 1e-9, 1.0, 1e9, 1e13])
@pytest.mark.parametrize("low", [-np.inf, 0.0])
def test_units_of_a_parameter_do_not_decide(unit, low):
    """To 1e-3 of the error, at which the sum of squares is flat to `ftol`, 1e-8 of 24."""
    value, error = by_curve_fit()
    given = Record(TIMES, VALUES, [1.0], (Free(5.0 / unit, low=low),), NOISE)
    found = fit(in_units(unit), given)
    assert found.success and abs(found.x[0] * unit - value) < 1e-3 * error
    assert np.isclose(found.errors[0] * unit, error, rtol=1e-5)
    assert "At a bound" not in str(found)


def test_a_parameter_beside_one_that_is_known_to_ten_digits():
    """The distance to the optimum is measured in errors, not in shares of the largest number."""
    draws = np.random.default_rng(4).normal(size=30)

    def both(t, y, rate):
        return [1.0 + 0 * y[0], -rate * y[1]]

    values = np.stack([1e10 + TIMES + draws, VALUES])
    record = Record(TIMES, values, [Free(1e10 + 7), 1.0], (Free(5.0),), [1.0, NOISE])
    found = fit(both, record, rtol=1e-12)
    exact = (values[0] - TIMES).mean(), by_curve_fit()[0]
    assert np.all(np.abs(found.x - exact) < 1e-3 * found.errors)


def test_noise_of_a_billionth_is_reached():
    """The first search has a deviation as large as the values: its end is relative to no noise."""
    values = np.exp(-0.9 * TIMES) + 1e-10 * np.random.default_rng(1).normal(size=30)
    found = fit(in_units(1.0), Record(TIMES, values, [1.0], (Free(2.0),)), rtol=1e-13, atol=1e-15)
    given = {"ftol": 1e-15, "xtol": 1e-15, "gtol": 1e-15}
    exact = curve_fit(lambda t, rate: np.exp(-rate * t), TIMES, values, 0.9, **given)
    assert abs(found.x[0] - exact[0][0]) < 1e-2 * found.errors[0] < 1e-10
    row = str(found).splitlines()[2].split()
    assert row[1][:6] == "0.8999" or len(row[1]) > 9  # digits by the error, not six
    assert float(row[3]) < found.x[0] < float(row[5])


def test_masked_values_are_missing():
    masked = np.ma.masked_array(VALUES.copy(), mask=TIMES > 0.2)
    masked.data[TIMES > 0.2] = 99.0
    missing = np.where(TIMES > 0.2, np.nan, VALUES)
    rate = Free(5.0)
    found = [
        fit(in_units(1.0), Record(TIMES, v, [1.0], (rate,), NOISE)).x[0] for v in (masked, missing)
    ]
    assert found[0] == found[1] and abs(found[0] - 8) < 1
    with pytest.raises(ValueError, match="`t` must be finite times"):
        Record(np.ma.masked_array(TIMES, TIMES > 0.2), VALUES, [1.0], (rate,), NOISE)


def test_a_value_far_from_its_bound_is_not_at_it():
    """The error is 1e5 times the value, and the value is not near 0."""

    def nearly(t, y, other):
        return [-(8.0 + 1e-9 * other) * y[0]]

    values = np.exp(-(8.0 + 1e-9 * 362) * TIMES)
    found = fit(nearly, Record(TIMES, values, [1.0], (Free(362.0, low=0.0),), NOISE), rtol=1e-12)
    assert found.errors[0] > 1e5 * 362 and "At a bound" not in str(found)
    held = Free(5.0, low=0.0, high=6.0)
    found = fit(in_units(1.0), Record(TIMES, VALUES, [1.0], (held,), NOISE))
    assert "At a bound: rate." in str(found)
