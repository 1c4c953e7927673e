"""All components of y along a solution of the reduced state, at many times at once."""

import numpy as np

from .formulas import NEWTON

MANY = 4096  # times that are evaluated at once


def places(reduced):
    """The place of each component of the reduced state among all orders of all components."""
    given = reduced.given
    return [order * given.n + given.columns[j] for j, order in reduced.states]


def components(reduced, t, x, depths=()):
    """All components of y, shape (n, k), from reduced states of shape (m, k).

    What follows from the states of `depths` is computed from the constraints.
    """
    t = np.asarray(t, float)
    if len(t) > MANY:
        parts = [slice(k, k + MANY) for k in range(0, len(t), MANY)]
        found = [components(reduced, t[part], x[:, part], depths) for part in parts]
        return np.concatenate(found, axis=1)
    given, (c, d) = reduced.given, reduced.offsets
    z = np.zeros(((reduced.levels() + 1) * given.n, len(t)))
    z[places(reduced)] = x
    for i, depth in enumerate(depths):
        m = len(depths) - i
        at = [given.columns[j] + (d[j] - m) * given.n for j in depth.follow]
        nodes = [reduced.orders[row][c[row] - m] for row in depth.rows]
        for _ in range(NEWTON):
            matrix = reduced.matrices(t, z)[:, depth.rows][:, :, depth.follow]
            z[at] -= _solved(matrix, reduced.numbers(nodes, t, z))
    highest = [int(d[j]) * given.n + column for j, column in enumerate(given.columns)]
    z[highest] = -_solved(reduced.matrices(t, z), reduced.numbers(reduced.rest, t, z))
    at = [given.place(k) for k in range(given.n)]
    return z[[order * given.n + column for column, order in at]]


def _solved(matrices, right):
    """Solutions (n, k) of k systems; nan where a matrix is singular."""
    try:
        return np.linalg.solve(matrices, right.T[:, :, None])[:, :, 0].T
    except np.linalg.LinAlgError:
        found = np.full(right.shape, np.nan)
        for i, (matrix, b) in enumerate(zip(matrices, right.T, strict=True)):
            try:
                found[:, i] = np.linalg.solve(matrix, b)
            except np.linalg.LinAlgError:
                continue
        return found


class Solution:
    """The continuous solution of y: ``sol(t)`` has shape (n,), or (n, k) for k times.

    Parameters
    ----------
    reduced : Differentiated
    pieces : list of (OdeSolution, float, depths)
        The solutions of the reduced state, one for each choice of states, in order, and the times
        up to which they count.
    """

    def __init__(self, reduced, pieces):
        self._reduced, self._pieces = reduced, pieces
        self._ends = np.array([end for _, end, _ in pieces])
        first, last = pieces[0][0].ts[0], pieces[-1][0].ts[-1]
        self._sign = 1.0 if last >= first else -1.0
        self.t_min, self.t_max = min(first, last), max(first, last)

    def __call__(self, t):
        t = np.asarray(t, float)
        if t.ndim > 1:
            raise ValueError("`t` must be a float or a 1-D array.")
        times = np.atleast_1d(t)
        of = np.searchsorted(self._sign * self._ends[:-1], self._sign * times)
        y = np.empty((self._reduced.given.n, len(times)))
        for i in np.unique(of):
            (piece, _, depths), here = self._pieces[i], of == i
            y[:, here] = components(self._reduced, times[here], piece(times[here]), depths)
        return y[:, 0] if t.ndim == 0 else y
