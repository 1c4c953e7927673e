"""Robust losses, likelihoods and noise of each record, beside SciPy's and exact formulas."""

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import least_squares

from fastdyn import Free, Record, fit

TIMES = np.linspace(0.0, 4.0, 40)
ROWS = np.stack([np.ones_like(TIMES), TIMES], axis=1)
CLOSE = 1e-5  # of optima: the sum of losses is flat to `ftol`, 1e-8, in the parameters to its root


def line(t, y, slope):
    return [slope + 0 * y[0]]


def drawn(seed=0, deviation=0.1, outliers=0):
    rng = np.random.default_rng(seed)
    values = 1.0 + 0.5 * TIMES + deviation * rng.normal(size=TIMES.shape)
    values[rng.permutation(len(values))[:outliers]] += 3.0
    return values


def of_line(values, noise, **options):
    return fit(line, Record(TIMES, values, [Free(0.9)], (Free(0.6),), noise), **options)


def huber(z):
    inner = z <= 1
    root = np.sqrt(np.where(inner, 1.0, z))
    return np.array(
        [np.where(inner, z, 2 * root - 1), 1 / root, np.where(inner, 0, -0.5 / root**3)]
    )


@pytest.mark.parametrize("loss", ["soft_l1", "huber", "cauchy", "arctan", huber])
@pytest.mark.parametrize("f_scale", [1.0, 1.5])
def test_a_loss_is_that_of_least_squares(loss, f_scale):
    values = drawn(outliers=4)
    found = of_line(values, 0.1, loss=loss, f_scale=f_scale)
    other = least_squares(
        lambda x: (ROWS @ x - values) / 0.1, [1.0, 0.5], loss=loss, f_scale=f_scale, ftol=1e-14,
        xtol=1e-14, gtol=1e-14,
    )  # fmt: skip
    assert np.allclose(found.x, other.x, atol=CLOSE) and np.isclose(found.chi2, 2 * other.cost)
    squares = of_line(values, 0.1)
    assert np.abs(found.x - [1.0, 0.5]).max() < 0.5 * np.abs(squares.x - [1.0, 0.5]).max()
    assert found.p_value is None and found.aic is None and not found.curved
    with pytest.raises(ValueError, match="no profile"):
        found.profile("slope")


def test_errors_of_a_robust_fit_are_those_of_m_estimates():
    """Huber 1981, (6.5) of section 7.6, with the weights written out."""
    values, k = drawn(seed=3, outliers=3), 1.345
    found = of_line(values, 0.1, loss="huber", f_scale=k)
    r = (ROWS @ found.x - values) / 0.1
    psi, slope, n, p = np.clip(r, -k, k), np.abs(r) <= k, len(r), 2
    correction = 1 + p / n * (slope.mean() * (1 - slope.mean())) / slope.mean() ** 2
    factor = correction**2 * (psi @ psi) / (n - p) / slope.mean() ** 2
    exact = factor * np.linalg.inv(ROWS.T @ ROWS / 0.01)
    assert np.allclose(found.covariance, exact, rtol=1e-4)
    assert np.isclose(found.quantile, stats.t.ppf(0.975, n - p))


def test_intervals_of_robust_fits_hold_with_outliers():
    """Of 200 repetitions, about 190 contain the truth: 3.5 deviations of the binomial allowed."""
    inside = np.zeros(2)
    for seed in range(200):
        found = of_line(drawn(seed=seed, outliers=2), None, loss="huber", f_scale=1.345)
        inside += np.abs(found.x - [1.0, 0.5]) < found.quantile * found.errors
    low = stats.binom.ppf(2e-4, 200, 0.95)
    assert (inside >= low).all()


def test_unknown_noise_of_a_robust_fit_is_that_of_the_median():
    values = drawn(seed=5, outliers=4)
    found = of_line(values, None, loss="soft_l1")
    r = ROWS @ found.x - values
    hat = np.trace(ROWS @ np.linalg.inv(ROWS.T @ ROWS) @ ROWS.T)
    exact = stats.median_abs_deviation(r, center=lambda x, axis: 0.0, scale="normal")
    assert np.isclose(found.noise["y[0]"], exact * np.sqrt(40 / (40 - hat)), rtol=1e-3)
    assert 0.05 < found.noise["y[0]"] < 0.2


def test_the_likelihood_of_known_noise():
    values, deviations = drawn(), np.linspace(0.05, 0.2, 40)
    found = of_line(values, deviations)
    exact = stats.norm.logpdf(values, ROWS @ found.x, deviations).sum()
    assert np.isclose(found.log_likelihood, exact)
    assert np.isclose(found.aic, 4 - 2 * exact)
    assert np.isclose(found.bic, 2 * np.log(40) - 2 * exact)
    assert f"AIC = {found.aic:.6g}" in str(found)


def test_the_likelihood_of_unknown_noise_counts_the_deviation():
    """R's logLik of a linear model: the deviation is that of largest likelihood."""
    values = drawn()
    found = of_line(values, None)
    r = values - ROWS @ np.linalg.lstsq(ROWS, values)[0]
    exact = stats.norm.logpdf(r, 0.0, np.sqrt((r**2).mean())).sum()
    assert np.isclose(found.log_likelihood, exact, rtol=1e-6)
    assert found.n_estimated == 3 and np.isclose(found.aic, 6 - 2 * exact, rtol=1e-6)


def test_the_likelihood_of_counts():
    counts = np.random.default_rng(1).poisson(3.0, 30)
    record = Record(np.arange(30.0), counts, [Free(2.0, low=0)], (), "poisson")
    found = fit(lambda t, y: [0 * y[0]], record)
    assert np.isclose(found.log_likelihood, stats.poisson.logpmf(counts, counts.mean()).sum())


def test_priors_do_not_count_in_the_likelihood():
    record = Record(TIMES, drawn(), [Free(0.0)], (Free(0.0, prior=(0.5, 0.01)),), 0.1)
    found = fit(line, record)
    exact = stats.norm.logpdf(record.values[0], ROWS @ found.x, 0.1).sum()
    assert np.isclose(found.log_likelihood, exact)


def test_noise_of_each_record():
    """Two records of one slope: each deviation that of its own residuals and leverage."""
    slope, records = Free(0.3), []
    for seed, deviation in ((1, 0.02), (2, 0.5)):
        values = drawn(seed, deviation) - 1.0
        records.append(Record(TIMES, values, [0.0], (slope,), "own", name=f"run {seed}"))
    found = fit(line, records)
    assert list(found.noise) == ["y[0] of run 1", "y[0] of run 2"] and found.n_estimated == 3
    x, s = found.x[0], np.array(list(found.noise.values()))
    information = [(TIMES @ TIMES) / each**2 for each in s]
    for record, each, own in zip(records, s, information, strict=True):
        r = record.values[0] - x * TIMES
        assert np.isclose(each**2, r @ r / (40 - own / sum(information)), rtol=1e-3)
    shared = fit(line, [Record(TIMES, r.values, [0.0], (slope,)) for r in records])
    assert list(shared.noise) == ["y[0]"] and found.errors[0] < 0.2 * shared.errors[0]
