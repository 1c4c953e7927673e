"""All components of y along a solution of the reduced state, at many times at once."""

import numpy as np

from ..structure.formulas import NEWTON, constraints

MANY = 4096  # times that are evaluated at once


def places(reduced):
    """The place of each component of the reduced state among all orders of all components."""
    given = reduced.given
    return [order * given.n + given.columns[j] for j, order in reduced.states]


def components(reduced, t, x, project=False, rates=False):
    """All components of y, shape (n, k), from reduced states of shape (m, k).

    With `rates` their derivatives, which are nan where the equations have none.
    """
    t = np.asarray(t, float)
    if not len(t):
        return np.zeros((reduced.given.n, 0))
    if len(t) > MANY:
        parts = [slice(k, k + MANY) for k in range(0, len(t), MANY)]
        found = [components(reduced, t[part], x[:, part], project, rates) for part in parts]
        return np.concatenate(found, axis=1)
    z = orders(reduced, x)
    if project:
        projected(reduced, t, z)
    complete(reduced, t, z)
    given = reduced.given
    d = reduced.offsets.components
    at = [given.place(k) for k in range(given.n)]
    found = z[[(order + rates) * given.n + column for column, order in at]]
    known = dict(zip(given.columns, d, strict=True))
    found[[order + rates > known[column] for column, order in at]] = np.nan
    return found


def orders(reduced, x):
    """All orders of all components from the reduced state; what is not in the state is zero."""
    z = np.zeros(((reduced.levels() + 1) * reduced.given.n, *x.shape[1:]))
    z[places(reduced)] = x
    return z


def complete(reduced, t, z):
    """Compute the highest orders in z, which are linear in the equations."""
    given = reduced.given
    d = reduced.offsets.components
    highest = [int(d[j]) * given.n + column for j, column in enumerate(given.columns)]
    z[highest] = -_solved(reduced.matrices(t, z), reduced.numbers(reduced.rest, t, z))


def projected(reduced, t, z):
    """Change z to satisfy the constraints: see `formulas.projection`."""
    given = reduced.given
    d = reduced.offsets.components
    for m, rows, columns, linear in constraints(reduced):
        at = [given.columns[j] + (int(d[j]) - m) * given.n for j in columns]
        nodes = [reduced.residual(row, m) for row in rows]
        for _ in range(1 if linear else NEWTON):
            matrix = reduced.matrices(t, z)[:, rows][:, :, columns]
            turned = matrix.transpose(0, 2, 1)
            factors = _solved(matrix @ turned, reduced.numbers(nodes, t, z))
            z[at] -= (turned @ factors.T[:, :, None])[:, :, 0].T


def _solved(matrices, right):
    """Solutions (n, k) of k systems; nan where a matrix is singular."""
    return solved(matrices, right.T[:, :, None])[:, :, 0].T


def solved(matrices, right):
    """Solutions of k systems with m right-hand sides; nan where a matrix is singular."""
    try:
        return np.linalg.solve(matrices, right)
    except np.linalg.LinAlgError:
        found = np.full(right.shape, np.nan)
        for i, (matrix, b) in enumerate(zip(matrices, right, strict=True)):
            try:
                found[i] = np.linalg.solve(matrix, b)
            except np.linalg.LinAlgError:
                continue
        return found


class ReducedSolution:
    """The continuous solution of y: ``sol(t)`` has shape (n,), or (n, k) for k times.

    Parameters
    ----------
    reduced : Differentiated
    states : OdeSolution
        The solution of the reduced state.
    before : callable
        The times at which the equations hold, for those of the states: before a breakpoint.
    """

    def __init__(self, reduced, states, before):
        self._reduced = reduced
        self._states = states
        self._before = before
        self.t_min = states.t_min
        self.t_max = states.t_max

    def __call__(self, t):
        t = np.asarray(t, float)
        x = self._states(np.atleast_1d(t))
        y = components(self._reduced, self._before(np.atleast_1d(t)), x, project=True)
        return y[:, 0] if t.ndim == 0 else y
