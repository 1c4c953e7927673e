"""The curves on which beads slide: hoops, wires and other guides of one particle each."""

from typing import Any, NamedTuple

import numpy as np

from .joints import GROUND
from .places import settled as settled_in

HOLDING = ("line", "edge", "surface")
POINTS = 121  # of a guide
BEYOND = 0.15  # of the way of the bead, beyond both of its ends
STRAIGHT = 1e-6  # of its length, the height of a curve that counts as a line
TURN = 2.0 * np.pi
STEPS = 4  # a step along constraints is this over POINTS of half of the way


class Guide(NamedTuple):
    """A particle on a curve of one coordinate, or of several whose constraints leave one."""

    body: int
    coordinates: list
    moves: bool  # with time, as a hoop that is turned


def guides(picture):
    """
    The guides of a system.

    A particle has one if its position follows from one coordinate, and if nothing else that is
    drawn holds it.  A rod may hold it as well as a hoop of which it is the radius: a hoop it is
    where it turns, or where the model says so by `Model.guide`.
    """
    said = {picture.number(p.body) for one in picture.drawn if one.kind == "guide"
            for p in one.points}  # fmt: skip
    found = []
    for n, body in enumerate(picture.bodies):
        guide = None if body.rigid else _guide(picture, n)
        if guide is not None and (n in said or _free(picture, guide)):
            found.append(guide)
    return found


def _guide(picture, n):
    places = picture.places
    own = places.depends[n]
    moves = places.moves[n]
    within = [one for one in places.held if one.coordinates <= own]
    if len(own) - len(within) != 1 or (within and (moves or any(one.moves for one in within))):
        return None
    return Guide(n, sorted(own), moves)


def _free(picture, guide):
    """Whether nothing that is drawn says how a particle is held."""
    n = guide.body
    places = picture.places
    holding = [one for one in picture.drawn if one.kind in HOLDING]
    if any(picture.number(p.body) == n for one in holding for p in one.points):
        return False
    for one in picture.joints:
        other = one.b if one.a == n else one.a
        if n not in (one.a, one.b):
            continue
        if other is not GROUND and not places.depends[other] <= set(guide.coordinates):
            continue  # that hangs on the bead
        if not (one.rod and other is GROUND and guide.moves and not picture.view.flat):
            return False
    return True


def curves(picture, t, y):
    """The functions of (time, state) that give the curves of the guides that bend or turn."""
    found = []
    for guide in picture.guides:
        if len(guide.coordinates) == 1:
            curve = _by_coordinate(picture, guide, y)
        else:
            curve = _still(_by_constraints(picture, guide, t, y))
        some = [0, -1, len(t) // 2, len(t) // 3] if guide.moves else [0]
        lines = [curve(t[n], y[:, n]) for n in some]
        if not guide.moves:
            curve = _still(lines[0])
        straight, along = zip(*map(_straight, lines), strict=True)
        turns = any(abs(along[0] @ one) < 1.0 - STRAIGHT for one in along)
        if turns or not all(straight):
            found.append(curve)
    return found


def _straight(line):
    """Whether a line does not bend, and its direction."""
    _, sizes, axes = np.linalg.svd(line - line.mean(axis=0), full_matrices=False)
    return sizes[1] <= STRAIGHT * sizes[0], axes[0]


def _still(line):
    return lambda time, w: line


def _by_coordinate(picture, guide, y):
    """The curve along the one coordinate: a full turn if it closes, else along the way."""
    (c,) = guide.coordinates
    args = picture.system.args
    place = picture.places.along(guide.body)
    low = float(y[c].min())
    high = float(y[c].max())
    beyond = BEYOND * (high - low)
    values = np.linspace(low - beyond, high + beyond, POINTS)
    once = _placed(place, 0.0, y[:, 0], c, low + TURN * np.array([0.0, 1.0, 0.5]), args)
    if np.abs(once[1] - once[0]).max() < 1e-9 * np.abs(once[2] - once[0]).max():
        values = np.linspace(low, low + TURN, POINTS)

    def curve(time, w):
        return picture.view(_placed(place, time, w, c, values, args))

    return curve


def _placed(place, time, w, c, values, args):
    state: list[Any] = list(w)
    state[c] = values
    return np.column_stack([np.broadcast_to(x, values.shape) for x in place(time, state, *args)])


def _by_constraints(picture, guide, t, y):
    """The curve that constraints of positions leave, followed from the start both ways."""
    system, place = picture.system, picture.places.along(guide.body)
    way = y[guide.coordinates]
    middle = 0.5 * (way.min(axis=1) + way.max(axis=1))
    reach = (0.5 + BEYOND) * max(np.ptp(way, axis=1).max(), 1e-9)

    def settled(w):
        """A state moved to the constraints; None if that fails, or outside of the way."""
        w, off = settled_in(system, t[0], w, np.arange(len(w)) < len(w) // 2)
        away = np.abs(w[guide.coordinates] - middle).max()
        return None if off or not away <= reach else w

    step = STEPS / POINTS * reach
    start = np.array(y[:, 0], float)
    start[len(start) // 2 :] = 0.0  # at rest the constraints of velocities hold, too
    states = _followed(settled, start, guide.coordinates, step)
    if not np.array_equal(states[-1], start):  # no closed curve
        back = _followed(settled, start, guide.coordinates, -step)
        states = [*reversed(back[1:]), *states]
    return picture.view(np.array([place(t[0], w, *system.args) for w in states], float))


def _followed(settled, start, coordinates, step):
    """The states on a curve from its start, by steps of one length, to its end or its start."""
    moved = []
    for c in coordinates:
        w = start.copy()
        w[c] += 1e-3 * abs(step)
        w = settled(w)
        if w is not None:
            moved.append((w - start)[coordinates])
    states = [start]
    along = np.sign(step) * max(moved, key=np.linalg.norm, default=np.zeros(1))
    if not along.any():
        return states
    for n in range(STEPS * POINTS):
        w = states[-1].copy()
        w[coordinates] += abs(step) * along / np.linalg.norm(along)
        w = settled(w)
        if w is None:
            break
        along = (w - states[-1])[coordinates]
        states.append(w)
        if not along.any():
            break
        if n > STEPS and np.linalg.norm((w - start)[coordinates]) < 0.75 * abs(step):
            return [*states, start]
    return states
