"""The first passage of each path through g(t, y) = 0, also between the ends of a step.

A path whose g has one sign at both ends, g_0 and g_1, was at zero between them with probability
exp(-2 g_0 g_1 / v), where v is the variance of g over the step: without these passages a barrier
acts as if it lay 0.58 sqrt(v) farther away (Broadie, Glasserman, Kou, A continuity correction for
discrete barrier options, Mathematical Finance 7 (1997)).  Given a passage, its time is that of a
Brownian bridge: with tau the share of the step before it, tau / (1 - tau) has an inverse Gaussian
distribution of mean |g_0 / g_1| and shape g_0^2 / v, drawn as by Michael, Schucany and Haas, The
American Statistician 30 (1976).

With one source of noise, the levels of all events lie on one line: the passages of a step follow
each other outwards, each drawn from the bridge behind the one before.  With several sources they
are drawn for each event by itself.

A terminal event ends a path at the passage: its state is drawn from the bridge, too, given g = 0.
"""

import functools
import math

import numpy as np

from ..jit.options import INLINED, INTERNAL, njit
from ..random.normal import everywhere, normals
from ..state.elementwise import apply
from ..state.rows import fetch, keep_vector, numbers_of, slot, vector_at
from ..vector.scalar_or_vector import any_lane, select
from .arguments import (
    AFTER,
    AT,
    BEFORE,
    CHANGE,
    CHANGED,
    FACTOR,
    FIRST,
    HALF,
    HIT,
    MOST_LEVELS,
    N_SCRATCH,
    OUT,
    SECOND,
    SOURCE_BITS,
    STAGE,
    START,
    THIRD,
    VARIANCE,
    WANTED,
)

USES = 3  # of pairs of normal numbers for each event
MOST = 20.0  # g_0 g_1 over the variance from which on no pair, of length below 8.5, is a passage


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
def _draw(rows):
    """Let AT have the shares of the step before the passages of one event."""
    for lane in range(rows.shape[1]):
        if rows[HIT, lane] != 0.0:
            rows[AT, lane] = _share(
                rows[START, lane], rows[AFTER, lane], rows[VARIANCE, lane], rows[FIRST, lane],
                rows[SECOND, lane], rows[THIRD, lane],
            )  # fmt: skip


@njit(**INLINED)
def _reached(ended, share, old, new):
    return (select(ended > 0.5, old + share * (new - old), new),)


@njit(**INLINED)
def _pushed(ended, factor, new, old, moved):
    return (select(ended > 0.5, new + factor * (moved - old), new),)


def _rows(event, lanes):
    """``row_of(scratch, row)`` and ``put(scratch, row, value)`` of one event."""

    @njit(**INLINED)
    def row_of(scratch, row):
        return vector_at(lanes, numbers_of(scratch), (N_SCRATCH * event + row) * scratch.shape[1])

    @njit(**INLINED)
    def put(scratch, row, value):
        keep_vector(lanes, numbers_of(scratch), (N_SCRATCH * event + row) * scratch.shape[1], value)

    return row_of, put


def _moved_by(spread):
    """The state moved by one deviation of a source of noise in a step."""

    @njit(**INLINED)
    def moved_by(source, t, state, block, form, of_noise, work, places):
        unit = fetch(of_noise, places.units, source)
        return spread(slot(form, work, STAGE), state, t, state, unit, block, form, work)

    return moved_by


def passage(number, spread, event, lanes, in_order):
    """``look(i, r, path, state, ...)`` of one event: whether a path of the lanes passes in step i.

    At the start of a run, i is -1.  `number` gives g as a vector; `spread` is that of
    `diffusions.py`, or None where the noise does not act on g at once.  `in_order` tells whether
    `settled` puts the passages of a step in order.
    """
    uses = (HALF + MOST_LEVELS + USES * event) << SOURCE_BITS
    next_use = 1 << SOURCE_BITS
    row_of, put = _rows(event, lanes)
    moved_by = _moved_by(spread)

    @njit(**INLINED)
    def variance(t, g, state, block, form, of_noise, work, places):
        total = g * 0.0
        if spread is not None:
            for source in range(len(places.units)):
                moved = moved_by(source, t, state, block, form, of_noise, work, places)
                change = number(t, moved, block) - g
                total = total + change * change
                if in_order:
                    put(places.scratch, CHANGE, change)
        return total

    @njit(**INLINED)
    def look(i, r, path, state, block, form, of_noise, work, places):
        t = r.t0 + (r.begin if i < 0 else i + 1) * r.h
        scratch = places.scratch
        g = number(t, state, block)
        passed = False
        if i >= 0:
            before = row_of(scratch, BEFORE)
            spreads = row_of(scratch, VARIANCE)
            product = before * g
            sign = everywhere(lanes, places.directions[event])
            alive = vector_at(lanes, places.alive, path) > 0.5
            within = (product <= 0.0) | (product <= MOST * spreads)
            near = alive & (before != 0.0) & (before * sign <= 0.0) & within
            put(scratch, HIT, select(near, 0.0, 0.0))
            if in_order:
                put(scratch, WANTED, select(near, 1.0, 0.0))
            if any_lane(near):
                one, two = normals(lanes, r.key, path, i, uses)
                energy = spreads * (one * one + two * two)
                hit = near & ((product <= 0.0) | (energy > 4.0 * product))
                put(scratch, HIT, select(hit, 1.0, 0.0))
                passed = any_lane(hit)
                if passed or in_order:
                    put(scratch, START, before)
                    put(scratch, AFTER, g)
                    first, _ = normals(lanes, r.key, path, i, uses + next_use)
                    put(scratch, FIRST, first)
                    put(scratch, SECOND, one)  # a pair's angle does not depend on its length
                    put(scratch, THIRD, two)
                    if in_order:
                        put(scratch, CHANGED, row_of(scratch, CHANGE))
                    _draw(scratch[N_SCRATCH * event : N_SCRATCH * (event + 1)])
        put(scratch, BEFORE, g)
        put(scratch, VARIANCE, variance(t, g, state, block, form, of_noise, work, places))
        return passed

    return look


def _number_of(event):
    @njit(**INLINED)
    def number(scratch, row):
        return scratch[N_SCRATCH * event + row, 0]

    return number


def end(number, spread, event, lanes, in_rows):
    """``leave(new, old, i, ...)``: the paths that an event has ended in step i, at their passages.

    On a path from `old` to `new`, the state is that of the straight line, moved along the noise
    until g = 0, and by the noise of the bridge that leaves g as it is.  `in_rows` tells whether
    states are rows of numbers, one path at a time.
    """
    use = (HALF + MOST_LEVELS + USES * event + 2) << SOURCE_BITS
    row_of, put = _rows(event, lanes)
    of_component = _number_of(event) if in_rows else row_of
    moved_by = _moved_by(spread)

    @njit(**INLINED)
    def leave(new, old, i, r, path, block, form, of_noise, work, places):
        scratch = places.scratch
        t = r.t0 + i * r.h
        ended = of_component(scratch, HIT)
        start = row_of(scratch, START)
        share = row_of(scratch, AT)
        way = ended, of_component(scratch, AT)
        new = apply(_reached, (slot(form, work, OUT),), way, (old, new))[0]
        if spread is not None:
            level = start + share * (row_of(scratch, AFTER) - start)
            apart = np.sqrt(share * (1.0 - share))
            total = start * 0.0
            along = start * 0.0
            for source in range(len(places.units)):
                moved = moved_by(source, t, old, block, form, of_noise, work, places)
                change = number(t, moved, block) - start
                z, _ = normals(lanes, r.key, path, i, use + source)
                total = total + change * change
                along = along + change * z
            safe = select(total > 0.0, total, total + 1.0)
            for source in range(len(places.units)):
                moved = moved_by(source, t, old, block, form, of_noise, work, places)
                change = number(t, moved, block) - start
                z, _ = normals(lanes, r.key, path, i, use + source)
                put(scratch, FACTOR, apart * z - change * (apart * along + level) / safe)
                way = ended, of_component(scratch, FACTOR)
                new = apply(_pushed, (slot(form, work, OUT),), way, (new, old, moved))[0]
        return new

    return leave


@njit(**INTERNAL)
def _next_level(scratch, lane, side, n_events):
    """(event, level) of the nearest level on a side that is wanted and not looked at yet."""
    nearest = -1
    level = np.inf
    for event in range(n_events):
        rows = scratch[N_SCRATCH * event : N_SCRATCH * (event + 1)]
        if rows[WANTED, lane] != 0.0 and rows[CHANGED, lane] != 0.0:
            own = -side * rows[START, lane] / rows[CHANGED, lane]
            if 0.0 < own < level:
                nearest = event
                level = own
    return nearest, level


@njit(**INTERNAL)
def _put_in_order(scratch, lane, n_events):
    """Draw the passages of a path through levels of one motion, outwards on each side of its start.

    Behind a passage the motion is a bridge again; where one level is not passed, none behind is.
    Levels are in deviations of the step.
    """
    for side in (-1.0, 1.0):
        event, level = _next_level(scratch, lane, side, n_events)
        before = 0.0
        share = 0.0
        goes_on = True
        while event >= 0:
            rows = scratch[N_SCRATCH * event : N_SCRATCH * (event + 1)]
            rows[WANTED, lane] = 0.0
            if before > 0.0 and goes_on:
                way = level - before
                rest = -side * rows[AFTER, lane] / rows[CHANGED, lane]
                left = 1.0 - share
                energy = rows[SECOND, lane] ** 2 + rows[THIRD, lane] ** 2
                goes_on = rest <= 0.0 or energy * left > 4.0 * way * rest
                if goes_on and way > 0.0:
                    share += left * _share(
                        way, rest, left, rows[FIRST, lane], rows[SECOND, lane], rows[THIRD, lane]
                    )
            elif goes_on:
                goes_on = rows[HIT, lane] != 0.0
                share = rows[AT, lane]
            rows[HIT, lane] = 1.0 if goes_on else 0.0
            rows[AT, lane] = share
            before = level
            event, level = _next_level(scratch, lane, side, n_events)


def settled(terminal, in_order):
    """``settle(t, h, path, places)``: note the passages in a step, the first of each path.

    Nothing that comes behind a terminal event counts.  HIT then tells which event ended a path; the
    result is whether any did.  `terminal` tells for each event whether a passage ends the path,
    `in_order` whether the levels of all events are those of one motion.
    """

    @njit(**INTERNAL)
    def settle(t, h, path, places):
        scratch = places.scratch
        some = False
        for lane in range(scratch.shape[1]):
            if in_order:
                _put_in_order(scratch, lane, len(terminal))
            end = 2.0  # a share of the step behind the step
            last = -1
            for event in range(len(terminal)):
                rows = scratch[N_SCRATCH * event : N_SCRATCH * (event + 1)]
                if terminal[event] and rows[HIT, lane] != 0.0 and rows[AT, lane] < end:
                    end = rows[AT, lane]
                    last = event
            for event in range(len(terminal)):
                rows = scratch[N_SCRATCH * event : N_SCRATCH * (event + 1)]
                noted = np.isnan(places.times[event, path + lane])
                if rows[HIT, lane] != 0.0 and rows[AT, lane] <= end and noted:
                    places.times[event, path + lane] = t + rows[AT, lane] * h
                rows[HIT, lane] = 1.0 if event == last else 0.0
            if last >= 0:
                places.alive[path + lane] = 0.0
                some = True
        return some

    return settle


def in_turn(looks):
    """The function that calls all functions of `looks` and tells whether one is True."""
    return functools.reduce(_with_another, looks) if looks else None


def _with_another(before, look):
    @njit(**INLINED)
    def both(i, r, path, state, block, form, of_noise, work, places):
        others = before(i, r, path, state, block, form, of_noise, work, places)
        return look(i, r, path, state, block, form, of_noise, work, places) | others

    return both


def ends_in_turn(ends):
    """The function that calls the functions of `ends` in turn; None without functions."""
    return functools.reduce(_with_another_end, ends) if ends else None


def _with_another_end(before, leave):
    @njit(**INLINED)
    def both(new, old, i, r, path, block, form, of_noise, work, places):
        new = before(new, old, i, r, path, block, form, of_noise, work, places)
        return leave(new, old, i, r, path, block, form, of_noise, work, places)

    return both
