"""Fits whose answer is known exactly: straight lines, constant rates, values without noise."""

import numpy as np
import pytest

from fastdyn import Free, Record, fit
from support.fits import KNOWN, pendulum, tight

TIMES = np.linspace(0.0, 4.0, 12)
ROUNDING = 1e-6  # of optima: a sum of squares that is flat to 1e-16 has a minimum that is to 1e-8


def line(t, y, slope):
    return [slope + 0 * y[0]]


def two_lines(t, y, slope):
    return [slope + 0 * y[0], -slope + 0 * y[1]]


def drawn(seed=0, deviation=0.1):
    rng = np.random.default_rng(seed)
    return 1.0 + 0.5 * TIMES + deviation * rng.normal(size=TIMES.shape)


def regression(rows, values, deviations):
    """(parameters, covariance) of weighted linear least squares."""
    a, b = rows / deviations[:, None], values / deviations
    covariance = np.linalg.inv(a.T @ a)
    return covariance @ a.T @ b, covariance


ROWS = np.stack([np.ones_like(TIMES), TIMES], axis=1)


def test_a_line_is_linear_regression():
    values, deviations = drawn(), np.linspace(0.05, 0.2, len(TIMES))
    found = fit(line, Record(TIMES, values, [Free(0.0)], (Free(0.0),), deviations))
    x, covariance = regression(ROWS, values, deviations)
    assert found.names == ["y0[0]", "slope"]
    assert np.allclose(found.x, x, atol=ROUNDING)
    assert np.allclose(found.covariance, covariance, rtol=ROUNDING)
    assert np.allclose(found.errors**2, np.diag(covariance), rtol=ROUNDING)
    r = (values - ROWS @ x) / deviations
    assert np.isclose(found.chi2, r @ r) and found.dof == 10
    assert np.allclose(found.residuals[0][0], -r, atol=ROUNDING)
    assert np.allclose(found.intervals[1], x[1] + 1.959964 * found.errors[1] * np.array([-1, 1]))
    assert np.isclose(found.correlations[0, 1], covariance[0, 1] / np.prod(found.errors))
    assert found.success and not found.curved and 0 < found.p_value < 1


def test_unknown_noise_is_that_of_linear_regression():
    values = drawn()
    found = fit(line, Record(TIMES, values, [Free(0.0)], (Free(0.0),)))
    x, covariance = regression(ROWS, values, np.ones_like(TIMES))
    r = values - ROWS @ x
    assert np.isclose(found.noise["y[0]"], np.sqrt(r @ r / 10), rtol=ROUNDING)
    assert np.allclose(found.covariance, covariance * (r @ r / 10), rtol=1e-5)
    assert np.isclose(found.quantile, 2.228139)  # Student's, 10 degrees of freedom
    assert found.p_value is None


def test_each_quantity_has_its_unknown_noise():
    """The deviations solve s^2 = sum of squares / (values - trace of the hat matrix's part)."""
    rng = np.random.default_rng(5)
    values = np.stack([TIMES, -TIMES]) + np.array([[0.02], [0.5]]) * rng.normal(size=(2, 12))
    found = fit(two_lines, Record(TIMES, values, [0.0, 0.0], (Free(0.3),)))
    rows, s = np.concatenate([TIMES, -TIMES])[:, None], np.ones(2)
    for _ in range(200):
        deviations = np.repeat(s, 12)
        x, covariance = regression(rows, values.ravel(), deviations)
        leverage = (rows[:, 0] / deviations) ** 2 * covariance[0, 0]
        r = (values.ravel() - rows @ x).reshape(2, -1)
        s = np.sqrt((r**2).sum(axis=1) / (12 - leverage.reshape(2, -1).sum(axis=1)))
    assert np.allclose(list(found.noise.values()), s, rtol=1e-3)
    assert np.allclose(found.x, x, rtol=1e-3) and s[1] > 10 * s[0]


def constant(t, y):
    return [0 * y[0]]


def test_counts_are_fitted_by_their_likelihood():
    counts = np.random.default_rng(3).poisson(2.5, 40).astype(float)
    counts[7] = np.nan
    here = counts[~np.isnan(counts)]
    found = fit(constant, Record(np.arange(40.0), counts, [Free(1.0, low=0)], (), "poisson"))
    assert np.isclose(found.x[0], here.mean(), rtol=ROUNDING)  # weights from data: far below
    assert np.isclose(found.errors[0], np.sqrt(here.mean() / 39), rtol=ROUNDING)
    some = here[here > 0]
    deviance = 2 * (some * np.log(some / here.mean())).sum()
    assert np.isclose(found.chi2, deviance) and (here == 0).any()


def test_a_prior_is_one_more_value():
    values, deviations = drawn(), np.full(12, 0.1)
    slope = Free(0.0, prior=(0.8, 0.02))
    found = fit(line, Record(TIMES, values, [Free(0.0)], (slope,), 0.1))
    rows, more = np.vstack([ROWS, [0, 1]]), np.r_[values, 0.8]
    x, covariance = regression(rows, more, np.r_[deviations, 0.02])
    assert np.allclose(found.x, x, atol=ROUNDING)
    assert np.allclose(found.covariance, covariance, rtol=ROUNDING) and found.dof == 11


def test_the_order_of_times_and_repeated_times_do_not_matter():
    t = np.r_[TIMES, TIMES[[3, 3, 8]]]
    values = np.r_[drawn(), 2.0, 2.3, 2.5]
    mixed = np.random.default_rng(1).permutation(len(t))
    found = fit(line, Record(t[mixed], values[mixed], [Free(0.0)], (Free(0.0),), 0.1))
    rows = np.stack([np.ones_like(t), t], axis=1)
    assert np.allclose(found.x, regression(rows, values, np.full(15, 0.1))[0], atol=ROUNDING)
    r = (found.x[0] + found.x[1] * t[mixed] - values[mixed]) / 0.1
    assert np.allclose(found.residuals[0][0], r, atol=1e-5)


def test_records_share_a_free_and_have_their_own():
    """Exact values: the parameters are those that made them, to the error of the solves."""
    stiffness, damping, t = Free(8.0), Free(0.05, name="damping"), np.linspace(0, 5, 30)
    records = []
    for angle in (0.5, 1.5):
        values = tight(pendulum, t, [angle, 0.0], (9.0, 0.15))[0]
        values[[4, 9]] = np.nan
        given = [Free(0.9 * angle), 0.0], (stiffness, damping)
        records.append(Record(t, values, *given, noise=0.01, observed=0))
    found = fit(pendulum, records)
    assert found.names == ["y0[0] of record 0", "stiffness", "damping", "y0[0] of record 1"]
    assert np.allclose(found.x, [0.5, 9.0, 0.15, 1.5], atol=1e-6)
    assert found.args(1) == tuple(found.x[1:3]) and found.y0(1)[0] == found.x[3]
    assert found.values["damping"] == found.x[2] and found.solver_error < 1e-4
    assert [r.shape for r in found.residuals] == [(1, 30), (1, 30)]


def test_free_numbers_in_lists_and_arrays():
    def mixing(t, y, rates, back):
        a, b = y
        return [-rates[0] * a + back[1] * b, rates[0] * a - back[1] * b - rates[1] * b]

    t, both = np.linspace(0, 5, 20), Free(0.5, name="both")
    values = tight(mixing, t, [1.0, 0.0], ([1.0, 0.2], np.array([0.0, 0.2])))
    args = [Free(0.7), both], np.array([0.0, both], dtype=object)
    found = fit(mixing, Record(t, values, [1.0, 0.0], args, 0.01))
    assert found.names == ["rates[0]", "both"] and np.allclose(found.x, [1.0, 0.2], atol=1e-6)
    whole = Free([0.5, 0.5], low=0, name="w")
    found = fit(mixing, Record(t, values, [1.0, 0.0], (whole, [0.0, 0.2]), 0.01))
    assert found.names == ["w[0]", "w[1]"] and np.allclose(found.x, [1.0, 0.2], atol=1e-6)
    start = Free([0.8, 0.1])
    found = fit(mixing, Record(t, values, start, ([1.0, 0.2], [0.0, 0.2]), 0.01))
    assert found.names == ["y0[0]", "y0[1]"] and np.allclose(found.x, [1.0, 0.0], atol=1e-6)


def test_what_the_data_do_not_determine_is_named():
    def decay(t, y, a, b):
        return [-a * b * y[0], 0.1 * a + 0 * y[1]]

    t = np.linspace(0, 3, 20)
    values = np.exp(-0.7 * t) + 0.01 * np.random.default_rng(0).normal(size=20)
    found = fit(decay, Record(t, values, [1.0, 0.0], (Free(1.0), Free(0.5)), 0.01, observed=0))
    ((a, b),) = [tuple(row.values()) for row in found.unseen]
    assert np.isclose(a / b, -found.x[0] / found.x[1], rtol=1e-4)  # along a b = constant
    assert np.isinf(found.errors).all() and np.isnan(found.correlations).all()
    assert "not determined by the data: a" in str(found)
    band = found.predict([1.0, 2.0]).band
    assert np.isfinite(band[0]).all() and np.isinf(band[1]).all()
    assert found.profile("a") == (-np.inf, np.inf)


def test_the_band_is_that_of_linear_regression():
    values, deviations = drawn(), np.full(12, 0.1)
    found = fit(line, Record(TIMES, values, [Free(0.0)], (Free(0.0),), 0.1), level=0.9)
    t = np.array([0.5, 6.0])
    rows = np.stack([np.ones(2), t], axis=1)
    x, covariance = regression(ROWS, values, deviations)
    y, band = found.predict(t)
    assert np.allclose(y[0], rows @ x, atol=ROUNDING)
    assert np.allclose(band[0], 1.644854 * np.sqrt(np.diag(rows @ covariance @ rows.T)), rtol=1e-5)
    own = found.predict(t, observed=True)
    assert np.array_equal(own.y, y) and np.array_equal(own.band, band)


def test_differences_find_the_same():
    exact, own = KNOWN["rates"]().fitted(2), KNOWN["rates"]().fitted(2, differences=True)
    assert np.allclose(own.x, exact.x, atol=1e-4 * exact.errors.min())
    assert np.allclose(own.covariance, exact.covariance, rtol=1e-4)


def jumping(t, y, push, friction):
    return [y[1], push - friction * np.sign(y[1] - 1.0)]


def test_functions_that_jump_are_fitted_by_differences():
    t = np.linspace(0, 5, 40)
    values = tight(jumping, t, [0.0, 0.0], (1.0, 0.4))
    record = Record(t, values, [0.0, 0.0], (Free(0.8), Free(0.3)), 0.01)
    with pytest.raises(ValueError, match=r"cannot start at push = 0.8, friction = 0.3.*jumps"):
        fit(jumping, record)
    assert np.allclose(fit(jumping, record, differences=True).x, [1.0, 0.4], atol=1e-3)


def test_a_table_and_a_figure():
    found = KNOWN["populations"]().fitted(0)
    said = str(found)
    assert "4 parameters from 60 values of 1 record" in said and "estimated noise of y[1]" in said
    (row,) = [row for row in said.splitlines() if row.startswith("d ")]
    assert np.isclose(float(row.split()[1]), found.x[3], rtol=1e-5)
    figure = found.plot(figsize=(4, 3))
    assert len(figure.axes) == 4 and tuple(figure.get_size_inches()) == (4, 3)
    points = figure.axes[0].lines[0].get_xydata()
    assert np.array_equal(points[:, 0], np.linspace(0, 15, 30))
