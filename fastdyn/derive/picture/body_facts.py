"""Facts of a model about its bodies: how they are held, their sizes and shapes."""

import functools
from typing import Any

import numpy as np

from . import shapes
from .guides import guides
from .joints import joints
from .places import PicturePlaces, samples
from .view import view

PULLS = ("spring", "damper")


class BodyFacts:
    """
    What is known of the bodies of a derived system before it moves.

    Parameters
    ----------
    system : DerivedSystem
    """

    def __init__(self, system):
        derivation = system.derivation
        self.system = system
        self.bodies = derivation.model.bodies
        self.drawn = derivation.model.drawn
        self.places = _places(derivation)
        states = samples(system, self.places)
        states = states or [self.places(0.0, np.array(system.initial_state()), system.args)]
        self.gravity, self.masses = self.places.numbers(system.initial_state(), system.args)
        self.view = view(states, self.gravity)
        self.joints = joints(self.bodies, states)
        self.held, self.radii = self._attached(states)
        self.joints = [
            one for one in self.joints if not (one.rod and self._is_body(one, states[0]))
        ]
        self.guides = guides(self)
        on_guides = {one.body for one in self.guides}
        self.joints = [
            one for one in self.joints if not (one.rod and one.b is None and one.a in on_guides)
        ]
        self.carts = self._carts(states) if self.view.flat else []
        self.size = self._length(states)
        self.shapes = [self._shape(n) for n in range(len(self.bodies))]

    def _attached(self, states):
        """Of each body: the points by which it is held, and the radius of a wheel, or 0."""
        held = [[] for _ in self.bodies]
        radii = [0.0 for _ in self.bodies]
        for one in self.joints:
            for body, place in ((one.a, one.at_a), (one.b, one.at_b)):
                if body is not None:
                    held[body].append(place)
        for n, drawn in enumerate(self.drawn):
            for m, point in enumerate(drawn.points):
                if point.body is None:
                    continue
                body = self.bodies.index(point.body)
                seen = np.array([one.on(body, one.points[n][m]) for one in states])
                far = np.linalg.norm(seen, axis=1)
                if np.ptp(seen, axis=0).max() <= 1e-9 * max(far.max(), 1e-300):
                    held[body].append(seen[0])
                elif np.ptp(far) < 1e-9 * far.max():
                    radii[body] = far[0]
        size = float(np.ptp([one.r for one in states], axis=0).max())
        return [_apart(one, size) for one in held], radii

    def number(self, body) -> Any:
        """The number of a body; None for the ground."""
        return None if body is None else self.bodies.index(body)

    def _is_body(self, rod, placed):
        """Whether a rod lies between two points by which a body is held: that is drawn itself."""
        ends = placed.of(rod.a, rod.at_a), placed.of(rod.b, rod.at_b)
        close = 1e-6 * np.linalg.norm(ends[1] - ends[0])
        for n, held in enumerate(self.held):
            places = [placed.of(n, p) for p in held] if self.bodies[n].rigid else []
            if all(any(np.linalg.norm(p - end) <= close for p in places) for end in ends):
                return True
        return False

    def _carts(self, states):
        """The bodies that move to and fro on a line, on springs or hinges: drawn as squares."""
        found = []
        for n, body in enumerate(self.bodies):
            ends = [p.body for one in self.drawn if one.kind in PULLS for p in one.points]
            joined = any(n in (one.a, one.b) for one in self.joints)
            r = np.array([one.r[n] for one in states])
            along = np.linalg.svd(r - r.mean(axis=0), compute_uv=False)
            turns = body.rigid and np.ptp([one.Q[n] for one in states], axis=0).any()
            if not turns and (joined or body in ends) and along[1] <= 1e-9 * along[0]:
                found.append(n)
        return found

    def _length(self, states):
        """The size of the mechanism."""
        placed = states[0]
        fixed = [one for one in self.joints if one.b is None]
        found = [p for one in fixed for p in (one.at_b, placed.of(one.a, one.at_a))]
        for body, held in enumerate(self.held):
            found += [placed.of(body, p) for p in (np.zeros(3), *held)]
        found += [p for one in placed.points for p in one]
        spread = float(np.ptp(np.array(found), axis=0).max()) if found else 0.0
        drawn = max(spread, *(2.0 * r for r in self.radii))
        return drawn or max(map(_gyration, self.masses))  # inertias may be anything

    def _shape(self, n):
        body = self.bodies[n]
        held = self.held[n]
        if not body.rigid:
            return shapes.Shape([], [], [np.zeros(3)], np.zeros(3))
        mass, *inertia = self.masses[n]
        if not self.view.flat:
            return shapes.spatial(mass, inertia, held, self.radii[n], self.size)
        normal = next(axis for axis in range(3) if axis not in self.view.axes)
        wheels = any(self.is_edge(one) and one.points[0].body is body for one in self.drawn)
        about = self.radii[n], self.view.axes, self.size, wheels
        return shapes.flat(mass, inertia[normal], held, *about)

    def is_edge(self, one):
        """Whether something drawn is a wheel, or an edge, seen from above."""
        if one.kind != "edge" or one.across is None or not self.view.flat:
            return False
        return not self.radii[self.bodies.index(one.points[0].body)]


@functools.lru_cache(maxsize=64)
def _places(derivation):
    return PicturePlaces(derivation)


def _gyration(numbers):
    """A length of a body by its mass and moments of inertia: that of a uniform bar."""
    mass, *moments = numbers
    return np.sqrt(12.0 * max(moments) / mass) if mass > 0.0 else 0.0


def _apart(points, size):
    """Points that are not at the centre, each once."""
    found: list = []
    close = 1e-6 * max(size, *(np.abs(p).max() for p in points), 1e-300)
    for p in points:
        if all(np.abs(p - q).max() > close for q in (np.zeros(3), *found)):
            found.append(p)
    return found
