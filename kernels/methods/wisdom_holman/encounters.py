"""Planets that meet within a step: the smallest distance between its ends.

A step of twenty in a revolution is ten times as long as the distance of a meeting for planets like
the Earth, so that two of them pass each other between two steps.  Their places within the step are
the cubics through places and velocities at both ends, cut into chords.
"""

import math

import numpy as np

from ...jit.options import INTERNAL, njit

# Chords of a step.  Cubic and chords are off by 1e-4 of the distance from the star at 20 steps a
# revolution; planets of 1e-8 meet at 57e-4.
PIECES = 16
FASTER = 1.5  # what the relative speed in a step may be, in terms of the larger one at its ends
NONE = (np.inf, 0, 0)


@njit(**INTERNAL)
def places_from_star(row, m, n, p, out):
    """Write places or velocities from the star, (n, 3), of those in Jacobi's coordinates."""
    for i in range(n):
        for c in range(3):
            place = row[c * p + i]
            for j in range(i):
                place += m.centre[j * p + i] * row[c * p + j]
            out[3 * i + c] = place


@njit(**INTERNAL)
def square(a):
    return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]


@njit(**INTERNAL)
def product(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(**INTERNAL)
def difference(row, i, j):
    a = 3 * i
    b = 3 * j
    return row[b] - row[a], row[b + 1] - row[a + 1], row[b + 2] - row[a + 2]


@njit(**INTERNAL)
def place_within(x0, v0, x1, v1, i, h, s):
    """The place of planet i at the share s of a step h, by the cubic."""
    late = s * s * (3.0 - 2.0 * s)
    a = h * s * (1.0 - s) * (1.0 - s)
    b = h * s * s * (s - 1.0)
    k = 3 * i
    return (
        x0[k] + late * (x1[k] - x0[k]) + a * v0[k] + b * v1[k],
        x0[k + 1] + late * (x1[k + 1] - x0[k + 1]) + a * v0[k + 1] + b * v1[k + 1],
        x0[k + 2] + late * (x1[k + 2] - x0[k + 2]) + a * v0[k + 2] + b * v1[k + 2],
    )


@njit(**INTERNAL)
def far_apart(x0, v0, x1, v1, i, j, h, near):
    """Whether planets are too far from each other at both ends to meet in the step."""
    rr = max(
        max(square((x0[3 * i], x0[3 * i + 1], x0[3 * i + 2])),
            square((x0[3 * j], x0[3 * j + 1], x0[3 * j + 2]))),
        max(square((x1[3 * i], x1[3 * i + 1], x1[3 * i + 2])),
            square((x1[3 * j], x1[3 * j + 1], x1[3 * j + 2]))),
    )  # fmt: skip
    apart = min(square(difference(x0, i, j)), square(difference(x1, i, j)))
    fast = max(square(difference(v0, i, j)), square(difference(v1, i, j)))
    return math.sqrt(apart) > math.sqrt(near * rr) + 0.5 * FASTER * abs(h) * math.sqrt(fast)


@njit(**INTERNAL)
def meet_within(x0, v0, x1, v1, i, j, h, near):
    """The share of the step at which planets i and j come closer than they may; or infinity."""
    a = place_within(x0, v0, x1, v1, i, h, 0.0)
    b = place_within(x0, v0, x1, v1, j, h, 0.0)
    d = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    rr = max(square(a), square(b))
    for k in range(1, PIECES + 1):
        a = place_within(x0, v0, x1, v1, i, h, k / PIECES)
        b = place_within(x0, v0, x1, v1, j, h, k / PIECES)
        d_old = d
        rr_old = rr
        d = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
        rr = max(square(a), square(b))
        e = (d[0] - d_old[0], d[1] - d_old[1], d[2] - d_old[2])
        ee = square(e)
        de = product(d_old, e)
        dd = square(d_old)
        nearest = min(max(-de / ee, 0.0), 1.0) if ee > 0.0 else 0.0
        limit = near * (rr_old + nearest * (rr - rr_old))
        if dd + nearest * (2.0 * de + nearest * ee) < limit:
            enters = 0.0
            if dd > limit:  # the smaller root of dd + 2 de s + ee s^2 = limit, de < 0
                enters = (dd - limit) / (math.sqrt(max(de * de - ee * (dd - limit), 0.0)) - de)
            return (k - 1 + enters) / PIECES
    return np.inf


@njit(**INTERNAL)
def first_meeting(start, end, m, n, p, h):
    """The first meeting in a step h, which moved planets along their orbits from start to end.

    Returns the share of the step, infinity if there is none, and the two planets.  Writes to all
    vectors of the room.
    """
    x0 = m.h
    v0 = m.s
    x1 = m.d
    v1 = m.some
    places_from_star(start.x, m, n, p, x0)
    places_from_star(start.v, m, n, p, v0)
    places_from_star(end.x, m, n, p, x1)
    places_from_star(end.v, m, n, p, v1)
    first, first_i, first_j = NONE
    for j in range(1, n):
        for i in range(j):
            near = m.near[i * p + j]
            if near > 0.0 and not far_apart(x0, v0, x1, v1, i, j, h, near):
                share = meet_within(x0, v0, x1, v1, i, j, h, near)
                if share < first:
                    first = share
                    first_i = i
                    first_j = j
    return first, first_i, first_j
