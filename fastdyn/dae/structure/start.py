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
    """All orders of all components: those that y0 and yp0, (n,) or (n, k), give, and zeros."""
    given = reduced.given
    z = np.zeros((reduced.levels() + 1, *np.shape(y0)))
    z[0] = y0
    z[1] = yp0
    for k, (column, order) in given.alias.items():
        z[order, column] = y0[k]
        z[order + 1, column] = yp0[k]
    for k, (column, order) in given.alias.items():
        z[0, k], z[1, k] = z[order, column], z[order + 1, column]
    return z.reshape(-1, *z.shape[2:])


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
    found, errors = consistent_all(reduced, t, z[:, None], held)
    for error in errors.values():
        raise error
    return found[:, 0]


def consistent_all(reduced, t, z, held=None):
    """(Many guesses z as by `consistent`, shape (size, k); the Unsolved of each without a start).

    The parameters of `reduced` have shape (n_slots,), or (n_slots, k).
    """
    first = z
    z = z.copy()
    errors = {}
    times = np.full(z.shape[1], float(t))
    d = reduced.offsets.components
    with np.errstate(all="ignore"):
        for m, rows, columns, _ in constraints(reduced):
            free = [j for j in columns if reduced.name(j, d[j] - m) not in (held or ())]
            _depth(reduced, times, z, rows, free, m, held or (), errors)
        _highest(reduced, times, z, errors)
    if held is None:
        _check_near(reduced, first, z, errors)
    return z, errors


def _of(reduced, points):
    """The equations with the parameters of some points."""
    values = reduced.given.values
    return reduced if np.ndim(values) == 1 else reduced.with_values(values[:, points])


def _depth(reduced, t, z, rows, free, m, held, errors):
    """Solve the constraints of one depth for the positions `free`."""
    d = reduced.offsets.components
    nodes = [reduced.residual(i, m) for i in rows]
    places = [reduced.given.columns[j] + (d[j] - m) * reduced.given.n for j in free]
    left = np.array([k for k in range(len(t)) if k not in errors], int)
    change = np.full(len(t), np.inf)
    names = sorted(reduced.given.rows[i] for i in rows)
    for _ in range(MOST):
        left = left[change[left] > CLOSE * (1 + np.abs(z[places][:, left]).max(axis=0, initial=0))]
        if not len(left):
            return
        own = _of(reduced, left)
        residuals = own.numbers(nodes, t[left], z[:, left]).T
        matrices = own.matrices(t[left], z[:, left])[:, rows][:, :, free]
        finite = np.isfinite(residuals).all(axis=1) & np.isfinite(matrices).all(axis=(1, 2))
        for k in left[~finite]:
            errors[int(k)] = _nowhere(names)
        left = left[finite]
        residuals = residuals[finite]
        matrices = matrices[finite]
        for k, residual, matrix in zip(left.tolist(), residuals, matrices, strict=True):
            step = np.linalg.lstsq(matrix, residual, rcond=LOST)[0] if free else np.zeros(0)
            z[places, k] -= step
            change[k] = np.abs(step).max(initial=0)
            far = np.abs(residual - matrix @ step).max(initial=0) > 1e-8 * np.abs(residual).max()
            if far and np.abs(residual).max() > CLOSE * (1 + np.abs(z[:, k]).max()):
                errors[k] = Unsolved(
                    f"no start satisfies the constraints of equations {_listed(names)}"
                    + (f" with the components {_listed(sorted(held))} held" if held else "")
                    + ": their derivatives by the components that may move are singular there."
                )
        left = np.array([k for k in left.tolist() if k not in errors], int)
    for k in left.tolist():
        errors[k] = _nowhere(names)


def _nowhere(names):
    return Unsolved(
        f"Newton's method finds no start that satisfies equations {_listed(names)} near the "
        "guess: give a y0 that is nearer."
    )


def _highest(reduced, t, z, errors):
    """Compute the highest orders, which are linear in the equations."""
    given = reduced.given
    d = reduced.offsets.components
    left = np.array([k for k in range(len(t)) if k not in errors], int)
    if not len(left):
        return
    own = _of(reduced, left)
    at = z[:, left]
    matrices = own.matrices(t[left], at)
    rest = own.numbers(own.rest, t[left], at)
    places = [int(d[j]) * given.n + column for j, column in enumerate(given.columns)]
    for k, matrix, right in zip(left.tolist(), matrices, rest.T, strict=True):
        try:
            check_regular(reduced, t[k], matrix)
        except Unsolved as error:
            errors[k] = error
        else:
            z[places, k] = np.linalg.solve(matrix, -right)


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


def _check_near(reduced, first, z, errors):
    """Note an Unsolved where components that are states by themselves have moved far."""
    d = reduced.offsets.components
    extra = reduced.extra
    given = reduced.given
    checked = []
    for j, order in reduced.states:
        name = reduced.name(j, order)
        if name is not None and order < d[j] - extra:
            checked.append((name, order * given.n + given.columns[j]))
    if not checked:
        return
    names, places = map(list, zip(*checked, strict=True))
    moved = np.abs(z - first)[places]
    size = np.maximum(np.abs(z[places]).max(axis=0), np.abs(first[places]).max(axis=0))
    for k in np.flatnonzero(moved.max(axis=0) > MOVED * size).tolist():
        if k in errors:
            continue
        worst = int(moved[:, k].argmax())
        errors[k] = Unsolved(
            f"y0 violates the constraints: to satisfy them, component {names[worst]} would move "
            f"from {first[places[worst], k]:.6g} to {z[places[worst], k]:.6g}. Give another y0, or "
            "the components to be held as `given`, and the others move."
        )


def _listed(numbers):
    return ", ".join(str(int(number)) for number in numbers)
