"""The first passage of each path through g(t, y) = 0, also between the ends of a step.

A path whose g has one sign at both ends, g_0 and g_1, was at zero between them with probability
exp(-2 g_0 g_1 / v), where v is the variance of g over the step: without these passages a barrier
acts as if it lay 0.58 sqrt(v) farther away (Broadie, Glasserman, Kou, A continuity correction for
discrete barrier options, Mathematical Finance 7 (1997)).  Given a passage, its time is that of a
Brownian bridge: with tau the share of the step before it, tau / (1 - tau) has an inverse Gaussian
distribution of mean |g_0 / g_1| and shape g_0^2 / v, drawn as by Michael, Schucany and Haas, The
American Statistician 30 (1976).
"""

import math

import numpy as np

from ..jit.options import INLINED, INTERNAL, njit
from ..random.normal import everywhere, normals
from ..state.rows import fetch, keep_vector, numbers_of, slot, vector_at
from ..vector.scalar_or_vector import any_lane, select
from .arguments import (
    AFTER,
    BEFORE,
    FIRST,
    HALF,
    HIT,
    MOST_LEVELS,
    N_SCRATCH,
    OUT,
    SECOND,
    SOURCE_BITS,
    THIRD,
    VARIANCE,
)

USES = 2  # of pairs of normal numbers for each event


@njit(**INTERNAL)
def _share(before, after, variance, first, second, third):
    """The share of a step before the passage from g = `before`, given g = `after` at its end."""
    if not variance > 0.0 or after == 0.0:
        return before / (before - after)
    mean = abs(before / after)
    shape = before * before / variance
    a = 0.5 * mean * first * first / shape
    drawn = mean / (1.0 + a + math.sqrt(a * (2.0 + a)))
    uniform = 0.5 + math.atan2(second, third) / (2.0 * math.pi)
    if uniform * (mean + drawn) > mean:
        drawn = mean * mean / drawn
    return drawn / (1.0 + drawn)


@njit(**INTERNAL)
def _note(scratch, event, t, h, path, places, terminal):
    """Note the times of the passages in the step from t to t + h, the first of each path."""
    rows = scratch[N_SCRATCH * event : N_SCRATCH * (event + 1)]
    times = places.times[event]
    for lane in range(scratch.shape[1]):
        if rows[HIT, lane] == 0.0 or not np.isnan(times[path + lane]):
            continue
        share = _share(
            rows[BEFORE, lane], rows[AFTER, lane], rows[VARIANCE, lane], rows[FIRST, lane],
            rows[SECOND, lane], rows[THIRD, lane],
        )  # fmt: skip
        times[path + lane] = t + share * h
        if terminal:
            places.alive[path + lane] = 0.0


def passage(number, spread, event, lanes, terminal):
    """``look(i, r, path, state, ...)`` of one event, behind step i, or -1 at the start of a run.

    `number` gives g as a vector; `spread` is that of `diffusions.py`, or None where the noise does
    not act on g at once.
    """

    @njit(**INLINED)
    def row_of(scratch, row):
        return vector_at(lanes, numbers_of(scratch), (N_SCRATCH * event + row) * scratch.shape[1])

    @njit(**INLINED)
    def leave(scratch, row, value):
        keep_vector(lanes, numbers_of(scratch), (N_SCRATCH * event + row) * scratch.shape[1], value)

    @njit(**INLINED)
    def variance(t, g, state, block, form, of_noise, work, units):
        total = g * 0.0
        if spread is not None:
            for source in range(len(units)):
                unit = fetch(of_noise, units, source)
                moved = spread(slot(form, work, OUT), state, t, state, unit, block, form, work)
                change = number(t, moved, block) - g
                total = total + change * change
        return total

    @njit(**INLINED)
    def look(i, r, path, state, block, form, of_noise, work, places):
        t = r.t0 + (r.begin if i < 0 else i + 1) * r.h
        scratch = places.scratch
        g = number(t, state, block)
        if i >= 0:
            before = row_of(scratch, BEFORE)
            number_of = (HALF + MOST_LEVELS + USES * event) << SOURCE_BITS
            one, two = normals(lanes, r.key, path, i, number_of)
            energy = row_of(scratch, VARIANCE) * (one * one + two * two)
            product = before * g
            sign = everywhere(lanes, places.directions[event])
            wanted = (before != 0.0) & (before * sign <= 0.0)
            hit = wanted & ((product <= 0.0) | (energy > 4.0 * product))
            if any_lane(hit):
                leave(scratch, AFTER, g)
                leave(scratch, HIT, select(hit, 1.0, 0.0))
                first, _ = normals(lanes, r.key, path, i, number_of + (1 << SOURCE_BITS))
                leave(scratch, FIRST, first)
                leave(scratch, SECOND, one)  # the angle of a pair does not depend on its length
                leave(scratch, THIRD, two)
                _note(scratch, event, t - r.h, r.h, path, places, terminal)
        leave(scratch, BEFORE, g)
        leave(scratch, VARIANCE, variance(t, g, state, block, form, of_noise, work, places.units))

    return look


def in_turn(looks):
    """The function that calls the functions of `looks` in turn; None without functions."""
    together = None
    for look in looks:
        together = _with_another(together, look)
    return together


def _with_another(before, look):
    if before is None:
        return look

    @njit(**INLINED)
    def both(i, r, path, state, block, form, of_noise, work, places):
        before(i, r, path, state, block, form, of_noise, work, places)
        look(i, r, path, state, block, form, of_noise, work, places)

    return both
