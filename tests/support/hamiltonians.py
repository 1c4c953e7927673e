"""Motions of H = T(p) + V(q) by two functions, with their energies."""

import math

import numpy as np


def velocity(t, p, c):
    """Of a relativistic particle, H = c sqrt(c² + p²) - cos q."""
    return [c * p[0] / math.sqrt(c * c + p[0] * p[0])]


def force(t, q, c):
    return [-math.sin(q[0])]


def pull(depth):
    return lambda t, q, c: [-depth * math.sin(q[0])]


def energy(t, y, c):
    return c * math.sqrt(c * c + y[1] * y[1]) - math.cos(y[0])


def eaten(t, p):
    """Lotka and Volterra's predators and prey in logarithms, H = exp p - p + exp q - 2 q."""
    return [np.exp(p[0]) - 1.0]


def born(t, q):
    return [2.0 - np.exp(q[0])]


def balance(t, y):
    return np.exp(y[1]) - y[1] + np.exp(y[0]) - 2.0 * y[0]


START = ([1.2], [0.4])

GIVEN = {"args": (0.7,)}


def whole(t, y, c):
    return [*velocity(t, y[1:], c), *force(t, y[:1], c)]
