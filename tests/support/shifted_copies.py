"""Exact references of delay equations whose delays are multiples of one time, by SciPy.

On interval k of that length, the solution and its k shifted copies are an ordinary equation.
"""

import numpy as np
from scipy.integrate import solve_ivp


def end_of(fun, history, unit, shifts, n_intervals, args=()):
    """The end of ``y' = fun(t, y, [y(t - unit m) for m in shifts])`` after `n_intervals` units."""
    n = len(history(0.0))
    known = [history(0.0)]  # at the starts of the intervals
    for k in range(n_intervals):

        def copies(s, z, k=k):
            z = z.reshape(k + 1, n)
            slopes = []
            for j in range(k + 1):
                past = [z[j - m] if j >= m else history(s + (j - m) * unit) for m in shifts]
                slopes.append(fun(s + j * unit, z[j], past, *args))
            return np.ravel(slopes)

        found = solve_ivp(copies, (0, unit), np.ravel(known), "DOP853", rtol=3e-14, atol=1e-15)
        known.append(found.y[-n:, -1])
    return known[-1]
