"""The choice of dummy derivatives, by the matrix at the present point.

S. E. Mattsson, G. Söderlind, "Index reduction in differential-algebraic equations using dummy
derivatives", SIAM J. Sci. Comput. 14 (1993) 677.  At depth m, the equations with c_i >= m, each
differentiated c_i - m times, determine as many components in the order d_j - m: these follow from
the others, and their derivatives are no longer derivatives of a state.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import qr

SINGULAR = 1e-11  # smallest pivot of a matrix whose rows have the size 1


class Depth(NamedTuple):
    """The equations of one depth, the positions that follow from them, and the other positions."""

    rows: tuple
    follow: tuple
    free: tuple


def choice(offsets, matrix):
    """The Depths, the deepest first, so that few dependents change much with the states.

    Raises
    ------
    ZeroDivisionError
        If the matrix is singular at this point.
    """
    depths = []
    columns = np.arange(len(matrix))
    for m in range(1, int(offsets.equations.max(initial=0)) + 1):
        rows = np.flatnonzero(offsets.equations >= m)
        columns = columns[offsets.components[columns] >= m]
        part = matrix[np.ix_(rows, columns)]
        part = part / np.maximum(np.abs(part).max(axis=1, keepdims=True), np.finfo(float).tiny)
        factors: Any = qr(part, mode="economic", pivoting=True)
        _, r, order = factors
        if not abs(np.diag(r)).min() > SINGULAR:
            raise ZeroDivisionError
        follow = np.sort(columns[order[: len(rows)]])
        free = np.setdiff1d(np.flatnonzero(offsets.components >= m), follow)
        depths.append(Depth(*[tuple(map(int, each)) for each in (rows, follow, free)]))
        columns = follow
    return tuple(reversed(depths))


def states(reduced, depths):
    """The states, (position, order): the reduced state without what follows from it."""
    d = reduced.offsets.components
    follow = {
        (j, int(d[j]) - len(depths) + i) for i, depth in enumerate(depths) for j in depth.follow
    }
    return [place for place in reduced.states if place not in follow]


def growth(matrices, depths):
    """The sums of squares by which what follows changes with the states, at k points."""
    total = np.zeros(len(matrices))
    for depth in depths:
        rows = matrices[:, depth.rows]
        with np.errstate(all="ignore"):
            try:
                slopes = np.linalg.solve(rows[:, :, depth.follow], rows[:, :, depth.free])
            except np.linalg.LinAlgError:
                slopes = np.linalg.pinv(rows[:, :, depth.follow]) @ rows[:, :, depth.free]
            total += (slopes**2).sum(axis=(1, 2))
    return total


def signs(matrices, depths):
    """The signs of the determinants that tell whether the states determine what follows.

    Shape (1 + number of depths, k); the first is of the whole matrix.
    """
    parts = [matrices, *(matrices[:, d.rows][:, :, d.follow] for d in depths)]
    return np.array([np.linalg.slogdet(part)[0] for part in parts])
