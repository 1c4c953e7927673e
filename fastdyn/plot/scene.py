"""The picture of a system in one state, as data, independent of any library of figures."""

from typing import NamedTuple

import numpy as np


class Scene(NamedTuple):
    """
    The picture of a system in one state, in the plane as (x, y), or in space as (x, y, z).

    Parameters
    ----------
    lines : list of (x, y) or (x, y, z)
        Polylines: cables, springs, wheels; NaN where the pen is lifted.
    points : list of (x, y) or (x, y, z)
        Masses.
    fixed : list of (x, y) or (x, y, z)
        Points that do not move.
    bodies : list of (x, y) or (x, y, z)
        Filled polygons.
    ground : float, optional
        The height of the ground along the last axis, drawn across the picture.
    axes : tuple of str
        Names of the axes.
    note : str
        A text beside the time.
    frame : tuple, optional
        Lower left and upper right corner of a region that the picture must show.
    trail : tuple, optional
        The point that leaves a trail; by default the first mass.
    down : bool
        Whether the last axis points downwards.
    """

    lines: list
    points: list
    fixed: list
    bodies: list | tuple = ()
    ground: float | None = None
    axes: tuple = ("x (m)", "y (m)")
    note: str = ""
    frame: tuple = ()
    trail: tuple | None = None
    down: bool = False

    @property
    def traced(self):
        """The point that leaves a trail."""
        return self.points[0] if self.trail is None else self.trail


def spring(start, end, n=12):
    """A spring between two points, as a polyline."""
    x0, y0 = start
    x1, y1 = end
    along = np.concatenate([[0.0, 0.08], np.linspace(0.08, 0.92, n + 2)[1:-1], [0.92, 1.0]])
    side = np.concatenate([[0.0, 0.0], 0.06 * np.tile([1.0, -1.0], n)[:n], [0.0, 0.0]])
    dx = x1 - x0
    dy = y1 - y0
    return x0 + along * dx - side * dy, y0 + along * dy + side * dx


def frame(scenes):
    """
    Limits of the axes that show all of every scene at equal scales, "xlim", "ylim" and "zlim".

    No side is shorter than about half of the longest, and heights above a plane than a fifth; a
    last axis that points downwards has its limits the other way round.
    """
    first = scenes[0]
    low, high = _corners(scenes)
    ground = first.ground
    space = len(low) == 3
    if ground is not None:
        low[-1], high[-1] = min(low[-1], ground), max(high[-1], ground)
    reach = 0.57 * np.maximum(high - low, 1e-9)
    least = np.full(len(reach), 0.55 * reach.max())
    if ground is not None and space:
        least[-1] = 0.2 * reach.max()
    reach = np.maximum(reach, least)
    middle = 0.5 * (low + high)
    if ground is not None and low[-1] >= ground:  # little of the region below the ground
        middle[-1] = ground + (1.0 if space else 0.85) * reach[-1]
    limits = [(m - r, m + r) for m, r in zip(middle, reach, strict=True)]
    if first.down:
        limits[-1] = limits[-1][::-1]
    return dict(zip(("xlim", "ylim", "zlim"), limits, strict=False))


def _corners(scenes):
    """The lowest and the highest of all coordinates in the scenes."""
    columns = []
    for scene in scenes:
        for part in [*scene.lines, *scene.points, *scene.fixed, *scene.bodies, *scene.frame]:
            columns.append(np.array(part, float).reshape(len(part), -1))
        if scene.trail is not None:
            columns.append(np.array(scene.trail, float)[:, None])
    together = np.hstack(columns)
    return np.nanmin(together, axis=1), np.nanmax(together, axis=1)
