"""What rounding may do to a solution: the measure for comparisons with another library.

The error estimate of a short step is a difference of nearly equal numbers.  Its rounding, which
depends on the processor's dot product, moves the ends of the steps, and so the error within the
tolerance: by far more than the rounding of the state itself.
"""

import numpy as np
import scipy.integrate

EPS = np.finfo(float).eps
DRAWS, MARGIN = 8, 16


def spread(fun, **problem):
    """How far SciPy's solutions part when each derivative is rounded another way, with a margin."""
    expected = scipy.integrate.solve_ivp(fun, **problem)
    rng, largest = np.random.default_rng(0), 0.0

    def rounded(t, y, *args):
        f = np.asarray(fun(t, y, *args), float)
        return f * (1.0 + EPS * rng.choice([-1.0, 0.0, 1.0], f.shape))

    for _ in range(DRAWS):
        found = scipy.integrate.solve_ivp(rounded, **problem)
        assert found.y.shape == expected.y.shape  # rounding changes no number of steps here
        largest = max(largest, np.abs(found.y - expected.y).max())
    return MARGIN * largest + 64 * EPS * np.abs(expected.y).max()
