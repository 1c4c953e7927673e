"""From where a system is seen: the plane in which it moves, and which way is up."""

from typing import NamedTuple

import numpy as np

NAMES = "xyz"


class View(NamedTuple):
    """
    The axes that a picture shows, to the right and upwards (and towards us first, in space).

    `down` where the last of them points downwards, as gravity does along it.
    """

    axes: tuple
    down: bool

    @property
    def flat(self):
        return len(self.axes) == 2

    def __call__(self, points):
        """Points in the axes of the view: (n, 3) becomes (n, 2), or stays in space."""
        return np.asarray(points)[..., list(self.axes)]

    def labels(self):
        """Names of the axes of the picture."""
        names = [f"{NAMES[axis]} (m)" for axis in self.axes]
        if self.down:
            names[-1] = f"{NAMES[self.axes[-1]]} (m), downwards"
        return tuple(names)


def view(states, gravity):
    """
    The view of a system.

    Parameters
    ----------
    states : list of Placed
    gravity : ndarray, shape (3,)
    """
    r = np.array([one.r for one in states])
    Q = np.array([one.Q for one in states])
    moves = np.ptp(r, axis=0).max(axis=0)
    still = moves <= 1e-9 * max(moves.max(), 1e-300)
    normals = [
        axis for axis in range(3)
        if still[axis] and np.allclose(Q[..., axis, axis], 1.0)
    ]  # fmt: skip
    weight = np.abs(gravity)
    vertical = int(np.argmax(weight)) if weight.any() else None
    if not normals:
        up = 2 if vertical is None else vertical
        axes = tuple(axis for axis in ((1, 2, 0), (2, 0, 1), (0, 1, 2))[up])
        return View(axes, vertical is not None and bool(gravity[vertical] > 0.0))
    normal = normals[-1] if normals[-1] != vertical else normals[0]
    across, up = (axis for axis in range(3) if axis != normal)
    if vertical == across:
        across, up = up, across
    return View((across, up), vertical == up and bool(gravity[up] > 0.0))
