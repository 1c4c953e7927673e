"""The response of linear equations that are forced periodically."""

import math

import numpy as np

from .orbit import half_ranges
from .period import looks
from .rest.kinds import ZERO

LINEAR = 1e-12  # relative change of the Jacobian of linear equations
LOOKS = 5  # times and states at which it is looked at
SAMPLES = 256  # of the forcing over a period
RESONANT = 1e-12  # of a frequency: eigenvalues as near are at resonance without damping
UNSTABLE = "the equations have motions that grow"
UNDAMPED = "resonance without damping"
LEAST = 1e-13  # harmonic of the forcing, relative to the largest


def is_linear(equations, y, omega):
    """Whether the Jacobian is the same at all states and times that are looked at."""
    derivatives, period = equations.differentiated(0.0, y), 2.0 * math.pi / omega
    first, *others = [derivatives.at(t, state) for t, state in looks(0.0, y, period)[:LOOKS]]
    size = np.abs(first).max()
    return all(np.abs(each - first).max() <= LINEAR * size for each in others)


def exact(equations, y, omega):
    """((amplitude, harmonic) of linear equations, shape (n,) each; or None, and why).

    A motion that grows leaves each steady state, and a resonance without damping has none.
    """
    matrix, period = equations.differentiated(0.0, y).at(0.0, y), 2.0 * math.pi / omega
    values = np.linalg.eigvals(matrix)
    if values.real.max() > ZERO * np.abs(values).max():
        return None, UNSTABLE
    times = np.arange(SAMPLES) / SAMPLES * period
    forcing = np.array([equations.rates(t, y) for t in times]).T - (matrix @ y)[:, None]
    parts = np.fft.rfft(forcing) / SAMPLES
    steady = np.zeros(parts.shape, complex)
    for k in np.flatnonzero(np.abs(parts).max(axis=0) > LEAST * np.abs(parts).max()):
        if k:
            if np.abs(1j * k * omega - values).min() <= RESONANT * k * omega:
                return None, UNDAMPED
            steady[:, k] = np.linalg.solve(1j * k * omega * np.eye(len(y)) - matrix, parts[:, k])
    curve = np.fft.irfft(steady * SAMPLES, axis=1)
    return (half_ranges(np.hstack([curve, curve[:, :1]])), 2.0 * steady[:, 1]), ""
