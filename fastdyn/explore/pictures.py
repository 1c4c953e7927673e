"""Turns the scenes of a system, in the plane or in space, into columns for plane pictures."""

import math

import numpy as np

AZIMUTH, ELEVATION = math.radians(-60.0), math.radians(20.0)
RIGHT = np.array([-math.sin(AZIMUTH), math.cos(AZIMUTH), 0.0])
UP = np.array([
    -math.sin(ELEVATION) * math.cos(AZIMUTH), -math.sin(ELEVATION) * math.sin(AZIMUTH),
    math.cos(ELEVATION),
])  # fmt: skip


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


def square(limits, down=False):
    """A square that holds the limits of all axes: (low x, high x), (low y, high y)."""
    sides = [sorted(pair) for pair in limits.values()]
    if len(sides) == 3:
        corners = np.array(np.meshgrid(*sides)).reshape(3, -1)
        x, y = flat(corners, down)
        sides = [[x.min(), x.max()], [y.min(), y.max()]]
    reach = 0.5 * max(high - low for low, high in sides)
    ends = [(0.5 * (a + b) - reach, 0.5 * (a + b) + reach) for a, b in sides]
    if down and len(limits) == 2:
        ends[1] = ends[1][::-1]
    return ends
