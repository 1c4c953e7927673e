"""Kepler's equation, for the exact solution of the satellite."""

import math

import numpy as np


def eccentric_anomaly(mean_anomaly, e):
    """
    Solve Kepler's equation u - e sin u = M for u, continuous in M; both in radians, of any size.

    A negative eccentricity, -1 < e < 1, counts M and u from the far end of the ellipse.

    For 0 <= M <= pi and e >= 0 the residual is convex, so Newton's method started above the root
    falls onto it without overshooting; min(M + e, M/(1 - e), pi) is above the root.
    """
    shift = 0.0 if e >= 0.0 else math.pi
    e = abs(e)
    M = np.asarray(mean_anomaly, float) + shift
    turns = 2.0 * math.pi * np.round(M / (2.0 * math.pi))
    half = np.abs(M - turns)
    u = np.minimum(np.minimum(half + e, half / (1.0 - e)), math.pi)
    for _ in range(200):
        change = (u - e * np.sin(u) - half) / (1.0 - e * np.cos(u))
        u = u - change
        if np.all(np.abs(change) <= 2.0 * np.finfo(float).eps * (1.0 + u)):
            break
    return turns + np.copysign(u, M - turns) - shift
