"""Problems with known truth, and one fit of each to values drawn at random."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn import Free, Record, fit, solve_ivp


class Known(NamedTuple):
    """A problem whose parameters are known.

    `record(values, frees)` makes the Record, `exact` are the values without noise, and
    `draw(exact, rng)` draws values.
    """

    fun: Any
    truth: np.ndarray
    starts: tuple
    exact: np.ndarray
    draw: Any
    record: Any

    def fitted(self, seed, **options):
        """The Fit of values drawn with a seed."""
        values = self.draw(self.exact, np.random.default_rng(seed))
        frees = [Free(start, low=low) for start, low in self.starts]
        return fit(self.fun, self.record(values, frees), **options)


def tight(fun, t, y0, args):
    """States at times, much closer to the exact ones than a fit sees."""
    span = t[0], t[-1]
    return solve_ivp(fun, span, y0, "DOP853", t, args=args, rtol=1e-11, atol=1e-12).y


def pendulum(t, y, stiffness, damping):
    return [y[1], -stiffness * np.sin(y[0]) - damping * y[1]]


def seir(t, y, beta, sigma, gamma):
    s, e, i, _ = y
    return [-beta * s * i, beta * s * i - sigma * e, sigma * e - gamma * i, gamma * i]


def reaction(t, y, k1, k2, k3):
    a, b, _ = y
    return [-k1 * a + k3 * b, k1 * a - k2 * b - k3 * b, k2 * b]


def predator(t, y, a, b, c, d):
    return [a * y[0] - b * y[0] * y[1], -c * y[1] + d * y[0] * y[1]]


def counted(t, y, *args):
    return 2000.0 * y[2]


def counted_twice(t, y, *args):
    return [2000.0 * y[2], 2000.0 * y[3]]


def _swing():
    t, truth = np.linspace(0, 10, 80), np.array([1.2, 0.0, 9.0, 0.15])
    return Known(
        pendulum, truth, ((0.9, -np.inf), (0.3, -np.inf), (8.0, 0.0), (0.05, -np.inf)),
        tight(pendulum, t, truth[:2], tuple(truth[2:]))[:1],
        lambda exact, rng: exact + 0.03 * rng.normal(size=exact.shape),
        lambda v, p: Record(t, v, p[:2], tuple(p[2:]), noise=0.03, observed=0),
    )  # fmt: skip


def _epidemic(latency):
    t = np.arange(0.0, 100.0, 2.0)
    if latency:  # is hardly determined
        truth, starts, observed = np.array([0.5, 0.2, 0.1]), (0.4, 0.3, 0.15), counted_twice

        def record(v, p):
            return Record(t, v, [1 - 1e-3, 0.0, 1e-3, 0.0], tuple(p), "poisson", observed)

        y = tight(seir, t, [1 - 1e-3, 0.0, 1e-3, 0.0], tuple(truth))
    else:
        truth, starts, observed = np.array([1e-3, 0.5, 0.1]), (2e-3, 0.4, 0.15), counted

        def record(v, p):
            y0 = [1 - 1e-3, 0.0, p[0], 0.0]
            return Record(t, v, y0, (p[1], 0.2, p[2]), "poisson", observed)

        y = tight(seir, t, [1 - 1e-3, 0.0, 1e-3, 0.0], (0.5, 0.2, 0.1))
    exact = 2000.0 * y[2:] if latency else 2000.0 * y[2:3]
    return Known(
        seir, truth, tuple((s, 0.0) for s in starts), np.maximum(exact, 0.0),
        lambda exact, rng: rng.poisson(exact).astype(float), record,
    )  # fmt: skip


def _rates():
    t, truth = np.linspace(0, 10, 40), np.array([1.0, 0.5, 0.3])

    def draw(exact, rng):
        values = exact + 0.01 * rng.normal(size=exact.shape)
        values[rng.random(values.shape) < 0.3] = np.nan
        return values

    return Known(
        reaction, truth, ((0.5, 0.0), (1.0, 0.0), (0.1, 0.0)),
        tight(reaction, t, [1.0, 0.0, 0.0], tuple(truth))[[0, 2]], draw,
        lambda v, p: Record(t, v, [1.0, 0.0, 0.0], tuple(p), noise=0.01, observed=[0, 2]),
    )  # fmt: skip


def _populations():
    t, truth = np.linspace(0, 15, 30), np.array([1.0, 0.1, 1.5, 0.075])
    deviations = np.array([[1.0], [0.3]])  # unknown to the fit
    return Known(
        predator, truth, ((0.9, 0.0), (0.12, 0.0), (1.4, 0.0), (0.08, 0.0)),
        tight(predator, t, [10.0, 5.0], tuple(truth)),
        lambda exact, rng: exact + deviations * rng.normal(size=exact.shape),
        lambda v, p: Record(t, v, [10.0, 5.0], tuple(p)),
    )  # fmt: skip


KNOWN = {
    "pendulum": _swing,
    "epidemic": lambda: _epidemic(False),
    "latency": lambda: _epidemic(True),
    "rates": _rates,
    "populations": _populations,
}
