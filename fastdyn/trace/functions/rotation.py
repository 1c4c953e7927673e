"""The stand-in of `scipy.spatial.transform.Rotation` for a single, state-dependent rotation."""

import math
from typing import Any

import numpy as np

from ..symbols.symbol import refuse
from .arrays import array_of

SMALL = 1e-3  # SciPy takes series for smaller angles
LOCKED = 1e-7  # SciPy warns where the second of Euler's angles is nearer to its limits


class Rotation:
    """A rotation by its quaternion of length 1, with the scalar last."""

    def __init__(self, q: Any):
        self._q = q

    def __getattr__(self, name):
        refuse(f"Rotation.{name}")

    def __mul__(self, other):
        if type(other) is not Rotation:
            refuse("a product of a Rotation and another object")
        return Rotation(_normed(_product(self._q, other._q)))

    def inv(self):
        return Rotation(self._q * [-1, -1, -1, 1])

    def as_quat(self, canonical=False, *, scalar_first=False):
        q = self._canonical() if canonical else self._q
        return np.roll(q, 1) if scalar_first else q.copy()

    def _canonical(self):
        """That of two quaternions, q and -q, whose scalar, or first component, is positive."""
        negative: Any = False
        for component in (self._q[2], self._q[1], self._q[0], self._q[3]):
            negative = (component < 0) | ((component == 0) & negative)
        return np.where(negative, -self._q, self._q)

    def as_matrix(self):
        x, y, z, w = self._q
        return array_of([
            [x * x - y * y - z * z + w * w, 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), -x * x + y * y - z * z + w * w, 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), -x * x - y * y + z * z + w * w],
        ])  # fmt: skip

    def apply(self, vectors, inverse=False):
        matrix = self.as_matrix()
        return array_of(vectors) @ (matrix if inverse else matrix.T)

    def magnitude(self):
        return 2 * np.arctan2(np.sqrt(np.sum(self._q[:3] ** 2)), np.abs(self._q[3]))

    def as_rotvec(self, degrees=False):
        q = self._canonical()
        angle = 2 * np.arctan2(np.sqrt(np.sum(q[:3] ** 2)), q[3])
        series = 2 + angle**2 / 12 + 7 * angle**4 / 2880
        scale = np.where(angle <= SMALL, series, angle / np.sin(angle / 2))
        return np.rad2deg(scale * q[:3]) if degrees else scale * q[:3]

    def as_euler(self, seq, degrees=False, **others):
        """Bernardes and Viollet, PLoS ONE 17, e0276302 (2022), as SciPy has it."""
        i, j, k = order = _axes(seq)
        if others or len(order) != 3:
            refuse("Rotation.as_euler in this way")
        fixed = seq.islower()
        if not fixed:
            i, k = k, i
        symmetric = i == k
        if symmetric:
            k = 3 - i - j
        sign = (i - j) * (j - k) * (k - i) // 2
        q = self._q
        a, b, c, d = q[3], q[i], q[j], q[k] * sign
        if not symmetric:
            a, b, c, d = a - c, b + d, c + a, d - b
        second = 2 * np.arctan2(np.hypot(c, d), np.hypot(a, b))
        g = q.g
        for limit in (second, second - math.pi):
            g.leaves_to_python_if(g.map("le", np.abs(limit).ids, g.const(LOCKED).key))
        half_sum = np.arctan2(b, a)
        half_difference = np.arctan2(d, c)
        first = half_sum - half_difference
        third = half_sum + half_difference
        if not symmetric:
            third = third * sign
            second = second - math.pi / 2
        angles = array_of([first, second, third] if fixed else [third, second, first])
        turn = 2 * math.pi
        angles = np.where(angles < -math.pi, angles + turn, angles)
        angles = np.where(angles > math.pi, angles - turn, angles)
        return np.rad2deg(angles) if degrees else angles


class Rotations:
    """The class `Rotation` in a traced function."""

    def __getattr__(self, name):
        refuse(f"Rotation.{name}")

    def identity(self):
        return self.from_quat([0.0, 0.0, 0.0, 1.0])

    def from_quat(self, q: Any, *, scalar_first=False):
        q = array_of(q)
        if q.ids.shape != (4,):
            refuse("several rotations at once")
        g = q.g
        size = np.sum(q * q)
        # versions of SciPy differ in what NaN gives
        g.leaves_to_python_if(g.map("not", g.map("lt", g.const(0.0).key, size.ids)))
        return Rotation(_normed(np.roll(q, -1) if scalar_first else q))

    def from_rotvec(self, rotvec: Any, degrees=False):
        v = array_of(rotvec)
        if v.ids.shape != (3,):
            refuse("several rotations at once")
        v = np.deg2rad(v) if degrees else v
        square = np.sum(v * v)
        angle = np.sqrt(square)
        series = 0.5 - square / 48 + square**2 / 3840
        scale = np.where(angle <= SMALL, series, np.sin(angle / 2) / angle)
        return Rotation(np.append(scale * v, np.cos(angle / 2)))

    def from_euler(self, seq, angles, degrees=False):
        angles = array_of(angles)
        if angles.ids.ndim != (len(seq) > 1):
            refuse("several rotations at once")
        angles = np.deg2rad(angles) if degrees else angles
        q: Any = array_of([0.0, 0.0, 0.0, 1.0])
        for axis, angle in zip(_axes(seq), np.atleast_1d(angles), strict=True):
            turn = array_of(np.zeros(4))
            turn[axis] = np.sin(angle / 2)
            turn[3] = np.cos(angle / 2)
            q = _product(q, turn) if seq.isupper() else _product(turn, q)  # body or fixed axes
        return Rotation(q)


def _axes(seq):
    """The numbers of the axes of a sequence."""
    if not (seq.isupper() or seq.islower()) or not set(seq.lower()) <= set("xyz"):
        refuse("a Rotation about other axes")
    return ["xyz".index(axis) for axis in seq.lower()]


def _normed(q):
    return q / np.sqrt(np.sum(q * q))


def _product(p, q):
    v = p[3] * q[:3] + q[3] * p[:3] + np.cross(p[:3], q[:3])
    return np.append(v, p[3] * q[3] - np.sum(p[:3] * q[:3]))
