"""Euler steps past a zero of a root's argument, which the Taylor series does not pass.

Close to a zero of a root's argument (an emptied tank) the series reaches no farther than the zero,
and at the zero there is no series.  If the step of the series is shorter than SHARE of the time
behind or ahead, the step goes along the tangent instead, as far as the slope stays constant within
the tolerance.
"""

import math

from ...jit.options import INTERNAL, njit
from ...state.rows import keep_vector, vector_at
from .description import GIVEN, N_VECTORS, NOW, STRIDE, TABLES, WIDTH
from .lengths import landed, smaller, weigh
from .room import array, asked

SHARE = 2.0**-30  # least step of the series, as a share of the time behind or ahead
MOST = 2.0**-10  # longest tangent step, which detects no kinks, as a share of this time
GAIN = 4.0  # least ratio of the tangent step to the step of the series
AGAIN = 0.25
FINER = 4.0  # ratio of the tolerance to the allowed error of the slope


@njit(**INTERNAL)
def span(s, t):
    """The time behind, or the time ahead if that is longer and finite."""
    behind = abs(t - s.t_start)
    ahead = abs(t - s.t_end)
    behind = behind if behind < math.inf else 0.0
    return ahead if behind < ahead < math.inf else behind


@njit(**INTERNAL)
def short(s, t):
    """The length below which a step of the series tries the tangent."""
    least = span(s, t) * SHARE
    return smaller(least, s.h_old) if s.h_old > 0.0 else least


@njit(**INTERNAL)
def follow(form, room, words, unit, order):
    """Store the coefficients of a step along the tangent, from the slopes GIVEN."""
    for u in range(words[N_VECTORS]):
        place = words[TABLES + u]
        i = u * words[WIDTH]
        slope = vector_at(form, room, array(words, GIVEN) + i) * unit
        keep_vector(form, room, place + words[STRIDE], slope)
        for k in range(2, order + 1):
            keep_vector(form, room, place + k * words[STRIDE], slope * 0.0)
        weigh(form, room, words, u, vector_at(form, room, place), slope)


@njit(**INTERNAL)
def tangent(form, s, t, most, reached, block, room, words, work):
    """(the time behind a tangent step, its length); both 0 if the step is too short to be taken.

    `most` is the longest step, `reached` the length of the step of the series.  The length is NaN
    if the function raises.  Where the tangent is too short, steps try it again from AGAIN of this
    step on: an orbit that is short of time at its perihelion has no root there.
    """
    later, signed, _ = landed(t, smaller(most, span(s, t) * MOST), s.t_end, s.direction)
    if not abs(signed) > reached * GAIN:
        s.h_old = reached * AGAIN
        return 0.0, 0.0
    if asked(block, t, room, words, work, NOW):
        return t, math.nan
    return later, signed
