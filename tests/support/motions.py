"""Equations of motion whose steps are compared."""

import math

import numpy as np


def forced(t, y):
    """q'' of time and, nonlinearly, of q, solved by q = cos t."""
    return [y[1], math.sin(math.cos(t)) - math.cos(t) - math.sin(y[0])]


def satellite(t, w):
    x, y, vx, vy = w
    r3 = (x * x + y * y) ** 1.5
    return [vx, vy, -x / r3, -y / r3]


def projectile(t, w):
    vx, vy, vz = w[3:]
    s = 0.5 * math.sqrt(vx * vx + vy * vy + vz * vz)
    return [vx, vy, vz, -s * vx, -s * vy, -s * vz - 9.81]


def pendulum(t, y):
    return y[1], -9.81 * math.sin(y[0])


def lorenz(t, w):
    x, y, z = w
    return 10 * (y - x), x * (28 - z) - y, x * y - 8 / 3 * z


def van_der_pol(t, y):
    return [y[1], (1 - y[0] ** 2) * y[1] - y[0]]


def lotka_volterra(t, y):
    return [1.5 * y[0] - y[0] * y[1], y[0] * y[1] - 3 * y[1]]


def arenstorf(t, w):
    x, y, vx, vy = w
    m = 0.012277471
    d1, d2 = ((x + m) ** 2 + y * y) ** 1.5, ((x - 1 + m) ** 2 + y * y) ** 1.5
    ax = x + 2 * vy - (1 - m) * (x + m) / d1 - m * (x - 1 + m) / d2
    ay = y - 2 * vx - (1 - m) * y / d1 - m * y / d2
    return vx, vy, ax, ay


def building(t, y):
    k, d, w, height = 100.0, 0.1, 9.0, 10.0
    top = 2 * k * (y[1] - y[0] - height)
    return [
        y[2],
        y[3],
        -2 * k * (y[0] - d * math.sin(w * t) - height) + top - 9.81,
        -top - 9.81,
    ]


def brusselator(t, y):
    return np.array([1 + y[0] ** 2 * y[1] - 4 * y[0], 3 * y[0] - y[0] ** 2 * y[1]])


def growth(t, y):
    return 0.3 * y


PROBLEMS = {
    "circle": (satellite, (0, 20), [1, 0, 0, 1]),
    "ellipse": (satellite, (0, 10), [1, 0, 0, 1.2]),
    "projectile": (projectile, (0, 5), [0, 0, 0, 10, 10, 20]),
    "pendulum": (pendulum, (0, 5), [1.0, 0.0]),
    "Lorenz": (lorenz, (0, 1), [1.0, 1.0, 1.0]),
    "van der Pol": (van_der_pol, (0, 10), [2.0, 0.0]),
    "Lotka-Volterra": (lotka_volterra, (0, 10), [10.0, 5.0]),
    "Arenstorf": (arenstorf, (0, 5), [0.994, 0, 0, -2.00158510637908252]),
    "building": (building, (0, 5), [10 - 0.0981, 20 - 0.14715, 0, 0]),
    "Brusselator": (brusselator, (0, 10), [1.5, 3.0]),
    "growth": (growth, (0, 10), [1.0, 2.0]),
    "forced": (forced, (0, 10), [1.0, 0.0]),
}
