"""Attractors among motions, by the ranges of their components in two windows of time.

A row of ranges has the lowest values of all components and then the highest.
"""

import numpy as np

UNDECIDED, APART = -1, -3  # labels
MOST = 20  # clusters
SHRINKS = 0.9  # factor by which the ranges of decaying motions shrink from look to look, at most
FAR, GROWS = 10.0, 1.5  # size of a motion in sizes of the starts, and its growth between the looks
NAMED = 0.02  # share of `near`, below which a number is printed as 0
TIGHT = 0.05  # share of `near`, below which ends have converged
MOVED, COME = 0.1, 0.6  # displacement of a test state over `near`; its share left after a return
TRIED, MANY = 8, 8  # most components of motions that go on; fewest motions whose scatter is used


def grown(first, second, size):
    """Whether each motion grows beyond all bounds; `size` is the size of the starts."""
    before = np.abs(first).max(axis=1)
    after = np.abs(second).max(axis=1)
    return (after > FAR * size) & (after > GROWS * before)


def drifting(first, second, least):
    """Whether each motion drifts: a range moves in one direction, by `least` and half its width."""
    low, high = np.split(second - first, 2, axis=1)
    wide = np.diff(np.stack(np.split(second, 2, axis=1)), axis=0)[0]
    on = np.minimum(np.abs(low), np.abs(high)) > np.maximum(least, 0.5 * wide)
    return ((low * high > 0.0) & on).any(axis=1)


def clusters(ends, near, fewest):
    """The sorted centres of clusters of ends; clusters of less than `fewest` ends are dropped."""
    left = ends
    centres = []
    while len(left) >= fewest and len(centres) < MOST:
        _, index, sizes = np.unique(
            np.round(left / near), axis=0, return_inverse=True, return_counts=True
        )
        seed = np.median(left[index.reshape(-1) == sizes.argmax()], axis=0)
        own = (np.abs(left - seed) <= near).all(axis=1)
        if own.sum() < fewest:
            break
        centres.append(np.median(left[own], axis=0))
        left = left[~(np.abs(left - centres[-1]) <= near).all(axis=1) & ~own]
    return np.array(sorted(centres, key=lambda c: tuple(np.round(c / near))))


def attraction(first, second, ends, labels, centres, near, later):
    """A label for each cluster: 0 for an attractor, otherwise APART or UNDECIDED.

    A few motions of a cluster are continued, from their ends and from states that are displaced a
    little along each component. On an attractor, most displaced motions return. Motions of a
    family, such as the orbits of an undamped pendulum, stay apart. Motions of a chaotic attractor
    need not return, but mix: the ranges of one motion in two windows differ as much as the ranges
    of two motions.
    """
    n = ends.shape[1]
    moves = MOVED * near * np.vstack([np.zeros(n), np.eye(n), -np.eye(n)])
    owners = [np.flatnonzero(labels == k) for k in range(len(centres))]
    some = [own[np.linspace(0, len(own) - 1, max(1, TRIED // n)).astype(int)] for own in owners]
    states = (ends[np.array(some)][:, :, None] + moves).reshape(-1, n)
    found = later(states).reshape(len(centres), -1, len(moves), 2 * n)
    stays = (np.abs(found[:, :, 0] - centres[:, None]) <= near).all(axis=-1).mean(axis=1) > 0.5
    off = np.abs(found[:, :, 1:] - found[:, :, :1]).max(axis=-1)
    back = (off <= COME * MOVED * near).reshape(*off.shape[:2], 2, n).mean(axis=(1, 2)) > 0.5
    kinds = []
    for k, own in enumerate(owners):
        mixed = _mix(first[own], second[own], near)
        real = mixed or (stays[k] and back[k].all())
        kinds.append(0 if real else APART if stays[k] else UNDECIDED)
    return kinds


def _mix(first, second, near):
    """Whether ranges scatter, and differ between windows as much as between motions."""
    scatter = np.linalg.norm(second - np.median(second, axis=0), axis=1)
    moved = second - first
    moved = np.linalg.norm(moved - moved.mean(axis=0), axis=1)  # without a common decay
    scatter, moved = (np.sqrt(np.mean(each**2)) for each in (scatter, moved))
    return len(first) >= MANY and moved > scatter > TIGHT * near


def fitted(first, second, labels, centres, near):
    """(lowest, highest) state of each attractor; both are the state of an equilibrium."""
    found = []
    for k, centre in enumerate(centres):
        low, high = np.split(centre, 2)
        wide, narrow = (_width(each[labels == k]) for each in (first, second))
        if narrow < SHRINKS * wide and narrow <= near:  # the motions still decay
            low = high = 0.5 * (low + high)
        found.append((low, high))
    return found


def _width(ranges):
    """The largest width over the components, from the median over the motions."""
    low, high = np.split(ranges, 2, axis=1)
    return float(np.median((high - low).max(axis=1))) if len(ranges) else 0.0


def described(low, high, near):
    """An attractor in words; numbers that are small beside `near` are zero."""
    least = NAMED * near
    a, b = (["0" if abs(v) < least else f"{v:.3g}" for v in part] for part in (low, high))
    if (high - low <= least).all():
        return "equilibrium at " + ", ".join(b)
    return "motion between " + ", ".join(
        f"{one} and {other}" for one, other in zip(a, b, strict=True)
    )
