"""Which changes of sign are noise: an event function that the error of the step may move more.

The apsides of a circle, zeros of r.v, are rounding and the errors of steps around zero.  A dip
between two crossings is noise if the tolerance of the step lets the event function change as much.
"""

import numpy as np

from ...calls.block import RAISED_WORD
from ...calls.user_function import call_function, raised, words_at
from ...jit.options import INTERNAL, njit
from ...state.record import ATOL, RTOL, Y_OLD, Y
from ..dense_output import polynomial

TIME, VALUE = 0, 1  # rows of the points at which an event function was evaluated
# Tolerances up to which a dip is noise.  Apsides of circles and of ellipses with e <= 1e-3 by
# twelve methods at rtol 1e-3, 1e-6 and 1e-9: dips of 1.6 (DOP853), 0.9 (RK45), 0.68 (ode45) and 0.1
# (all others) at most; the function in the whole step 0.2 at most by methods that count the dips.
NOISE = 2.0
GROUPS = 16  # most evaluations for one tolerance; more components move in so many groups


@njit(**INTERNAL)
def tolerance_of(solve, e, d, t, scratch):
    """The change of an event function at time t of a step if the state moves by its tolerance.

    The sum over the components.  Those that rest in the step do not count: the values of discrete
    states decide, and have no error.
    """
    s = solve.state[0]
    work = solve.work
    y = scratch[0]
    out = scratch[1]
    n = len(y)
    x = (t - s.t_old) / (s.t - s.t_old)
    polynomial(d, x, y)
    call_function(e.block, t, y, out)
    here = out[0]
    total = 0.0
    for group in range(min(n, GROUPS)):
        polynomial(d, x, y)
        for i in range(group, n, GROUPS):
            if work[Y, i] != work[Y_OLD, i]:
                y[i] += work[ATOL, i] + work[RTOL, i] * max(abs(work[Y, i]), abs(work[Y_OLD, i]))
        call_function(e.block, t, y, out)
        if raised(e.block):
            words_at(e.block)[RAISED_WORD] = 0  # the state is none of the solution's
        elif np.isfinite(out[0]):
            total += abs(out[0] - here)
    return total


@njit(**INTERNAL)
def is_noise(solve, e, d, points, n, scratch):
    """True if an event function stays within its tolerance at all points of a step."""
    most = 0.0
    for k in range(n):
        if not abs(points[VALUE, k]) <= most:
            most = abs(points[VALUE, k])
    tolerance = tolerance_of(solve, e, d, points[TIME, n // 2], scratch)
    return tolerance > 0.0 and most <= NOISE * tolerance


@njit(**INTERNAL)
def fill_shallow(solve, e, d, points, n, scratch):
    """Set the points of the shallowest dip to zero; False if each dip is deeper than noise.

    A dip is a sequence of points of one sign, and zeros, between points of the other sign.
    """
    begin = end = deepest = 0
    least = np.inf
    first = 0
    while first < n - 1 and points[VALUE, first] == 0.0:
        first += 1
    is_inner = False
    while first < n:
        at = first
        last = first
        while last < n and not points[VALUE, first] * points[VALUE, last] < 0.0:
            if abs(points[VALUE, last]) > abs(points[VALUE, at]):
                at = last
            last += 1
        if is_inner and last < n:
            depth = max(abs(points[VALUE, at]), _vertex(points, at))
            if depth < least:
                least = depth
                deepest = at
                begin = first
                end = last
        first = last
        is_inner = True
    if begin == end:
        return False
    if not least <= NOISE * tolerance_of(solve, e, d, points[TIME, deepest], scratch):
        return False
    for k in range(begin, end):
        points[VALUE, k] = 0.0
    return True


@njit(**INTERNAL)
def _vertex(points, k):
    """The size at its vertex of the parabola through a point and the points beside; 0 if none."""
    left = points[TIME, k - 1] - points[TIME, k]
    right = points[TIME, k + 1] - points[TIME, k]
    here = points[VALUE, k]
    before = (points[VALUE, k - 1] - here) / left
    after = (points[VALUE, k + 1] - here) / right
    bend = (after - before) / (right - left)
    slope = before - bend * left
    if not here * bend < 0.0:
        return 0.0
    return abs(here - slope * slope / (4.0 * bend))
