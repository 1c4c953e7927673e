"""Motions with impacts, and what is known of them."""

import math

import numpy as np

G = 9.81


def falling(t, y, e):
    return [y[1], -G]


def ground(t, y, e):
    return y[0]


ground.direction = -1


def bounce(t, y, e):
    return [0.0, -e * y[1]]


def bounce_where_it_is(t, y, e):
    y[1] = -e * y[1]
    return y


def impacts(e, n):
    """Times of the first n impacts of a ball dropped from 1 m."""
    first = math.sqrt(2.0 / G)
    return first * (1.0 + 2.0 * np.cumsum(np.r_[0.0, e ** np.arange(1, n)]))


def last_impact(e):
    """The time that the impacts of a ball dropped from 1 m converge to."""
    return math.sqrt(2.0 / G) * (1.0 + e) / (1.0 - e)


def ball_after(e, t):
    """State at times between the impacts of a ball dropped from 1 m, shape (2, n_times)."""
    t = np.atleast_1d(t)
    times = np.r_[-impacts(1.0, 1)[0], impacts(e, 200)]
    k = np.searchsorted(times, t) - 1
    s, v = t - times[k], math.sqrt(2.0 * G) * e**k
    return np.array([v * s - 0.5 * G * s * s, v - G * s])


def marked(function, **attributes):
    """Another event like this one, with other attributes."""

    def event(t, y, *args):
        return function(t, y, *args)

    vars(event).update(vars(function), **attributes)
    return event


def flight(t, h, v, g, e):
    """Height, speed, and the times of impacts, of a ball thrown up; real or complex numbers."""
    heights, speeds, impacts, begin = [], [], [], 0.0
    for time in t:
        while True:
            end = begin + (v + (v * v + 2 * g * h) ** 0.5) / g
            if end.real > time:
                break
            impacts.append(end)
            begin, h, v = end, 0.0, -e * (v - g * (end - begin))
        s = time - begin
        heights.append(h + v * s - 0.5 * g * s * s)
        speeds.append(v - g * s)
    return np.array([heights, speeds]), np.array(impacts)
