"""The values of an event function at some points of a step, or of a part of a step."""

import numpy as np

from ...jit.options import INTERNAL, njit
from ..arguments import PARTS
from ..brent import value
from .shallow import TIME, VALUE

MOST_TURNS = 2  # between the points, which seven points show
TURNS = 8  # most evaluations in search of one turning point
CLOSE = 1e-3  # distance of two estimates of a turning point, in parts, that ends the search
POINTS = 2 * PARTS  # most points
WIDTH = 32  # length of the rows of the points


@njit(**INTERNAL)
def is_rough(points, n):
    """Whether a function turns so often between its points that there may be more turns."""
    turns = 0
    rise = 0.0
    for k in range(1, n):
        change = points[VALUE, k] - points[VALUE, k - 1]
        turns += change * rise < 0.0
        rise = change if change != 0.0 else rise
    return turns > MOST_TURNS


@njit(**INTERNAL)
def fill_points(e, d, a, b, t_old, h, points, scratch):
    """Times and values of an event function from a to b, in the order of the times; their number.

    The function has the values g and g_new at a and b.
    """
    y = scratch[0]
    out = scratch[1]
    part = (b - a) / PARTS
    points[TIME, 0] = a
    points[VALUE, 0] = e.g
    points[TIME, PARTS] = b
    points[VALUE, PARTS] = e.g_new
    for k in range(1, PARTS):
        points[TIME, k] = a + k * part
        points[VALUE, k] = value(e.block, d, t_old, h, points[TIME, k], y, out)
        e.size = max(e.size, abs(points[VALUE, k] - e.g))
    n = PARTS + 1
    k = 1
    while k < n - 1 and n < POINTS:
        found = _turn(e, d, t_old, h, points, k, y, out)
        if found == found:
            after = k if abs(found - a) < abs(points[TIME, k] - a) else k + 1
            for j in range(n, after, -1):
                points[TIME, j] = points[TIME, j - 1]
                points[VALUE, j] = points[VALUE, j - 1]
            points[TIME, after] = found
            points[VALUE, after] = value(e.block, d, t_old, h, found, y, out)
            n += 1
            k += 2
        k += 1
    return n


@njit(**INTERNAL)
def _turn(e, d, t_old, h, points, k, y, out):
    """A time between points k - 1 and k + 1 at which a function has the other sign; NaN if none.

    The three values have one sign; parabolas through three points lead to the least size between.
    """
    a = points[TIME, k - 1]
    b = points[TIME, k]
    c = points[TIME, k + 1]
    sign = np.sign(points[VALUE, k])
    if points[VALUE, k - 1] * sign < 0.0 or not points[VALUE, k + 1] * sign > 0.0:
        return np.nan
    ga = abs(points[VALUE, k - 1])
    gb = abs(points[VALUE, k])
    gc = abs(points[VALUE, k + 1])
    bend = ga - 2.0 * gb + gc
    inside = abs(gc - ga) < 2.0 * bend and gb - (gc - ga) ** 2 / (8.0 * bend) < bend
    if not inside:
        return np.nan
    whole = abs(c - a)
    for _ in range(TURNS):
        left = (b - a) * (gb - gc)
        right = (b - c) * (gb - ga)
        if left == right:
            break
        x = b - 0.5 * ((b - a) * left - (b - c) * right) / (left - right)
        if not min(a, c) < x < max(a, c) or abs(x - b) < CLOSE * whole:
            break
        g = sign * value(e.block, d, t_old, h, x, y, out)
        if g < 0.0:
            return x
        between = (x - a) * (x - b) < 0.0
        if g < gb:
            if between:
                c = b
                gc = gb
            else:
                a = b
                ga = gb
            b = x
            gb = g
        elif between:
            a = x
            ga = g
        else:
            c = x
            gc = g
    return np.nan


@njit(**INTERNAL)
def changes_of(points, n, direction):
    """The number of changes of sign between points in a direction, without those at zeros."""
    side = np.nan
    changes = 0
    for k in range(n):
        g = points[VALUE, k]
        if abs(g) > 0.0:
            turn = np.sign(g) - side
            if abs(turn) > 0.0 and turn * direction >= 0.0:
                changes += 1
            side = np.sign(g)
    return changes
