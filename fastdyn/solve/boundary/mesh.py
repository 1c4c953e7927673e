"""One mesh of a boundary value problem: the memory of the kernels, splines, and finer meshes.

The method and its decisions are those of `scipy.integrate.solve_bvp`, after J. Kierzenka and L. F.
Shampine, "A BVP solver based on residual control and the MATLAB PSE", ACM Trans. Math. Softw. 27
(2001).
"""

import numpy as np
from scipy.interpolate import PPoly

from fastdyn.code_store import Call
from fastdyn.kernels.stepping import collocation
from fastdyn.specialise.scalar import newton_kernel, residuals_kernel

from .functions import longer


class RaisedOnMesh(Exception):
    """A function raised."""


def room_of(m, n, k):
    """The numbers of an iteration on m nodes, for n components and k parameters."""
    size = n + k
    both = 2 * n + k
    unit = longer(np.zeros(size))
    units = longer(np.zeros(both))
    return collocation.Room(
        np.empty(size), np.empty(size), unit, np.empty(len(unit)),
        np.empty(both), np.empty(both), units, np.empty(len(units)),
        np.empty((m, n)), *[np.empty((m - 1, n)) for _ in range(3)],
        np.empty((m, n, size)), np.empty((m - 1, n, size)), np.empty((m - 1, n, both)),
        np.empty((m - 1, 2 * n + 1, n + both)),
        np.empty(both * both), np.empty(both, np.int64), np.empty(both),
        np.empty((m, n)), np.empty(k), np.empty((m, n)), np.empty(k), np.empty((m, n)), np.empty(k),
    )  # fmt: skip


class Solved:
    """The solution of the equations on a mesh by `functions`, `collocation.Functions`.

    Attributes
    ----------
    singular : bool
        Whether a linear system was singular.
    y, f, p, sol
        States and slopes at the nodes, of shape (n, m), parameters, and the cubic spline.
    bc, rms : ndarray
        The boundary conditions, and the root mean squares of the residuals of the intervals.
    """

    def __init__(self, functions, x, y, p, tol, bc_tol):
        n, m = y.shape
        room = room_of(m, n, len(p))
        mesh = collocation.Mesh(x, np.array(y.T, order="C"), p.copy())
        status = Call(newton_kernel(), *functions, *mesh, *room, tol, bc_tol)()
        self.rms = np.empty(m - 1)
        again = Call(residuals_kernel(), *functions, *mesh, *room, self.rms)()
        if collocation.RAISED in (status, again):
            raise RaisedOnMesh
        self.singular = status == collocation.SINGULAR
        self.x = x
        self.y = mesh.y.T
        self.f = room.f.T
        self.p = mesh.p
        self.bc, self.sol = room.conditions[: n + len(p)], self._spline()

    def _spline(self):
        y = self.y
        f = self.f
        h = np.diff(self.x)
        slope = (y[:, 1:] - y[:, :-1]) / h
        bend = (f[:, :-1] + f[:, 1:] - 2 * slope) / h
        parts = [bend / h, (slope - f[:, :-1]) / h - bend, f[:, :-1], y[:, :-1]]
        return PPoly(np.moveaxis(np.array(parts), 1, 0), self.x, extrapolate=True, axis=1)


def finer(x, once, twice):
    """The mesh with one more node in the intervals `once`, and two in the intervals `twice`."""
    return np.sort(np.concatenate([
        x, 0.5 * (x[once] + x[once + 1]),
        (2 * x[twice] + x[twice + 1]) / 3, (x[twice] + 2 * x[twice + 1]) / 3,
    ]))  # fmt: skip
