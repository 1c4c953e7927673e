"""Hinges and rods of a system, found by what stays where it is in all of its states."""

import itertools
from typing import Any, NamedTuple

import numpy as np

CLOSE = 1e-7  # of the size of the system
GROUND = None


class Joint(NamedTuple):
    """
    A hinge (`rod` False), or a rod, between points of two bodies; None is the ground.

    A point is given in the frame of its body.
    """

    a: Any
    at_a: np.ndarray
    b: Any
    at_b: np.ndarray
    rod: bool


def joints(bodies, states):
    """
    The joints between bodies, and between them and the ground.

    Parameters
    ----------
    bodies : list of Body
    states : list of Placed
        Random ones on the constraints.
    """
    if len(states) < 8:  # too few to tell
        return []
    size = max(np.ptp([one.r for one in states], axis=0).max(), 1e-12)
    found = []
    for a, b in itertools.product(range(len(bodies)), [GROUND, *range(len(bodies))]):
        if a == b or (b is not None and bodies[a].rigid == bodies[b].rigid and b > a):
            continue  # a pair that is looked at the other way round
        if bodies[a].rigid:
            if b is None or bodies[b].rigid:
                found += _hinge(a, b, states, size)
        else:
            found += _tether(a, b, b is None or bodies[b].rigid, states, size)
    return found


def _hinge(a, b, states, size):
    """The point that two bodies that turn have in common."""
    turned = [np.eye(3) if b is None else one.Q[b] for one in states]
    rows = np.vstack([np.hstack([q, -one.Q[a]]) for q, one in zip(turned, states, strict=True)])
    right = np.concatenate([one.r[a] - (0.0 if b is None else one.r[b]) for one in states])
    x, _, rank, _ = np.linalg.lstsq(rows, right, rcond=1e-9)
    if rank < 5 or np.abs(rows @ x - right).max() > CLOSE * size:
        return []  # bodies that do not turn against each other have no hinge
    return [Joint(a, x[3:], b, x[:3], False)]


def _tether(a, b, anywhere, states, size):
    """A particle on a body, or at a distance from a point of it; `anywhere`, or at its centre."""
    seen = np.array([one.on(b, one.r[a]) for one in states])
    middle = seen.mean(axis=0)
    if np.abs(seen - middle).max() < CLOSE * size:
        return [Joint(a, np.zeros(3), b, middle, False)] if b is not None else []
    squares = (seen * seen).sum(axis=1)
    if not anywhere:
        even = np.ptp(squares) < CLOSE * size**2
        return [Joint(a, np.zeros(3), b, np.zeros(3), True)] if even else []
    rows = np.column_stack([2.0 * seen, np.ones(len(seen))])
    x = np.linalg.lstsq(rows, squares, rcond=1e-9)[0]
    if np.abs(rows @ x - squares).max() > CLOSE * size**2:
        return []
    return [Joint(a, np.zeros(3), b, x[:3], True)]
