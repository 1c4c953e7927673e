"""Turns the scenes of a system, in the plane or in space, into columns for plane pictures."""

import math
from typing import Any

import numpy as np

from .sliders import round_step

AZIMUTH = math.radians(-60.0)
ELEVATION = math.radians(20.0)
RIGHT = np.array([-math.sin(AZIMUTH), math.cos(AZIMUTH), 0.0])
UP = np.array([
    -math.sin(ELEVATION) * math.cos(AZIMUTH), -math.sin(ELEVATION) * math.sin(AZIMUTH),
    math.cos(ELEVATION),
])  # fmt: skip
ARROW, TEXT = 0.35, 1.4  # length of the lines along the axes of space, and where their names are
LEAST = 0.15  # of the longest side, for these lines
AROUND = 5.0  # widths of the picture by which the ground is wider
NAMES = 0.1  # of the width, at the left, for these names


def flat(part, down=False):
    """Points (x, y); points (x, y, z) are projected, seen from the front and above."""
    if len(part) == 2:
        return np.asarray(part[0], float), np.asarray(part[1], float)
    xyz = np.array(part, float)
    if down:
        xyz[2] *= -1.0
    return RIGHT @ xyz.reshape(3, -1), UP @ xyz.reshape(3, -1)


def columns(scene):
    """Columns of a scene: xs and ys of lines and bodies, x and y of points and fixed points."""
    found = {}
    for name in ("lines", "bodies"):
        parts = [flat(part, scene.down) for part in getattr(scene, name)]
        found[name] = {"xs": [x for x, _ in parts], "ys": [y for _, y in parts]}
    for name in ("points", "fixed"):
        parts = [flat(part, scene.down) for part in getattr(scene, name)]
        found[name] = {
            "x": np.array([float(np.squeeze(x)) for x, _ in parts]),
            "y": np.array([float(np.squeeze(y)) for _, y in parts]),
        }
    return found


def rectangle(limits, down=False):
    """A rectangle that holds the limits of all axes: (low x, high x), (low y, high y)."""
    sides = [sorted(pair) for pair in limits.values()]
    if len(sides) == 2:
        return sides
    x, y = flat(_corners(sides), down)
    return [[x.min() - NAMES * np.ptp(x), x.max()], [y.min(), y.max()]]


def under(limits, ground) -> Any:
    """Columns xs and ys of the ground: all that is below its height, or in space a plane."""
    if ground is None:
        return {"xs": [], "ys": []}
    (x0, x1), (y0, y1) = (sorted(pair) for pair in list(limits.values())[:2])
    if len(limits) == 2:
        wide = AROUND * (x1 - x0)
        deep = AROUND * (y1 - y0)
        corners: Any = (
            [x0 - wide, x1 + wide, x1 + wide, x0 - wide],
            [ground] * 2 + [y0 - deep] * 2,
        )
    else:
        corners = flat(([x0, x1, x1, x0], [y0, y0, y1, y1], [ground] * 4))
    return {"xs": [corners[0]], "ys": [corners[1]]}


def arrows(limits, scene) -> Any:
    """
    The axes of space as three lines of one round length, and the texts at their ends.

    Parameters
    ----------
    limits : dict of str to (float, float)
    scene : Scene

    Returns
    -------
    (dict, dict)
        Columns xs and ys of the lines; columns x, y and name of the texts.
    """
    sides = np.array([sorted(pair) for pair in limits.values()])
    lengths = np.ptp(sides, axis=1)
    corner = sides[:, :1]
    length = round_step(max(ARROW * lengths.min(), LEAST * lengths.max()))
    (x0, y0), (x, y) = (flat(part, scene.down) for part in (corner, corner + length * np.eye(3)))
    lines = {"xs": [[x0[0], end] for end in x], "ys": [[y0[0], end] for end in y]}
    named = [axis.rstrip(")").partition(" (") for axis in scene.axes]
    names = [f"{name}: {length:g} {unit}" for name, _, unit in named]
    return lines, {"x": x0 + TEXT * (x - x0), "y": y0 + TEXT * (y - y0), "name": names}


def _corners(sides):
    """The eight corners of a box, shape (3, 8)."""
    return np.array(np.meshgrid(*sides)).reshape(3, -1)
