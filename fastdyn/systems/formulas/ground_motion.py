"""The motion of the ground between samples, as cubic polynomials."""

import numpy as np


def pieces(times, displacements=None, accelerations=None):
    """
    Coefficients of the motion between samples that straight lines join, shape (n_samples - 1, 4).

    They are those of 1, s, s², s³, with s the time since the sample before. Samples are either
    displacements or accelerations, which are integrated from rest at height 0.
    """
    if (displacements is None) == (accelerations is None):
        raise ValueError("give the samples of the ground as `displacements` or `accelerations`.")
    t = np.asarray(times, float)
    samples = np.asarray(accelerations if displacements is None else displacements, float)
    if t.ndim != 1 or samples.shape != t.shape or len(t) < 2:
        raise ValueError(
            f"the ground needs at least two times and as many samples; got {t.shape} and "
            f"{samples.shape}."
        )
    checked_times(t)
    h = np.diff(t)
    slope = np.diff(samples) / h
    if displacements is not None:
        zero = np.zeros_like(h)
        return np.column_stack([samples[:-1], slope, zero, zero])
    a = samples[:-1]
    speed = np.concatenate([[0.0], np.cumsum(h * (a + 0.5 * h * slope))])
    path = speed[:-1] * h + h**2 * (0.5 * a + h * slope / 6.0)
    height = np.concatenate([[0.0], np.cumsum(path)])
    return np.column_stack([height[:-1], speed[:-1], 0.5 * a, slope / 6.0])


def checked_times(t):
    """Refuse times that do not increase."""
    if not (np.isfinite(t).all() and (np.diff(t) > 0.0).all()):
        raise ValueError("the times of the samples must be finite and increase.")


def checked(times, coefficients):
    """Times and pieces as arrays; refuses what makes no motion."""
    times = np.array(times, float)
    coefficients = np.array(coefficients, float)
    if times.ndim != 1 or len(times) < 2 or coefficients.shape != (len(times) - 1, 4):
        raise ValueError(
            f"`pieces` must have a row of 4 between each two of the `times`; their shapes are "
            f"{coefficients.shape} and {times.shape}."
        )
    checked_times(times)
    if not np.isfinite(coefficients).all():
        raise ValueError("the samples of the ground must be finite.")
    return times, coefficients


def height(t, times, coefficients):
    """Height of the ground at time t; before and after the samples it stands still."""
    i = np.searchsorted(times, t, side="right") - 1
    i = min(max(i, 0), len(times) - 2)
    s = min(max(t, times[0]), times[-1]) - times[i]
    return coefficients[i, 0] + s * (
        coefficients[i, 1] + s * (coefficients[i, 2] + s * coefficients[i, 3])
    )
