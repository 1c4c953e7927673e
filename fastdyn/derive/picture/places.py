"""Where the bodies of a system are in one state, how they are turned, and what is drawn on them."""

import functools
from typing import NamedTuple

import numpy as np
import sympy as sp

from fastdyn.derive.code import function
from fastdyn.derive.notation import ZERO, now
from fastdyn.derive.writing import Writer

SAMPLES = 24  # states by which joints are told from accidents
SPREAD = 1.3  # rad, and times the length of the system, of the samples


class PicturePlaces:
    """
    The places of a derived system as numbers.

    Parameters
    ----------
    derivation : Derivation
    """

    def __init__(self, derivation):
        model = derivation.model
        plain = derivation.plain
        self.bodies = model.bodies
        self.drawn = model.drawn
        vectors = []
        for body in self.bodies:
            turned = [body.rotation * sp.eye(3).col(n) for n in range(3)] if body.rigid else []
            vectors += [body.position, *turned]
        for one in self.drawn:
            vectors += [point.position for point in one.points]
            vectors.append(ZERO if one.across is None else one.across)
        entries = [plain(entry) for vector in vectors for entry in vector]
        numbers = list(model.field)
        for body in self.bodies:
            numbers += [body.mass, *(body.inertia if body.rigid else (0, 0, 0))]
        self._numbers = Writer(derivation).numbers("numbers", [plain(one) for one in numbers])
        self.n = 2 * len(model.coordinate_list)
        self._function = Writer(derivation).numbers("places", entries)
        self._derivation = derivation
        motion = derivation.motion
        r = [plain(body.position) for body in self.bodies]
        of_time = {now, *motion.inputs}
        self.depends = [_indices(one, motion.q) for one in r]
        self.moves = [bool(one.free_symbols & of_time) for one in r]
        self.held = [
            Held(_indices(one.position, motion.q), bool(one.position.free_symbols & of_time))
            for one in derivation.held if one.position is not None
        ]  # fmt: skip

    def __call__(self, t, w, args):
        """`Placed` in one state."""
        found = np.array(self._function(t, w[: self.n], *args), float).reshape(-1, 3)
        return Placed(self, found)

    @functools.cache  # noqa: B019
    def along(self, body):
        """The function of (t, w, *args) that gives x, y, z of a body; a component of w may be an
        array."""
        writer = Writer(self._derivation)
        lines, entries = writer.body(list(self._derivation.plain(self.bodies[body].position)))
        text = f"return [{', '.join(entries)}]"
        return function("along", writer.arguments, [*lines, text], arrays=True)

    def numbers(self, w, args):
        """Gravity, shape (3,), and of each body its mass and three moments of inertia."""
        found = np.array(self._numbers(0.0, w[: self.n], *args), float)
        return found[:3], found[3:].reshape(-1, 4)


class Placed:
    """
    Bodies and drawn points in one state.

    Attributes
    ----------
    r : list of ndarray, shape (3,)
        Centres of the bodies.
    Q : list of ndarray, shape (3, 3)
        Their axes as columns; those of a particle do not turn.
    points, across : list
        Of each `Drawn`: its points, shape (n, 3), and its normal.
    """

    def __init__(self, places, found):
        rows = iter(found)
        self.r = []
        self.Q = []
        self.points = []
        self.across = []
        for body in places.bodies:
            self.r.append(next(rows))
            turned = [next(rows) for _ in range(3)] if body.rigid else np.eye(3)
            self.Q.append(np.array(turned, float).T)
        for one in places.drawn:
            self.points.append(np.array([next(rows) for _ in one.points]))
            self.across.append(next(rows))

    def on(self, body, place):
        """A place in the frame of a body; of the ground if None."""
        return place if body is None else self.Q[body].T @ (place - self.r[body])

    def of(self, body, local):
        """Where a point of a body is."""
        return local if body is None else self.r[body] + self.Q[body] @ local


class Held(NamedTuple):
    """The coordinates in a constraint of positions; whether time is in it, too."""

    coordinates: set
    moves: bool


def _indices(expression, q):
    used = expression.free_symbols
    return {n for n, one in enumerate(q) if one in used}


def settled(system, t, w, free):
    """A state moved to the constraints, and the residuals that remain: see `Start.settled`."""
    model = system.derivation.model
    numbers = [getattr(system, str(one.symbol)) for one in model.numbers]
    drivers = [getattr(system, one.name) for one in model.drivers]
    return system.derivation.start.settled(t, w, numbers, drivers, free)


def samples(system, places):
    """`Placed` in random states on the constraints, at several times."""
    model = system.derivation.model
    rng = np.random.default_rng(0)
    base = np.array(system.initial_state(), float)
    n = len(base) // 2
    found = []
    lengths = [abs(x) for x, one in zip(base, model.coordinate_list, strict=False)
               if one.unit == "m" and x]  # fmt: skip
    size = max(lengths, default=1.0)
    scale = np.array([1.0 if one.unit == "rad" else size for one in model.coordinate_list])
    for _ in range(4 * SAMPLES):
        w = base.copy()
        t = rng.uniform(0.0, system.t_end)
        w[:n] += SPREAD * scale * rng.uniform(-1.0, 1.0, n)
        w, off = settled(system, t, w, np.ones(2 * n, bool))
        if not off:
            found.append(places(t, w, system.args))
        if len(found) == SAMPLES:
            break
    return found
