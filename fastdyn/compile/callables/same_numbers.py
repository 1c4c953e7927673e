"""Compares results up to rounding, and writes results into sentences."""

import numpy as np

TOLERANCE, CANCELLED = 1e-9, 1e-12
CLOSE = 1e-6  # largest error by cancellation around the start, relative to the largest number


def all_close(real, mine):
    """Whether all results are finite and differ by rounding at most: a fast, sufficient check."""
    if len({value.shape for value in (*real, *mine)}) > 1:
        return False
    real = np.array(real)
    with np.errstate(all="ignore"):
        return bool((np.abs(np.array(mine) - real) <= TOLERANCE * np.abs(real)).all())


def are_close(real, mine):
    """Whether arrays are close, relative to the largest number, and finite at the same places."""
    finite = np.isfinite(real)
    far = np.abs(real - mine)[finite] > CLOSE * np.max(np.abs(real[finite]), initial=0.0)
    return np.array_equal(finite, np.isfinite(mine)) and not far.any()


def differ(real, mine, largest=0.0, of_solution=True):
    """Whether two results differ by more than rounding.

    `largest` is the largest size of a result along the solution; a difference of the size of the
    rounding errors of `largest` is allowed.  Away from a solution (`of_solution` False), any two
    non-finite numbers agree.
    """
    if np.array_equal(real, mine, equal_nan=True):
        return False
    finite = np.isfinite(real) & np.isfinite(mine)
    if of_solution:
        odd = ~finite & (real != mine) & ~(np.isnan(real) & np.isnan(mine))
    else:
        odd = np.isfinite(real) != np.isfinite(mine)
    if odd.any():
        return True
    real, mine = real[finite], mine[finite]
    scale = np.maximum(np.abs(real), 1e-3 * np.max(np.abs(real), initial=0.0))
    allowed = np.maximum(TOLERANCE * scale, CANCELLED * largest) + 1e-300
    return bool(np.any(np.abs(real - mine) > allowed))


def short(value):
    """A value, or an exception, as text for a sentence."""
    if isinstance(value, Exception | str):
        return value if isinstance(value, str) else f"{type(value).__name__}: {value}"
    return np.array2string(np.asarray(value), precision=12, threshold=8, edgeitems=3)
