"""The response of linear equations that are forced periodically."""

import math

import numpy as np

from .orbit import half_ranges
from .period import looks
from .rest.kinds import ZERO

LINEAR = 1e-12  # relative change of the Jacobian of linear equations
LOOKS = 5  # times and states at which the Jacobian is compared
SAMPLES = (256, 1024, 4096)  # samples of the forcing in a period, increased in turn
SMOOTH = 1e-6  # relative change of the amplitude by more samples
RESONANT = 1e-12  # relative distance of an eigenvalue from a frequency that counts as resonance
UNSTABLE = "the equations have motions that grow"
ROUGH = "The forcing has jumps or kinks: amplitudes are not exact, but to some 1e-3."
UNDAMPED = "resonance without damping"
LEAST = 1e-13  # harmonic of the forcing, relative to the largest


def is_linear(equations, y, omega):
    """Whether the Jacobian is equal at several states and times."""
    derivatives, period = equations.differentiated(0.0, y), 2.0 * math.pi / omega
    first, *others = [derivatives.at(t, state) for t, state in looks(0.0, y, period)[:LOOKS]]
    size = np.abs(first).max()
    return all(np.abs(each - first).max() <= LINEAR * size for each in others)


def exact(equations, y, omega):
    """((amplitude, harmonic) of linear equations, each of shape (n,), or None; a message).

    None: free motions grow and leave the steady state, or a resonance without damping has no steady
    state.
    """
    matrix, period = equations.differentiated(0.0, y).at(0.0, y), 2.0 * math.pi / omega
    values = np.linalg.eigvals(matrix)
    if values.real.max() > ZERO * np.abs(values).max():
        return None, UNSTABLE
    found = last = None
    change = np.inf
    for n_samples in SAMPLES:
        times = np.arange(n_samples) / n_samples * period
        forcing = np.array([equations.rates(t, y) for t in times]).T - (matrix @ y)[:, None]
        parts = np.fft.rfft(forcing) / n_samples
        kept = np.abs(parts).max(axis=0) > LEAST * np.abs(parts).max()
        kept[0] = False
        steady = np.zeros(parts.shape, complex)
        for k in np.flatnonzero(kept):
            if np.abs(1j * k * omega - values).min() <= RESONANT * k * omega:
                return None, UNDAMPED
            system = 1j * k * omega * np.eye(len(y)) - matrix
            steady[:, k] = np.linalg.solve(system, parts[:, k])
        curve = np.fft.irfft(steady * n_samples, axis=1)
        found = half_ranges(np.hstack([curve, curve[:, :1]])), 2.0 * steady[:, 1]
        if not kept[n_samples // 4 :].any():
            return found, ""
        if last is not None:
            change = np.abs(found[0] - last).max() / max(found[0].max(), 1e-300)
        last = found[0]
    return found, "" if change < SMOOTH else ROUGH
