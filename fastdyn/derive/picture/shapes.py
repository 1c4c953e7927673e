"""The shapes by which bodies are drawn, in their own frames."""

import itertools
from typing import NamedTuple

import numpy as np

ROUND = np.linspace(0.0, 2.0 * np.pi, 41)
WIDTH = 0.05  # of a bar, times the size of the system
CHASSIS = 0.4  # width of what has wheels, times its length
FARTHEST = 2.0  # from the centre, times the farthest point by which a body is held: see `_credible`
SMALLEST = 0.02  # radius of a disc, times the size of the system; smaller ones are points


class Shape(NamedTuple):
    """Polygons, lines and points of a body, each of shape (n, 3); `tip` leaves the trail."""

    polygons: list
    lines: list
    points: list
    tip: np.ndarray


def flat(mass, inertia, held, radius, plane, size, wheels=False):
    """
    A body in the plane.

    Parameters
    ----------
    mass, inertia : float
        The inertia is about the normal of the plane.
    held : list of ndarray
        Points of the body where something holds it, but for its centre.
    radius : float
        Of the wheel that it is; 0 for none.
    plane : (int, int)
        The axes of the plane.
    size : float
        Of the system.
    wheels : bool
        Whether it is held by wheels, or by an edge.
    """
    centre = np.zeros(3)
    half = np.sqrt(3.0 * inertia / mass) if mass > 0.0 else 0.0  # of a uniform bar
    half = _credible(half, held, size)
    if radius:
        rim = _circle(radius, *_axes(plane))
        return Shape([rim], [np.array([centre, rim[0]]), *_to(held)], [], rim[0])
    if wheels and held:
        return _chassis(held, half, plane)
    if len(held) == 1:
        p = held[0]
        far = np.linalg.norm(p)
        if half > 0.999 * far:  # a bar, which reaches beyond its centre
            return Shape([_bar(p, -p * half / far, plane, size)], [], [], -p * half / far)
        radius = half * np.sqrt(2.0 / 3.0)
        disc = [_circle(radius, *_axes(plane))] if radius > SMALLEST * size else []
        return Shape(disc, [np.array([p, centre])], [centre] if not disc else [], centre)
    if not held:
        end = half * _axes(plane)[0]
        return Shape([_bar(end, -end, plane, 4.0 * half)] if half else [], [], [centre], end)
    return _spanned(np.array(held), plane, size)


def _credible(half, held, size):
    """Half the length of a body by its inertia, if what else is drawn does not contradict.

    A bar that is held at a quarter of its length reaches twice as far from its centre as the point
    by which it is held.  What would reach farther, by an inertia that was given at random, reaches
    as far as this point; a body that is held nowhere is not longer than the system.
    """
    far = max((np.linalg.norm(p) for p in held), default=0.0)
    if far:
        return half if half <= FARTHEST * far * (1.0 + 1e-9) else far
    return min(half, 0.5 * size)


def _chassis(held, half, plane):
    """A chassis on wheels, pointed in front; its centre leaves the trail."""
    rear = held[0]
    front = held[-1] if len(held) > 1 else np.zeros(3)
    for a, b in itertools.combinations([*held, np.zeros(3)], 2):
        if np.linalg.norm(b - a) > np.linalg.norm(front - rear):
            rear = a
            front = b
    along = (front - rear) / np.linalg.norm(front - rear)
    along = along if along @ _axes(plane)[0] >= 0.0 else -along
    places = [p @ along for p in (*held, np.zeros(3))]
    first = min(places)
    last = max(places)
    if len(held) == 1:
        first = min(first, -half)
        last = max(last, half)
    long = last - first
    u, v = _axes(plane)
    side = 0.5 * CHASSIS * long * (along @ u * v - along @ v * u)
    a, b, tip = (x * along for x in (first - 0.1 * long, last - 0.05 * long, last + 0.15 * long))
    return Shape([np.array([a + side, b + side, tip, b - side, a - side])], [], [], np.zeros(3))


def _spanned(held, plane, size):
    """A bar through points in a row, or the polygon around them."""
    apart = held - held[0]
    far = held[0] + apart[np.argmax((apart * apart).sum(axis=1))]
    along = (far - held[0]) / np.linalg.norm(far - held[0])
    places = apart @ along
    off = np.abs(apart - np.outer(places, along)).max()
    if off < 1e-6 * size:
        first = held[np.argmin(places)]
        last = held[np.argmax(places)]
        return Shape([_bar(first, last, plane, size)], [], [], last)
    from scipy.spatial import ConvexHull

    corners = held[ConvexHull(held[:, list(plane)]).vertices]
    return Shape([corners], [], [], held[-1])


def spatial(mass, inertia, held, radius, size):
    """A body in space: a disc, a cylinder or a box by its moments of inertia; see `flat`."""
    inertia = np.asarray(inertia, float)
    centre = np.zeros(3)
    half = np.sqrt(3.0 * inertia.max() / mass) if mass > 0.0 else 0.0
    if half and not radius:  # moments of one body of another size
        inertia = inertia * (_credible(half, held, size) / half) ** 2
    lines = _to(held)
    if not (mass > 0.0 and inertia.max() > 0.0):
        return Shape([], lines, [centre], centre)
    for axis, a, b in ((2, 0, 1), (1, 2, 0), (0, 1, 2)):
        if np.isclose(inertia[a], inertia[b], rtol=1e-9):
            return _turned(mass, inertia[[axis, a]], held, radius, (axis, a, b))
    sides = np.sqrt(np.maximum(6.0 * (inertia.sum() - 2.0 * inertia) / mass, 0.0)) / 2.0
    faces = []
    for axis, side in itertools.product(range(3), (-1.0, 1.0)):
        a = (axis + 1) % 3
        b = (axis + 2) % 3
        face = np.zeros((4, 3))
        face[:, axis] = side * sides[axis]
        face[:, a] = sides[a] * np.array([-1, 1, 1, -1])
        face[:, b] = sides[b] * np.array([-1, -1, 1, 1])
        faces.append(face)
    return Shape(faces, lines, [], sides)


def _turned(mass, moments, held, radius, axes):
    """A body of rotation: its rims, a spoke that shows how it turns, its axis."""
    about, across = moments
    axis, u, v = np.eye(3)[list(axes)]
    r = radius or np.sqrt(2.0 * about / mass)
    tall = np.sqrt(max(12.0 * across / mass - 3.0 * r * r, 0.0)) / 2.0
    ends = [tall * axis, -tall * axis] if tall > 1e-3 * r else [np.zeros(3)]
    rims = [_circle(r, u, v) + end for end in ends]
    spokes = [np.array([end, rim[0]]) for end, rim in zip(ends, rims, strict=True)]
    sides = [np.array([rims[0][n], rims[-1][n]]) for n in (0, 10, 20, 30) if len(rims) > 1]
    tip = rims[0][0]
    lines = [*spokes, *sides]
    for p in held:
        on_axis = np.linalg.norm(np.cross(p, axis)) < 1e-9 * np.linalg.norm(p)
        tip = -(tall + 0.5 * np.linalg.norm(p)) * p / np.linalg.norm(p) if on_axis else tip
        lines.append(np.array([p, tip if on_axis else np.zeros(3)]))
    return Shape(rims, lines, [], tip)


def _to(held):
    """Lines from the centre to what holds a body."""
    return [np.array([np.zeros(3), p]) for p in held]


def _axes(plane):
    return np.eye(3)[plane[0]], np.eye(3)[plane[1]]


def _circle(radius, u, v):
    return radius * (np.outer(np.cos(ROUND), u) + np.outer(np.sin(ROUND), v))


def _bar(a, b, plane, size):
    """A bar between two points of the plane, its ends in the middle of its corners."""
    u, v = _axes(plane)
    d = (b - a) / np.linalg.norm(b - a)
    side = 0.5 * WIDTH * size * (d @ u * v - d @ v * u)
    return np.array([a + side, b + side, b - side, a - side])
