"""Springs, dampers and the lines of surfaces, between points of the plane or of space."""

import numpy as np

COILS = 12


def coil(a, b, width):
    """A spring of one width, whatever its length; points, shape (n, dimensions)."""
    along = np.concatenate([[0.0, 0.12], np.linspace(0.12, 0.88, COILS + 2)[1:-1], [0.88, 1.0]])
    side = np.concatenate([[0.0, 0.0], np.tile([0.5, -0.5], COILS)[:COILS], [0.0, 0.0]])
    return _laid(a, b, along, width * side)


def dashpot(a, b, width):
    """A damper: a cylinder and its piston, NaN between the two strokes."""
    along = [0.0, 0.3, 0.3, 0.7, 0.3, 0.3, 0.7, np.nan, 0.55, 0.55, 0.55, 1.0]
    side = [0.0, 0.0, 0.5, 0.5, 0.5, -0.5, -0.5, np.nan, 0.35, -0.35, 0.0, 0.0]
    return _laid(a, b, np.array(along), width * np.array(side))


def beside(a, b, shift):
    """Two points moved sideways."""
    d = shift * _sideways(a, b)
    return a + d, b + d


def outside(a, b, corners):
    """Where the line from a, inside a polygon of the plane, to b leaves the polygon; a if not."""
    shares = [0.0]
    for p, q in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        matrix = np.column_stack([b - a, p - q])
        if abs(np.linalg.det(matrix)) > 1e-12 * np.abs(matrix).max() ** 2:
            along, across = np.linalg.solve(matrix, p - a)
            if 0.0 <= along <= 1.0 and 0.0 <= across <= 1.0:
                shares.append(along)
    return a + max(shares) * (b - a)


def _laid(a, b, along, side):
    return a + np.outer(along, b - a) + np.outer(side, _sideways(a, b))


def _sideways(a, b):
    """A unit vector across the line from a to b."""
    d = np.asarray(b - a, float)
    size = np.linalg.norm(d)
    if size == 0.0:
        return np.zeros(len(d))
    if len(d) == 2:
        return np.array([-d[1], d[0]]) / size
    other = np.eye(3)[np.argmin(np.abs(d))]
    across = np.cross(d, other)
    return across / np.linalg.norm(across)
