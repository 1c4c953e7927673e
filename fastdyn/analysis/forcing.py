"""Equations that are forced periodically: their period, and the response of linear ones."""

import math

import numpy as np

from .orbit import half_ranges

LINEAR = 1e-12  # relative change of the Jacobian of linear equations
LOOKS = 5  # times and states at which it is looked at
SAMPLES = 256  # of the forcing over a period
LEAST = 1e-13  # harmonic of the forcing, relative to the largest


def _looks(y, period):
    """Times and states at which equations are looked at."""
    rng = np.random.default_rng(0)
    size = np.maximum(np.abs(y), 0.1)
    return [
        (period * rng.random(), y + 0.3 * size * rng.standard_normal(len(y))) for _ in range(LOOKS)
    ]


def check_period(equations, y, period):
    """Refuse equations that do not depend on the time, or are not periodic."""
    if equations.differentiated(0.0, y).autonomous:
        raise ValueError("`fun` does not depend on the time: nothing forces it.")
    for t, state in _looks(y, period):
        now, later = equations.rates(t, state), equations.rates(t + period, state)
        if np.abs(now - later).max() > 1e-8 * max(np.abs(now).max(), np.abs(later).max()):
            raise ValueError(
                f"`fun` does not have the period {period:.6g}, 2 pi / frequency: is `parameter` "
                "the angular frequency of the forcing?"
            )


def is_linear(equations, y, omega):
    """Whether the Jacobian is the same at all states and times that are looked at."""
    derivatives, period = equations.differentiated(0.0, y), 2.0 * math.pi / omega
    first, *others = [derivatives.at(t, state) for t, state in _looks(y, period)]
    size = np.abs(first).max()
    return all(np.abs(each - first).max() <= LINEAR * size for each in others)


def exact(equations, y, omega):
    """(amplitude, harmonic) of linear equations, shape (n,) each."""
    matrix, period = equations.differentiated(0.0, y).at(0.0, y), 2.0 * math.pi / omega
    times = np.arange(SAMPLES) / SAMPLES * period
    forcing = np.array([equations.rates(t, y) for t in times]).T - (matrix @ y)[:, None]
    parts = np.fft.rfft(forcing) / SAMPLES
    steady = np.zeros(parts.shape, complex)
    for k in np.flatnonzero(np.abs(parts).max(axis=0) > LEAST * np.abs(parts).max()):
        if k:
            system = 1j * k * omega * np.eye(len(y)) - matrix
            try:
                steady[:, k] = np.linalg.solve(system, parts[:, k])
            except np.linalg.LinAlgError:  # resonance without damping
                steady[:, k] = np.inf
    curve = np.fft.irfft(steady * SAMPLES, axis=1)
    return half_ranges(np.hstack([curve, curve[:, :1]])), 2.0 * steady[:, 1]
