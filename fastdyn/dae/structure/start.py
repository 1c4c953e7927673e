"""Consistent starts: the state nearest to a guess that satisfies all constraints, hidden ones too.

The constraints of one depth (see `choice`) are solved by the method of Gauss and Newton for the
derivatives of one order; constraints on velocities follow those on positions.
"""

import numpy as np
from scipy.linalg import svd

from .formulas import constraints

MOST = 50  # iterations
CLOSE = 1e-13  # a change so small, in the largest number, ends the iteration
MOVED = 1e-3  # so far may a component given by the user move, in the largest of them
LOST = 1e-10  # singular values below, in the largest, are zero
SEEN = 0.3  # entries of a null vector above, in the largest, are named


class Unsolved(ValueError):
    """A start that cannot be made consistent."""


def guess(reduced, y0, yp0):
    """All orders of all components: those that y0 and yp0 give, and zeros."""
    given = reduced.given
    z = np.zeros((reduced.levels() + 1, given.n))
    z[0], z[1] = y0, yp0
    for k, (column, order) in given.alias.items():
        z[order, column] = y0[k]
        z[order + 1, column] = yp0[k]
    for k, (column, order) in given.alias.items():
        z[0, k], z[1, k] = z[order, column], z[order + 1, column]
    return z.ravel()


def consistent(reduced, t, z, held=None):
    """The guess z with all constraints solved, and with the highest orders computed.

    Parameters
    ----------
    held : collection of int, optional
        The components of y that keep their values, while the others may move far; by default none
        may move far.

    Raises
    ------
    Unsolved
    """
    first, z = z, z.copy()
    t = np.array([float(t)])
    d = reduced.offsets.components
    for m, rows, columns, _ in constraints(reduced):
        free = [j for j in columns if reduced.name(j, d[j] - m) not in (held or ())]
        _depth(reduced, t, z, rows, free, m, held or ())
    _highest(reduced, t, z)
    if held is None:
        _check_near(reduced, first, z)
    return z


def _depth(reduced, t, z, rows, free, m, held):
    """Solve the constraints of one depth for the positions `free`."""
    d = reduced.offsets.components
    nodes = [reduced.residual(i, m) for i in rows]
    places = [reduced.given.columns[j] + (d[j] - m) * reduced.given.n for j in free]
    change = np.inf
    for _ in range(MOST):
        residual = reduced.numbers(nodes, t, z[:, None])[:, 0]
        if change <= CLOSE * (1 + np.abs(z[places]).max(initial=0)):
            return
        matrix = reduced.matrices(t, z[:, None])[0][np.ix_(rows, free)]
        if not (np.isfinite(residual).all() and np.isfinite(matrix).all()):
            break
        step = np.linalg.lstsq(matrix, residual, rcond=LOST)[0] if free else np.zeros(0)
        z[places] -= step
        change = np.abs(step).max(initial=0)
        far = np.abs(residual - matrix @ step).max(initial=0) > 1e-8 * np.abs(residual).max()
        if far and np.abs(residual).max() > CLOSE * _size(reduced, z):
            names = sorted(reduced.given.rows[i] for i in rows)
            raise Unsolved(
                f"no start satisfies the constraints of equations {_listed(names)}"
                + (f" with the components {_listed(sorted(held))} held" if held else "")
                + ": their derivatives by the components that may move are singular there."
            )
    names = sorted(reduced.given.rows[i] for i in rows)
    raise Unsolved(
        f"Newton's method finds no start that satisfies equations {_listed(names)} near the "
        "guess: give a y0 that is nearer."
    )


def _size(reduced, z):
    return 1 + np.abs(z).max()


def _highest(reduced, t, z):
    """Compute the highest orders, which are linear in the equations."""
    given, d = reduced.given, reduced.offsets.components
    matrix = reduced.matrices(t, z[:, None])[0]
    check_regular(reduced, t[0], matrix)
    places = [int(d[j]) * given.n + column for j, column in enumerate(given.columns)]
    z[places] = np.linalg.solve(matrix, -reduced.numbers(reduced.rest, t, z[:, None])[:, 0])


def check_regular(reduced, t, matrix):
    """Raise Unsolved, with equations and components, where the matrix is singular."""
    if not np.isfinite(matrix).all():
        rows = sorted({reduced.given.rows[i] for i in np.argwhere(~np.isfinite(matrix))[:, 0]})
        raise Unsolved(f"the derivatives of equations {_listed(rows)} are infinite at t = {t:.6g}.")
    if not len(matrix):
        return
    scale = np.abs(matrix).max(axis=1, keepdims=True)
    u, sizes, v = svd(matrix / np.where(scale == 0, 1.0, scale))
    if sizes[-1] > LOST * sizes[0]:
        return
    rows = sorted(reduced.given.rows[i] for i in _large(u[:, -1]))
    columns = sorted(reduced.given.columns[j] for j in _large(v[-1]))
    raise Unsolved(
        f"the system is singular at t = {t:.6g}, though its structure is regular: equations "
        f"{_listed(rows)} do not determine the components {_listed(columns)} there. Are equations "
        "redundant, or is the index higher at this point?"
    )


def _large(vector):
    return np.flatnonzero(np.abs(vector) > SEEN * np.abs(vector).max())


def _check_near(reduced, first, z):
    """Raise Unsolved if components that are states by themselves have moved far."""
    d, extra, given = reduced.offsets.components, reduced.extra, reduced.given
    checked = []
    for j, order in reduced.states:
        name = reduced.name(j, order)
        if name is not None and order < d[j] - extra:
            checked.append((name, order * given.n + given.columns[j]))
    if not checked:
        return
    names, places = map(list, zip(*checked, strict=True))
    moved = np.abs(z - first)[places]
    worst = int(moved.argmax())
    if moved[worst] > MOVED * max(np.abs(z[places]).max(), np.abs(first[places]).max()):
        raise Unsolved(
            f"y0 violates the constraints: to satisfy them, component {names[worst]} would move "
            f"from {first[places[worst]]:.6g} to {z[places[worst]]:.6g}. Give another y0, or "
            "the components to be held as `given`, and the others move."
        )


def _listed(numbers):
    return ", ".join(str(int(number)) for number in numbers)
