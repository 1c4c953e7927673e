"""A linear DAE of index 1 with its solution."""

import numpy as np


def linear(t, y, yp):
    """An equation and a constraint; see `linear_solution`."""
    return [yp[0] + y[0] - y[1], y[0] + y[1] - np.sin(t)]


def linear_solution(t):
    """y0' = -2 y0 + sin t from y0(0) = 1, y1 = sin t - y0: (y, y')."""
    decay, sin, cos = 1.2 * np.exp(-2 * t), np.sin(t), np.cos(t)
    y = decay + 0.4 * sin - 0.2 * cos
    yp = -2 * decay + 0.4 * cos + 0.2 * sin
    return np.array([y, sin - y]), np.array([yp, cos - yp])
