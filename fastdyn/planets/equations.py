"""The attraction of point masses, for any method: y = [q_0, ..., q_n, v_0, ..., v_n]."""

import numpy as np


def rhs(t, y, G, *masses):
    """The rates of places and velocities, three numbers for each body."""
    n = len(masses)
    pulls = [0.0] * (3 * n)
    for i in range(n):
        for j in range(i):
            x = y[3 * j] - y[3 * i]
            z = y[3 * j + 2] - y[3 * i + 2]
            w = y[3 * j + 1] - y[3 * i + 1]
            rr = x * x + w * w + z * z
            pull = G / (rr * np.sqrt(rr))
            for c, d in enumerate((x, w, z)):
                pulls[3 * i + c] = pulls[3 * i + c] + masses[j] * pull * d
                pulls[3 * j + c] = pulls[3 * j + c] - masses[i] * pull * d
    return [*y[3 * n :], *pulls]


def energy(t, y, G, *masses):
    """Kinetic and potential energy."""
    n = len(masses)
    total = 0.0
    for i in range(n):
        u = y[3 * (n + i)]
        v = y[3 * (n + i) + 1]
        w = y[3 * (n + i) + 2]
        total = total + 0.5 * masses[i] * (u * u + v * v + w * w)
        for j in range(i):
            x = y[3 * j] - y[3 * i]
            z = y[3 * j + 2] - y[3 * i + 2]
            w = y[3 * j + 1] - y[3 * i + 1]
            total = total - G * masses[i] * masses[j] / np.sqrt(x * x + w * w + z * z)
    return total


def angular_momentum(t, y, G, *masses):
    """The length of the angular momentum about the origin."""
    n = len(masses)
    a = 0.0
    b = 0.0
    c = 0.0
    for i in range(n):
        x = y[3 * i]
        w = y[3 * i + 1]
        z = y[3 * i + 2]
        u = y[3 * (n + i)]
        v = y[3 * (n + i) + 1]
        s = y[3 * (n + i) + 2]
        a = a + masses[i] * (w * s - z * v)
        b = b + masses[i] * (z * u - x * s)
        c = c + masses[i] * (x * v - w * u)
    return np.sqrt(a * a + b * b + c * c)
