"""The non-stiff problems of DETEST, t from 0 to 20, and their reversals.

T. E. Hull, W. H. Enright, B. M. Fellen and A. E. Sedgwick, "Comparing numerical methods for
ordinary differential equations", SIAM J. Numer. Anal. 9 (1972), 603-637.  The five bodies of C5 are
left to the Pleiades.
"""

import math

import numpy as np


def radioactive(t, y):
    return [-y[0], *[y[i - 1] - y[i] for i in range(1, len(y) - 1)], y[-2]]


def faster(t, y):
    n = len(y)
    return [-y[0], *[i * y[i - 1] - (i + 1) * y[i] for i in range(1, n - 1)], (n - 1) * y[n - 2]]


def chain(t, y):
    z = [0.0, *y, 0.0]
    return [z[i - 1] - 2 * z[i] + z[i + 1] for i in range(1, len(z) - 1)]


def torus(t, y):
    r = np.sqrt(y[0] ** 2 + y[1] ** 2)
    return [-y[1] - y[0] * y[2] / r, y[0] - y[1] * y[2] / r, y[0] / r]


def orbit(t, y):
    r3 = (y[0] * y[0] + y[1] * y[1]) ** 1.5
    return [y[2], y[3], -y[0] / r3, -y[1] / r3]


def bessel(t, y):
    return [y[1], -(y[1] / (t + 1) + (1 - 0.25 / (t + 1) ** 2) * y[0])]


def first(n):
    return [1.0, *[0.0] * (n - 1)]


SYSTEMS = {
    "A1": (lambda t, y: [-y[0]], [1.0]),
    "A2": (lambda t, y: [-(y[0] ** 3) / 2], [1.0]),
    "A3": (lambda t, y: [y[0] * np.cos(t)], [1.0]),
    "A4": (lambda t, y: [y[0] / 4 * (1 - y[0] / 20)], [1.0]),
    "A5": (lambda t, y: [(y[0] - t) / (y[0] + t)], [4.0]),
    "B1": (lambda t, y: [2 * (y[0] - y[0] * y[1]), -(y[1] - y[0] * y[1])], [1.0, 3.0]),
    "B2": (lambda t, y: [-y[0] + y[1], y[0] - 2 * y[1] + y[2], y[1] - y[2]], [2.0, 0.0, 1.0]),
    "B3": (lambda t, y: [-y[0], y[0] - y[1] ** 2, y[1] ** 2], [1.0, 0.0, 0.0]),
    "B4": (torus, [3.0, 0.0, 0.0]),
    "B5": (lambda t, y: [y[1] * y[2], -y[0] * y[2], -0.51 * y[0] * y[1]], [0.0, 1.0, 1.0]),
    "C1": (radioactive, first(10)),
    "C2": (faster, first(10)),
    "C3": (chain, first(10)),
    "C4": (chain, first(51)),
    **{
        f"D{i}": (orbit, [1 - e, 0.0, 0.0, math.sqrt((1 + e) / (1 - e))])
        for i, e in enumerate((0.1, 0.3, 0.5, 0.7, 0.9), 1)
    },
    "E1": (bessel, [0.6713967071418030, 0.09540051444747446]),
    "E2": (lambda t, y: [y[1], (1 - y[0] ** 2) * y[1] - y[0]], [2.0, 0.0]),
    "E3": (lambda t, y: [y[1], y[0] ** 3 / 6 - y[0] + 2 * np.sin(2.78535 * t)], [0.0, 0.0]),
    "E4": (lambda t, y: [y[1], 0.032 - 0.4 * y[1] ** 2], [30.0, 0.0]),
    "E5": (lambda t, y: [y[1], np.sqrt(1 + y[1] ** 2) / (25 - t)], [0.0, 0.0]),
}
UNSTABLE = frozenset(("A1", "B2", "B3", "C1", "C2", "C3", "C4", "E2"))  # backwards in time


def problems(end_of):
    """Yield (name, fun, t_span, y0); ``end_of(fun, t_span, y0)`` is the exact end state."""
    for name, (fun, y0) in SYSTEMS.items():
        yield name, fun, (0.0, 20.0), y0
        if name not in UNSTABLE:
            yield f"{name} backwards", fun, (20.0, 0.0), list(end_of(fun, (0.0, 20.0), y0))
