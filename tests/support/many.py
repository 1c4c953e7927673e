"""Motions of many trajectories: orbits by speed, oscillators by stiffness."""

import numpy as np


def orbit(t, w, GM):
    x, y, vx, vy = w
    r = np.sqrt(x * x + y * y)
    return [vx, vy, -GM * x / r**3, -GM * y / r**3]


def launch(speeds):
    y0 = np.zeros((len(speeds), 4))
    y0[:, 0], y0[:, 3] = 1.0, speeds
    return y0


def oscillator(t, w, k):
    x, v = w
    return [v, -k * x]


def crossing(t, w, k):
    return w[0]
