"""The growth of a series with time: bounded, a random walk, a line, or worse."""

import math
from typing import NamedTuple

import numpy as np

BOUNDED = "bounded"
WALK = "random walk"
LINEAR = "linear"
WORSE = "quadratic or worse"
UNDECIDED = "not yet distinguishable"
FEWEST = 64  # points below which nothing is said
RISE = 3.0  # growth of the mean square difference over that of neighbours that counts as growth
WIDTH = 0.25  # half the interval of the exponent: two standard deviations of a random walk's
STEADY = 6.0  # standard errors at which a slope under noise is believed


class Growth(NamedTuple):
    """The growth of a series in the long run.

    Attributes
    ----------
    slope, slope_error : float
        Slope of a straight line through the series, per unit of time, and its standard error.
    exponent : float
        The series grows as t**exponent: 0 bounded, 1/2 a random walk, 1 a line.
    interval : (float, float)
        Interval of the exponent at 95 %.
    verdict : str
        The growth in words.
    """

    slope: float
    slope_error: float
    exponent: float
    interval: tuple
    verdict: str


def growth(t, x, spread=0.0):
    """
    Judge a series of equally spaced values that starts from zero.

    Parameters
    ----------
    t, x : array_like, shape (n,)
        Times after the start, and values.
    spread : float
        Range of the quantity within the time of one value.  A random walk that stays below a tenth
        of this range is called bounded.

    Returns
    -------
    Growth

    Notes
    -----
    The mean square difference of values l apart is flat in l for a bounded series, grows as l for
    a random walk and as l² for a line (B. B. Mandelbrot and J. W. Van Ness, "Fractional Brownian
    motions, fractional noises and applications", SIAM Rev. 10 (1968)). The exponent is half the
    slope of its logarithm over lags from 1/32 to 1/4 of the series, less the difference of
    neighbours, which is noise. That of a random walk scatters by 0.12 whatever the length. A
    line and a parabola are told apart by the power of the values themselves.
    """
    t = np.asarray(t, float)
    x = np.asarray(x, float)
    if len(x) < FEWEST or not np.isfinite(x).all():
        return Growth(math.nan, math.nan, math.nan, (math.nan, math.nan), UNDECIDED)
    slope, slope_error = _line(t, x)
    lags = np.unique(np.geomspace(len(x) / 32, len(x) / 4, 9).round().astype(int))
    noise = np.mean(np.diff(x) ** 2)
    apart = np.array([np.mean((x[lag:] - x[:-lag]) ** 2) for lag in lags])
    if not apart.max() > RISE * noise:
        if abs(slope) > STEADY * slope_error > 0.0:
            return Growth(slope, slope_error, 1.0, (1.0 - WIDTH, 1.0 + WIDTH), LINEAR)
        return Growth(slope, slope_error, 0.0, (0.0, WIDTH), BOUNDED)
    exponent = 0.5 * np.polyfit(np.log(lags), np.log(np.maximum(apart - noise, 1e-300)), 1)[0]
    if exponent > 1.0 - WIDTH:
        power, error = _power(t, x)
        interval = (power - 2.0 * error, power + 2.0 * error)
        verdict = UNDECIDED
        for low, high, name in ((-math.inf, 0.25, BOUNDED), (0.75, 1.5, LINEAR), (1.5, 9e9, WORSE)):
            if low < interval[0] and interval[1] < high:
                verdict = name
        return Growth(slope, slope_error, power, interval, verdict)
    exponent = max(float(exponent), 0.0)
    inside = [
        verdict
        for verdict, value in ((BOUNDED, 0.0), (WALK, 0.5))
        if abs(exponent - value) <= WIDTH
    ]
    verdict = inside[0] if len(inside) == 1 else UNDECIDED
    if x.std() < 0.1 * spread:
        verdict = BOUNDED
    interval = (max(0.0, exponent - WIDTH), exponent + WIDTH)
    return Growth(slope, slope_error, exponent, interval, verdict)


def _line(t, x):
    """Slope by least squares and its standard error, widened for neighbours that resemble."""
    a = t - t.mean()
    slope = float(a @ x / (a @ a))
    rest = x - x.mean() - slope * a
    size = rest @ rest
    like = float(rest[1:] @ rest[:-1] / size) if size > 0.0 else 0.0
    alike = (1.0 + min(like, 0.999)) / (1.0 - min(like, 0.999))
    error = math.sqrt(size / (a @ a) / (len(x) - 2) * max(alike, 1.0))
    return slope, error


def _power(t, x):
    """The power p of |x| ~ t^p over the last three quarters, and its standard error."""
    late = slice(len(x) // 4, None)
    a = np.log(t[late])
    b = np.log(np.maximum(np.abs(x[late]), 1e-300))
    (power, _), cov = np.polyfit(a, b, 1, cov=True)
    return float(power), float(math.sqrt(cov[0, 0]))
