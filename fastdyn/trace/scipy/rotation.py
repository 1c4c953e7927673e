"""The stand-in of `scipy.spatial.transform.Rotation` for a single, state-dependent rotation."""

import functools
from typing import Any

import numpy as np

from ..numpy.products import matmul
from ..symbols.arrays import Array
from ..symbols.conditions import select
from ..symbols.real import symbol
from ..symbols.symbolic import graph_of, refuse

SMALL = 1e-3  # rad; for smaller angles, SciPy uses a series


def _product(p, q):
    (a, b, c, d), (x, y, z, w) = p, q
    return Array.of(
        [
            d * x + w * a + b * z - c * y,
            d * y + w * b + c * x - a * z,
            d * z + w * c + a * y - b * x,
            d * w - a * x - b * y - c * z,
        ]
    )


def _length(v) -> Any:
    return np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


def _of_no_length():
    raise ValueError("Found zero norm quaternions in `quat`.")


@functools.cache
def _nan_has_no_length():
    """Whether the installed SciPy refuses a quaternion of nan: SciPy 1.17 does, 1.15 does not."""
    from scipy.spatial import transform  # only a solve with rotations imports this module

    try:
        transform.Rotation.from_quat([np.nan] * 4)
    except ValueError:
        return True
    return False


class Rotation:
    """A rotation as a quaternion with the scalar last."""

    def __init__(self, q):
        self._q = q

    @staticmethod
    def from_quat(q, *, scalar_first=False):
        q = Array.of(q)
        if q.shape != (4,):
            refuse("several rotations at once")
        if scalar_first:
            q = Array.of([*q[1:], q[0]])
        size = np.sqrt((q * q).sum())
        if (g := graph_of(size)) is not None:
            zero = g.const(0.0)
            none = (
                g.negation(g.compare(zero, size.node, "lt"))
                if _nan_has_no_length()
                else g.compare(size.node, zero, "eq")
            )
            g.raises_if(none, _of_no_length)
        return Rotation(q / size)

    @staticmethod
    def from_rotvec(v, degrees=False):
        v = Array.of(v)
        if v.shape != (3,):
            refuse("several rotations at once")
        v = np.radians(v) if degrees else v
        angle = _length(v)
        a2 = angle * angle
        series = 0.5 - a2 / 48 + a2 * a2 / 3840
        scale = select(angle <= SMALL, series, np.sin(angle / 2) / angle)
        return Rotation(Array.of([*(v * scale), np.cos(angle / 2)]))

    @staticmethod
    def from_euler(seq, angles, degrees=False):
        angles = list(angles) if len(seq) > 1 else [angles]
        if len(angles) != len(seq) or any(np.ndim(a) for a in angles):
            refuse("several rotations at once")
        found = None
        for axis, angle in zip(seq, angles, strict=True):
            half = (np.radians(angle) if degrees else angle) / 2
            q = [0.0, 0.0, 0.0, np.cos(half)]
            q["xyz".index(axis.lower())] = np.sin(half)
            if found is None:
                found = q
            else:  # body axes (capitals) or fixed axes
                found = _product(found, q) if seq.isupper() else _product(q, found)
        return Rotation(Array.of(found))

    def __getattr__(self, name):
        refuse(f"Rotation.{name}")

    def __mul__(self, other):
        if not isinstance(other, Rotation):
            refuse("a rotation times something else")
        return Rotation(_product(self._q, other._q))

    def inv(self):
        x, y, z, w = self._q
        return Rotation(Array.of([-x, -y, -z, w]))

    def as_quat(self, canonical=False, *, scalar_first=False):
        if canonical:
            refuse("a quaternion of positive sign")
        q = self._q
        return Array.of([q[3], *q[:3]]) if scalar_first else q.copy()

    def as_matrix(self):
        x, y, z, w = self._q
        return Array.of(
            [
                [x * x - y * y - z * z + w * w, 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), -x * x + y * y - z * z + w * w, 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), -x * x - y * y + z * z + w * w],
            ]
        )

    def magnitude(self):
        return 2 * np.arctan2(_length(self._q), np.abs(self._q[3]))

    def as_rotvec(self, degrees=False):
        w = symbol(graph_of(self._q), self._q[3])
        q = self._q * select(w < 0, -1.0, 1.0)
        angle = 2 * np.arctan2(_length(q), q[3])
        a2 = angle * angle
        series = 2 + a2 / 12 + 7 * a2 * a2 / 2880
        v = q[:3] * select(angle <= SMALL, series, angle / np.sin(angle / 2))
        return np.degrees(v) if degrees else v

    def apply(self, vectors, inverse=False):
        matrix = self.as_matrix()
        matrix = matrix.T if inverse else matrix
        return matmul(matrix, vectors) if np.ndim(vectors) == 1 else matmul(vectors, matrix.T)
