"""Hybrid systems with exact end states: two act at known times, one at impacts."""

import functools
import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from scipy.linalg import expm
from scipy.optimize import brentq


class Hybrid(NamedTuple):
    """y' = fun(t, y, d) from 0 to `end`, with discrete states d, and what acts.

    ``act(xp)(t, y, d)`` returns (y, d), written for the arrays of `xp`; it acts at 0, `period`,
    2 `period`, ...; without a period, where the first component falls to 0.
    """

    name: str
    fun: Any
    act: Any
    y0: list
    d0: list
    end: float
    period: float | None
    solution: list


def plant(t, y, d):
    return [y[1], -y[0] - 0.4 * y[1] + d[0]]


PERIOD, LIMIT, TARGET = 0.01, 1.5, 1.0


def pid(xp):
    """A PID at 100 Hz with saturation; the integral waits while the output is at its limit."""

    def act(t, y, d):
        error = TARGET - y[0]
        grown = d[1] + PERIOD * error
        wanted = 6.0 * error + 4.0 * grown + 0.5 * (error - d[2]) / PERIOD
        held = xp.minimum(xp.maximum(wanted, -LIMIT), LIMIT)
        kept = d[1] + (held == wanted) * (grown - d[1])
        return [y[0], y[1]], [held, kept, error]

    return act


ABSORBED, ELIMINATED, OUT, BACK = 0.9, 0.15, 0.3, 0.2  # rates in 1/h


def compartments(t, y, d):
    """A drug in the gut, in the blood, in tissue."""
    return [
        -ABSORBED * y[0],
        ABSORBED * y[0] - (ELIMINATED + OUT) * y[1] + BACK * y[2],
        OUT * y[1] - BACK * y[2],
    ]


def doses(xp):
    """Each dose is smaller than the one before, towards a level."""

    def act(t, y, d):
        return [y[0] + d[0], y[1], y[2]], [50.0 + 0.9 * (d[0] - 50.0)]

    return act


G, DRAG, REBOUND = 9.81, 0.05, 0.95


def falling(t, y, d):
    return [y[1], -G - DRAG * y[1]]


def bounces(xp):
    def act(t, y, d):
        return [0.0 * y[0], -REBOUND * y[1]], [d[0] + 1.0]

    return act


def _by_exponentials(matrix, drive, act, y, d, period, n):
    """The end state of y' = matrix y + drive d[0], sampled n times."""
    k = len(y)
    whole = np.zeros((k + 1, k + 1))
    whole[:k, :k], whole[:k, k] = matrix, drive
    step = expm(period * whole)
    for _ in range(n):
        y, d = act(0.0, y, d)
        y = (step @ [*y, float(d[0])])[:k].tolist()
    return y


def _by_roots(y, v, end):
    """The end state of the ball: formulas between impacts, whose times are roots."""

    def height(s):
        return y + (v + G / DRAG) * -math.expm1(-DRAG * s) / DRAG - G * s / DRAG

    def speed(s):
        return (v + G / DRAG) * math.exp(-DRAG * s) - G / DRAG

    top = math.log(1.0 + v * DRAG / G) / DRAG if v > 0.0 else 0.0
    later = top + 1.0
    while height(later) > 0.0:
        later += 1.0
    hit = brentq(height, top, later, xtol=1e-16, rtol=1e-15)
    if hit >= end:
        return [height(end), speed(end)]
    return _by_roots(0.0, -REBOUND * speed(hit), end - hit)


_pk = [[-ABSORBED, 0, 0], [ABSORBED, -ELIMINATED - OUT, BACK], [0, OUT, -BACK]]
PID = Hybrid(
    "PID at 100 Hz, 8 s", plant, pid, [0.0, 0.0], [0.0, 0.0, 0.0], 8.0, PERIOD,
    _by_exponentials([[0, 1], [-1, -0.4]], [0, 1], pid(np), [0, 0], [0, 0, 0], PERIOD, 800),
)  # fmt: skip
DOSES = Hybrid(
    "30 doses, 10 days", compartments, doses, [0.0, 0.0, 0.0], [100.0], 240.0, 8.0,
    _by_exponentials(_pk, [0, 0, 0], doses(np), [0, 0, 0], [100.0], 8.0, 30),
)  # fmt: skip
BALL = Hybrid(
    "bouncing ball, 12 s",
    falling,
    bounces,
    [2.0, 0.0],
    [0.0],
    12.0,
    None,
    _by_roots(2.0, 0.0, 12.0),
)

HYBRIDS = (PID, DOSES, BALL)


@functools.cache
def in_place_with_discrete(fun, n):
    """The compiled function ``(t, y, d, out)`` of a Hybrid."""
    inner = njit(fun)

    @njit
    def into(t, y, d, out):
        found = inner(t, y, d)
        for i in range(n):
            out[i] = found[i]

    return into
