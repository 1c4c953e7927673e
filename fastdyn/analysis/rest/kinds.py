"""The kind of a state by its eigenvalues, and whether the eigenvalues decide the kind.

The Jacobian at a computed equilibrium is that at a state beside the equilibrium. Where an
eigenvalue vanishes, the search ends at a state whose Jacobian is small and of any sign. And the
traced Jacobian has a value on kinks and jumps, too, where the function has no derivative.
"""

import numpy as np

ZERO = 1e-9  # of the largest eigenvalue: real parts below are rounding
ROUNDINGS = 10.0 * np.finfo(float).eps  # of a function, relative to its terms
AROUND = 0.1  # share of a component's size, by which states around are moved
DOUBT = 2.0  # factor of the doubt about an equilibrium, in which the Jacobian is looked at
SMALL = 1e-6  # of the Jacobian around: other eigenvalues that vanish with one
CHANGED = np.log(2.0)  # of the determinant, on a logarithmic scale: more, and it may vanish
DISTANCES = (1e-4, 1e-7, 1e-10)  # of a component's size, for differences to both sides
FADES = 0.3  # factor by which the error of a difference falls from one to the next, at most
SEEN = 1e-3  # of the Jacobian: the least kink


def kind_of(eigenvalues):
    """(kind of an equilibrium in words, whether it is stable or None) from its eigenvalues."""
    size = np.abs(eigenvalues).max(initial=0.0)
    real = eigenvalues.real
    turning = np.abs(eigenvalues.imag) > ZERO * size
    growing = real > ZERO * size
    decaying = real < -ZERO * size
    neither = ~(growing | decaying)
    if (np.abs(eigenvalues) <= ZERO * size).any() or size == 0.0:
        return "degenerate (an eigenvalue is zero)", False if growing.any() else None
    if growing.any() and decaying.any():
        return "saddle", False
    if growing.any() and neither.any():
        return "unstable, with undamped oscillations", False
    if neither.all():
        return "centre", None
    if neither.any():
        return "stable directions and undamped oscillations", None
    shape = "focus" if turning.any() else "node"
    return f"{'unstable' if growing.any() else 'stable'} {shape}", not growing.any()


def around(derivatives, t, y, matrix):
    """The largest size of each element of the Jacobian at a state and around, shape (n, n)."""
    size = _sizes(y)
    largest = np.abs(matrix)
    for side in (-1.0, 1.0):
        there = np.abs(derivatives.at(t, y + side * AROUND * size))
        largest = np.fmax(largest, np.where(np.isfinite(there), there, 0.0))
    return largest


def vanishing(derivatives, t, y, rates, matrix, values):
    """Which eigenvalues of the Jacobian at a computed equilibrium are zero but for its error.

    The equilibrium is known to Newton's step from there and to the rounding of the function, both
    along the singular vector of the smallest singular value. If the determinant halves or doubles
    within this distance, it vanishes at the equilibrium itself for all that is known: Newton's step
    towards a root of order m leaves (m - 1) / m of the way.
    """
    left, sizes, right = np.linalg.svd(matrix)
    if not sizes[-1] > 0.0:
        return np.abs(values) <= ZERO * np.abs(values).max(initial=0.0)
    scale = around(derivatives, t, y, matrix)
    rounding = ROUNDINGS * (scale @ np.abs(y) + derivatives.summands(t, y))
    off = np.abs(left[:, -1] @ rates) + np.abs(left[:, -1]) @ rounding
    with np.errstate(over="ignore"):
        doubt = DOUBT * (off + np.finfo(float).tiny) / sizes[-1]
    step = min(doubt, AROUND * _sizes(y).max()) * right[-1]
    sign, size = np.linalg.slogdet(matrix)
    for there in (derivatives.at(t, y + step), derivatives.at(t, y - step)):
        if np.isfinite(there).all():
            sign_there, size_there = np.linalg.slogdet(there)
            if sign_there != sign or abs(size_there - size) > CHANGED:
                least = max(np.abs(values).min(), SMALL * scale.max())
                return np.abs(values) <= 1.01 * least
    return np.zeros(len(values), bool)


def not_differentiable(equations, derivatives, t, y, matrix):
    """Which elements of the Jacobian are no derivatives, shape (n, n).

    A difference to one side approaches the derivative as its distance falls. On a kink it stays
    off, on a jump it grows.
    """
    rates = equations.rates(t, y)
    size = _sizes(y)
    scale = around(derivatives, t, y, matrix)
    off = np.zeros((len(DISTANCES), *matrix.shape))
    for k, distance in enumerate(DISTANCES):
        for j, step in enumerate(distance * size):
            for side in (step, -step):
                moved = y.copy()
                moved[j] += side
                there = _rates(equations, t, moved)
                slopes = (there - rates) / (moved[j] - y[j])
                apart = np.abs(slopes - matrix[:, j])
                off[k, :, j] = np.fmax(off[k, :, j], np.where(np.isfinite(apart), apart, 0.0))
    terms = np.abs(rates) + scale @ np.abs(y) + derivatives.summands(t, y)
    noise = [ROUNDINGS * terms[:, None] / (distance * size) for distance in DISTANCES]
    seen = off[0] > SEEN * scale.max(axis=1)[:, None] + noise[0]
    for near, far, rough in zip(off[1:], off[:-1], noise[1:], strict=True):
        seen &= (near > FADES * far) | (rough > FADES * far)
    return seen


def _sizes(y):
    return np.maximum(np.abs(y), AROUND)


def _rates(equations, t, y):
    """Rates at a state; NaN outside of the domain of the function."""
    with np.errstate(all="ignore"):
        try:
            return equations.rates(t, y)
        except (ArithmeticError, ValueError):
            return np.full(len(y), np.nan)
