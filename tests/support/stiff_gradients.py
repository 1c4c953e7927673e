"""Stiff systems with parameters, and their derivatives by hand, also for complex numbers."""

import numpy as np


def van_der_pol(t, y, mu):
    return [y[1], mu * ((1 - y[0] ** 2) * y[1] - y[0])]


def robertson(t, y, a, b, c):
    x, z, w = y
    return [-a * x + c * z * w, a * x - c * z * w - b * z * z, b * z * z]


def forced(t, y, a, b):
    """A law that changes at a kink, and depends on time."""
    pull = a * max(y[0] - np.cos(b * t), 0.1 * (y[0] - np.cos(b * t)))
    return [-pull + y[1] * np.sin(t), -y[1] * y[0] ** 2]


def slopes(name, t, y, args):
    """df/dy and df/dt by hand, real or complex."""
    if name == "van der Pol":
        (mu,) = args
        rows = [[0, 1], [mu * (-2 * y[0] * y[1] - 1), mu * (1 - y[0] ** 2)]]
        return np.array(rows, complex), 0.0
    if name == "Robertson":
        a, b, c = args
        rows = [[-a, c * y[2], c * y[1]], [a, -c * y[2] - 2 * b * y[1], -c * y[1]]]
        return np.array([*rows, [0, 2 * b * y[1], 0]], complex), 0.0
    a, b = args
    a = a if (y[0] - np.cos(b * t)).real > 0 else 0.1 * a
    rows = [[-a, np.sin(t)], [-2 * y[0] * y[1], -(y[0] ** 2)]]
    by_time = [-a * b * np.sin(b * t) + y[1] * np.cos(t), 0.0]
    return np.array(rows, complex), np.array(by_time)


def on_complex(fun):
    """A system for complex numbers, which decides by real parts."""

    def own(t, y, a, b):
        gap = y[0] - np.cos(b * t)
        return [-a * (gap if gap.real > 0 else 0.1 * gap) + y[1] * np.sin(t), -y[1] * y[0] ** 2]

    return own if fun is forced else fun


SYSTEMS = {
    "van der Pol": (van_der_pol, (0, 1.5), [2.0, 0.0], (1000.0,)),
    "Robertson": (robertson, (0, 40), [1.0, 0.0, 0.0], (0.04, 3e7, 1e4)),
    "forced": (forced, (0, 2), [0.3, 1.0], (50.0, 2.0)),
}
