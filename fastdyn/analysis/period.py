"""The period of equations that depend on the time: f(t + period, y) = f(t, y)."""

import numpy as np

LOOKS = 64  # pairs of time and state, one in each 64th of a period, at which rates are compared
SAME = 1e-8  # rates that differ by more, relative to the largest rate, are different
STATES = 5  # the first is the state that was given


def looks(t0, y, period):
    """Pairs (time, state) at which the rates are compared."""
    rng = np.random.default_rng(0)
    size = 0.3 * np.maximum(np.abs(y), 0.1)
    states = [y, *(y + size * rng.standard_normal((STATES - 1, len(y))))]
    times = t0 + period * (rng.permutation(LOOKS) + rng.random(LOOKS)) / LOOKS
    return [(float(t), states[k % STATES]) for k, t in enumerate(times)]


def check_period(equations, t0, y, period, advice=""):
    """Refuse a period that the equations do not have.

    Raises
    ------
    ValueError
        With a time at which f(t + period, y) is not f(t, y), and the advice.
    """
    found = []
    for t, state in looks(t0, y, period):
        with np.errstate(all="ignore"):
            try:
                found.append((t, equations.rates(t, state), equations.rates(t + period, state)))
            except (ArithmeticError, ValueError):
                continue  # outside of the domain of `fun`
    if not found:
        return
    times = [t for t, _, _ in found]
    now, later = (np.array([each[k] for each in found]) for k in (1, 2))
    size = np.fmax(np.abs(now), np.abs(later))
    off = np.abs(now - later) > SAME * np.fmax.reduce(np.where(np.isfinite(size), size, 0.0))
    if off.any():
        k, i = np.argwhere(off)[0]
        raise ValueError(
            f"`fun` does not have the period {period:.10g}: component {i} of its rates is "
            f"{now[k, i]:.6g} at t = {times[k]:.6g}, and {later[k, i]:.6g} a period later, at the "
            f"same state. {advice}".rstrip()
        )
