"""The scenes of a derived system: what its model has, drawn in each state of a run."""

import functools
from typing import Any

import numpy as np

from fastdyn.plot.scene import Scene

from .body_facts import PULLS, BodyFacts
from .guides import curves

LARGER = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
SQUARE = 0.5 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
SMALL = 0.15  # of the way that a system goes: what is smaller is drawn larger
COILS = 12
LEVEL = 1e-3  # of the way: above the drift of a constraint, below what is seen


class Picture(BodyFacts):
    """How a derived system is drawn."""

    def stage(self, t, y):
        """A function of (t, w) that gives the `Scene` of a state, at the scale of the way of y."""
        args = self.system.args
        placed = [self.places(time, w, args) for time, w in zip(t, np.asarray(y).T, strict=True)]
        ways = self.view(np.array([one.r for one in placed]))
        ways = ways.reshape(-1, ways.shape[-1])
        reach = float(np.ptp(ways, axis=0).max())
        larger = self._larger(reach)
        extent = max(reach, larger * self.size, 1e-9)
        surfaces = self._surfaces(placed, extent)
        on = curves(self, t, np.asarray(y)) if self.guides else []
        ground = self._ground(placed, extent)

        def scene(time, w, args=args):
            found = self._scene(self.places(time, w, args), larger, extent, surfaces)
            found.lines.extend(tuple(curve(time, w).T) for curve in on)
            return found._replace(ground=ground)

        return scene

    def _larger(self, reach):
        """By how much the system is drawn larger where it goes far."""
        tied = any(one.b is None for one in self.joints)
        tied |= any(p.body is None for one in self.drawn for p in one.points)
        tied |= any(one.kind == "surface" for one in self.drawn)
        tied |= self.view.flat and any(self.radii)  # an enlarged rim would not roll
        if tied or not self.size > 0.0 or not self.view.flat:
            return 1
        return next((n for n in LARGER if n * self.size >= SMALL * reach), LARGER[-1])

    def _scene(self, placed, larger, extent, surfaces):
        middle = placed.r[0]

        def seen(points):
            return self.view(middle + larger * (np.asarray(points) - middle))

        polygons = []
        lines = []
        points = []
        tips = []
        blocks = self._blocks(placed, extent)
        for n, shape in enumerate(self.shapes):
            polygons += [seen([placed.of(n, p) for p in one]) for one in shape.polygons]
            lines += [seen([placed.of(n, p) for p in one]) for one in shape.lines]
            if n not in blocks:
                points += [seen(placed.of(n, p)) for p in shape.points]
            tips.append(seen(placed.of(n, shape.tip)))
        for one in self.joints:
            if not one.rod and one.b is not None and self.bodies[one.a].rigid:
                points.append(seen(placed.of(one.a, one.at_a)))
            if one.rod:
                if one.b in self.carts:
                    points.append(seen(placed.r[one.b]))
                ends = placed.of(one.b, one.at_b), placed.of(one.a, one.at_a)
                lines.append(seen(ends))
        fixed = [self.view(one.at_b) for one in self.joints if one.b is None]
        for n, one in enumerate(self.drawn):
            lines += self._stroke(one, placed, n, seen, extent, larger, blocks)
            if one.kind in (*PULLS, "force"):
                ends = zip(one.points, placed.points[n], strict=True)
                fixed += [self.view(p) for point, p in ends if point.body is None]
        polygons += [self.view(one) for one in blocks.values()]
        lines += [surface(placed) for surface in surfaces]
        trail = self._trail(placed, tips, seen)
        note = f"drawn {larger} times its size" if larger > 1 else ""
        return Scene(
            [tuple(one.T) for one in lines], [tuple(one) for one in points],
            [tuple(one) for one in fixed], [tuple(one.T) for one in polygons],
            axes=self.view.labels(), note=note, trail=tuple(trail), down=self.view.down,
        )  # fmt: skip

    def _trail(self, placed, tips, seen):
        """The point that leaves a trail: a contact in space, else the last body's."""
        if not self.view.flat:
            for n, one in enumerate(self.drawn):
                if one.kind in ("edge", "surface"):
                    return seen(placed.points[n][0])
        particles = [n for n, body in enumerate(self.bodies) if not body.rigid]
        return tips[particles[-1]] if particles else tips[-1]

    def _stroke(self, one, placed, n, seen, extent, larger, blocks):
        points = placed.points[n]
        if one.kind == "line":
            return [seen(points)]
        if one.kind == "edge" and self.is_edge(one):
            u, v = self.view(placed.across[n])
            wheel = 0.17 * self.size * np.array([-v, u]) / np.hypot(u, v)
            return [np.array([seen(points[0]) - larger * wheel, seen(points[0]) + larger * wheel])]
        if one.kind not in PULLS:
            return []
        a, b = seen(points)
        same = [
            m for m, other in enumerate(self.drawn)
            if other.kind in PULLS and np.allclose(placed.points[m], points)
        ]  # fmt: skip
        width = 0.09 * extent
        stroke = coil if one.kind == "spring" else dashpot
        ends = (a, b)
        if len(same) > 1:
            a, b = beside(a, b, 1.2 * width * (same.index(n) - 0.5 * (len(same) - 1)))
        boxes = [blocks.get(self.number(point.body)) for point in one.points]
        first, last = ([end] if box is None else [] for end, box in zip(ends, boxes, strict=True))
        if boxes[0] is not None:
            a = outside(a, b, self.view(boxes[0]))
        if boxes[1] is not None:
            b = outside(b, a, self.view(boxes[1]))
        return [np.vstack([*first, stroke(a, b, width), *last])]

    def _blocks(self, placed, extent):
        """The particles that slide on something, as squares on it: corners by body."""
        found = {}
        for n, one in enumerate(self.drawn):
            point = one.points[0]
            if one.kind == "surface" and self.view.flat and not point.body.rigid:
                up = placed.across[n] * 0.12 * extent
                side = np.zeros(3)
                h, v = self.view.axes
                side[h], side[v] = -0.6 * up[v], 0.6 * up[h]
                foot = placed.points[n][0]
                corners = [foot + side, foot - side, foot - side + up, foot + side + up]
                found[self.bodies.index(point.body)] = np.array(corners)
        for n in self.carts:
            if n not in found:
                side = np.zeros((4, 3))
                side[:, list(self.view.axes)] = SQUARE * 0.12 * extent
                found[n] = placed.r[n] + side
        return found

    def _surfaces(self, placed, extent):
        """The lines on which bodies slide, roll or run, along all of the way, by `Placed`."""
        found: list[Any] = [
            functools.partial(_still, line) for line in self._floors(placed, extent)
        ]
        for n, one in enumerate(self.drawn):
            if one.kind != "surface" or not self.view.flat:
                continue
            turns = np.ptp([each.across[n] for each in placed], axis=0).max() > 1e-9
            h, v = self.view(placed[0].across[n])
            along = np.array([-v, h])
            way = [self.view(each.points[n][0]) @ along for each in placed]
            ends = np.array([min(way) - 0.15 * extent, max(way) + 0.15 * extent])
            found.append(functools.partial(self._surface, n, ends, turns))
        return found

    def _ground(self, placed, extent):
        """The height of the level plane on which bodies in space stand; None without one."""
        if self.view.flat or self.view.down:
            return None
        for n, one in enumerate(self.drawn):
            if one.kind == "surface":
                up = self.view([each.across[n] for each in placed])
                heights = self.view([each.points[n][0] for each in placed])[:, -1]
                if not up[:, :-1].any() and np.ptp(heights) < LEVEL * extent:
                    return float(np.median(heights))
        return None

    def _floors(self, placed, extent):
        """The straight lines on which wheels roll, and carts run whose weight is across them."""
        if not self.view.flat:
            return []
        ways = [
            (0.0, [each.points[n][0] for each in placed])
            for n, one in enumerate(self.drawn)
            if one.kind == "edge" and self.radii[self.number(one.points[0].body)]
        ]
        down = self.view(self.gravity)
        if down.any():
            down, sunk = down / np.linalg.norm(down), self.gravity / np.linalg.norm(down)
            for n in self.carts:
                ways.append((1.0, [each.r[n] + 0.06 * extent * sunk for each in placed]))
        found = []
        for weight, way in ((weight, self.view(way)) for weight, way in ways):
            middle = way.mean(axis=0)
            _, sizes, axes = np.linalg.svd(way - middle, full_matrices=False)
            straight = 0.0 < sizes[0] and sizes[-1] < 1e-6 * sizes[0] and len(sizes) == 2
            if straight and weight * abs(axes[0] @ down) < 1e-6:
                there = (way - middle) @ axes[0]
                ends = np.array([there.min() - 0.15 * extent, there.max() + 0.15 * extent])
                found.append(middle + np.outer(ends, axes[0]))
        return found

    def _surface(self, n, ends, turns, placed):
        """The line of a surface in one state; it goes through the origin if it turns."""
        h, v = self.view(placed.across[n])
        normal = np.array([h, v])
        along = np.array([-v, h])
        reach = np.abs(ends).max()
        ends = np.array([-reach, reach]) if turns else ends
        return (self.view(placed.points[n][0]) @ normal) * normal + np.outer(ends, along)


def _still(line, _):
    return line


def picture(system):
    """The `Picture` of a system, made once."""
    found = getattr(system, "_picture", None)
    if found is None:
        found = Picture(system)
        object.__setattr__(system, "_picture", found)
    return found


def coil(a, b, width):
    """A spring of one width, whatever its length; points, shape (n, dimensions)."""
    along = np.concatenate([[0.0, 0.12], np.linspace(0.12, 0.88, COILS + 2)[1:-1], [0.88, 1.0]])
    side = np.concatenate([[0.0, 0.0], np.tile([0.5, -0.5], COILS)[:COILS], [0.0, 0.0]])
    return _laid(a, b, along, width * side)


def dashpot(a, b, width):
    """A damper: a cylinder and its piston, NaN between the two"""
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
