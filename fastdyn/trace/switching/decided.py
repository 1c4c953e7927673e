"""Which of the times at which a function may switch matter: a number jumps or bends there.

`kernels/output/changes.py` decides the same in compiled code.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ..graph.evaluate import evaluate

FAR = 2.0**500  # stands for infinite times
EPS = float(np.finfo(float).eps)
ROUNDINGS = 16 * EPS  # distance of times that count as equal, as a share of the largest time
NEAR = 1e-4  # distance of the points that show a jump or kink, as a share of the interval
NEAR_END = 1e-9  # distance of the points that show a jump at an end, as a share of the span
NOISE = 1e-6  # smallest jump, and smallest kink, as a share of the range of the values
# A table is as good as its chords where they differ by less than this share of its range; knots
# with larger bends are switching times, and of smaller ones as many as the bends add up to.
CHORD = 1e-3
SHARP = 0.1  # CHORD, and smallest jump, of the changes of which a user is told


class Candidates(NamedTuple):
    """The times at which a function may switch, for each of `n_members` members in rising order.

    Attributes
    ----------
    member, t : ndarray
        Of the times within the span.
    weight : ndarray
        Of knots of smooth tables, in the sense of CHORD.
    at_ends : tuple of ndarray
        Members and times, each one of the ends of the span.
    span : tuple of float
        The earliest and the latest time.
    end : float
        The time up to which these are all.
    sure : bool
        Whether all matter, for all values of the parameters.
    partly : bool
        Whether the search took too long, so that some are missing.
    """

    member: Any
    t: Any
    weight: Any
    at_ends: tuple
    span: tuple
    end: float
    sure: bool = False
    n_members: int = 1
    partly: bool = False


class Times(NamedTuple):
    """Switching times in rising order for each member; `end` is the time up to which they are all.

    `sharp` tells which are large jumps and bends: see SHARP.
    """

    member: np.ndarray
    t: np.ndarray
    sharp: np.ndarray
    end: float


class Parameters:
    """The parameters at points of members, by slot."""

    def __init__(self, common, varying, member):
        self._common = common
        self._varying = varying
        self._member = member

    def __getitem__(self, slot):
        varying = self._varying.get(slot)
        return self._common[slot] if varying is None else varying[self._member]

    def __array__(self, dtype=None, copy=None):
        return np.asarray(self._common, dtype)


def decided(switches, found, values, varying) -> Times:
    """The Times among Candidates at which a number that meets the state jumps or bends."""
    return with_ends(found, *masks(switches, found, switches.looked_at(values), varying))


def masks(switches, found, looked_at, varying):
    """Which Candidates matter, which of them are sharp, and at which ends a number jumps.

    `looked_at` are the parameters of all members, each as an array.
    """
    n = len(found.t)
    keep = sharp = np.ones(n, bool)
    if n and not found.sure:
        with np.errstate(all="ignore"):
            jump, bend = _changes(switches, found, looked_at, varying)
        keep, sharp = kept(jump, np.maximum(weights(bend), found.weight))
    return keep, sharp, jumps_at_ends(switches, found, looked_at, varying)


def kept(jump, weight):
    """Which jumps and weights matter, and which of them are sharp."""
    sharp = (jump > SHARP) | _added_up(weight * math.sqrt(CHORD / SHARP))
    return (jump > NOISE) | sharp | _added_up(weight), sharp


def all_of(found):
    """The Times of Candidates that all matter."""
    every = Times(found.member, found.t, np.ones(len(found.t), bool), found.end)
    return _and_at_ends(every, found.at_ends, True)


def with_ends(found, keep, sharp, at_end):
    """The Times of Candidates that are to be kept, within the span and at its ends."""
    within = Times(found.member[keep], found.t[keep], sharp[keep], found.end)
    return _and_at_ends(within, [each[at_end] for each in found.at_ends], found.sure)


def _and_at_ends(within, at_ends, sharp):
    """The Times within a span, and those at its ends."""
    more, times = at_ends
    if not len(more):
        return within
    member = np.concatenate([within.member, more])
    t = np.concatenate([within.t, times])
    order = np.lexsort((t, member))
    ends = np.full(len(more), sharp)
    return Times(member[order], t[order], np.concatenate([within.sharp, ends])[order], within.end)


def _changes(switches, found, looked_at, varying):
    """The largest jump and bend at each time, as shares of the ranges of values."""
    every = np.arange(found.n_members)
    first, last = (np.full(found.n_members, t) for t in found.span)
    member = np.r_[every, found.member, every]
    t = np.r_[first, found.t, last]
    order = np.lexsort((t, member))
    member = member[order]
    t = t[order]
    same = member[1:] == member[:-1]
    member = member[1:][same]
    begin = t[:-1][same]
    end = t[1:][same]
    behind = np.flatnonzero(np.r_[False, member[1:] == member[:-1]])  # intervals after each
    length = np.where(end - begin > 1e-3 * FAR, 1.0, end - begin)
    left = length[behind - 1]
    right = length[behind]
    points = [found.t - k * NEAR * left for k in (3, 2, 1)]
    points += [found.t + k * NEAR * right for k in (1, 2, 3)]
    points = np.concatenate(points)
    owners = np.tile(found.member, 6)
    jump = np.zeros(len(found.t))
    bend = np.zeros(len(found.t))
    starts = np.flatnonzero(np.r_[True, np.diff(found.member) != 0])
    sizes = np.diff(np.r_[starts, len(found.t)])
    shorter = np.minimum(left, right)
    for (row,) in _rows(switches, looked_at, varying, owners, points):
        f = row.reshape(6, -1)
        low = np.fmin.reduceat(np.fmin.reduce(f, axis=0), starts)
        high = np.fmax.reduceat(np.fmax.reduce(f, axis=0), starts)
        size = np.repeat(high - low, sizes)
        before = 3.0 * (f[2] - f[1]) + f[0]
        after = 3.0 * (f[3] - f[4]) + f[5]
        step = np.abs(after - before) / size
        slope = (5.0 * f[2] - 8.0 * f[1] + 3.0 * f[0]) / (2.0 * NEAR * left)
        slope_after = (-5.0 * f[3] + 8.0 * f[4] - 3.0 * f[5]) / (2.0 * NEAR * right)
        kink = np.abs(slope_after - slope) * shorter / size
        one_sided = np.isnan(f[2]) != np.isnan(f[3])
        jump = np.maximum(jump, np.where(one_sided, 1.0, np.nan_to_num(step, posinf=1.0)))
        bend = np.maximum(bend, np.nan_to_num(kink, posinf=0.0))
    return jump, bend


def jumps_at_ends(switches, found, looked_at, varying):
    """Whether a number jumps between an end of the span, near such times, and the span."""
    member, end = found.at_ends
    if not len(end):
        return np.zeros(0, bool)
    first, last = found.span
    inwards = np.where(end == first, 1.0, -1.0) * NEAR_END * min(last - first, 1.0)
    jumps = np.zeros(len(end), bool)
    times = [end + k * inwards for k in range(3)]
    for there, near, far in _rows(switches, looked_at, varying, member, *times):
        limit = 2.0 * near - far
        size = np.maximum(np.abs(there), np.abs(limit))
        jumps |= ~(np.abs(there - limit) <= NOISE * size)  # also where one is not a number
    return jumps


def _rows(switches, looked_at, varying, member, *times):
    """The values of each number that meets the state, at some times of members."""
    for values in looked_at:
        common = Parameters(values, varying, member)
        known: list = [{} for _ in times]  # numbers have operations in common
        for node in switches.seen:
            yield [
                evaluate(switches.graph, [node], t, (), common, found=found)[0][0]
                for t, found in zip(times, known, strict=True)
            ]


def weights(bend):
    """The share of a switching time that each bend counts: see CHORD."""
    return np.sqrt(np.where(bend > NOISE, bend, 0.0) / (8.0 * CHORD))


def _added_up(weight):
    """Where the sum of weights reaches the next whole number."""
    return np.diff(np.floor(np.cumsum(weight)), prepend=0.0) > 0.0
