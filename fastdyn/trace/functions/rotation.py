"""The stand-in of `scipy.spatial.transform.Rotation` for a single, state-dependent rotation."""

from typing import Any

import numpy as np

from ..symbols.symbol import refuse
from .arrays import array_of


class Rotation:
    """A rotation by its matrix, and by its quaternion with the scalar last, if that is known."""

    def __init__(self, matrix: Any, q: Any = None):
        self._matrix = matrix
        self._q = q

    def __getattr__(self, name):
        refuse(f"Rotation.{name}")

    def inv(self):
        return Rotation(self._matrix.T, None if self._q is None else self._q * [-1, -1, -1, 1])

    def as_quat(self):
        return refuse("Rotation.as_quat") if self._q is None else self._q.copy()

    def as_matrix(self):
        return self._matrix.copy()

    def apply(self, vectors, inverse=False):
        return array_of(vectors) @ (self._matrix if inverse else self._matrix.T)


class Rotations:
    """The class `Rotation` in a traced function."""

    def __getattr__(self, name):
        refuse(f"Rotation.{name}")

    def from_quat(self, q: Any):
        q = array_of(q)
        if q.ids.shape != (4,):
            refuse("several rotations at once")
        g = q.g
        size = np.sqrt(np.sum(q * q))
        # versions of SciPy differ in what NaN gives
        g.leaves_to_python_if(g.map("not", g.map("lt", g.const(0.0).key, size.ids)))
        x, y, z, w = q = q / size
        matrix = [
            [x * x - y * y - z * z + w * w, 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), -x * x + y * y - z * z + w * w, 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), -x * x - y * y + z * z + w * w],
        ]
        return Rotation(array_of(matrix), q)

    def from_euler(self, seq, angles):
        matrix: Any = array_of(np.eye(3))
        for axis, angle in zip(seq, array_of(angles), strict=True):
            j, k = [(1, 2), (2, 0), (0, 1)]["xyz".index(axis.lower())]
            turn = array_of(np.eye(3))
            c = np.cos(angle)
            s = np.sin(angle)
            turn[j, j] = c
            turn[j, k] = -s
            turn[k, j] = s
            turn[k, k] = c
            matrix = matrix @ turn if seq.isupper() else turn @ matrix  # body or fixed axes
        return Rotation(matrix)
