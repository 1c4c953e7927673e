"""Stiff problems, with the end states of the IVP test set (Mazzia and Magherini, release 2.4)."""

from typing import NamedTuple

import numpy as np

from .problem import Problem

END = {
    "Robertson": [0.2083340149701255e-07, 0.8333360770334713e-13, 0.9999999791665050],
    "van der Pol": [0.1706167732170483e1, -0.8928097010247975],
    "HIRES": [
        0.7371312573325668e-3, 0.1442485726316185e-3, 0.5888729740967575e-4, 0.1175651343283149e-2,
        0.2386356198831331e-2, 0.6238968252742796e-2, 0.2849998395185769e-2, 0.2850001604814231e-2,
    ],
    "OREGO": [0.1000814870318523e1, 0.1228178521549917e4, 0.1320554942846706e3],
}  # fmt: skip


class Stiff(NamedTuple):
    """A Problem, the least size of a component that counts, and the end, None if not published."""

    problem: Problem
    floor: float
    end: list | None


def robertson(t, y):
    a, b, c = y
    return [-0.04 * a + 1e4 * b * c, 0.04 * a - 1e4 * b * c - 3e7 * b * b, 3e7 * b * b]


def van_der_pol(t, y):
    return [y[1], ((1.0 - y[0] ** 2) * y[1] - y[0]) / 1e-6]


def hires(t, y):
    a, b, c, d, e, f, g, h = y
    return [
        -1.71 * a + 0.43 * b + 8.32 * c + 0.0007,
        1.71 * a - 8.75 * b,
        -10.03 * c + 0.43 * d + 0.035 * e,
        8.32 * b + 1.71 * c - 1.12 * d,
        -1.745 * e + 0.43 * f + 0.43 * g,
        -280 * f * h + 0.69 * d + 1.71 * e - 0.43 * f + 0.69 * g,
        280 * f * h - 1.81 * g,
        -280 * f * h + 1.81 * g,
    ]


def orego(t, y):
    a, b, c = y
    return [
        77.27 * (b + a * (1 - 8.375e-6 * a - b)),
        (c - (1 + a) * b) / 77.27,
        0.161 * (a - c),
    ]


def brusselator_into(t, y, d):
    """Reaction and diffusion on (0, 1); concentrations of the two by turns, 1 and 3 at the ends."""
    n = len(y) // 2
    rate = (n + 1) ** 2 / 50.0
    for i in range(n):
        u, v = y[2 * i], y[2 * i + 1]
        left, right = (1.0 if i == 0 else y[2 * i - 2]), (1.0 if i == n - 1 else y[2 * i + 2])
        d[2 * i] = 1.0 + u * u * v - 4.0 * u + rate * (left - 2.0 * u + right)
        left, right = (3.0 if i == 0 else y[2 * i - 1]), (3.0 if i == n - 1 else y[2 * i + 3])
        d[2 * i + 1] = 3.0 * u - u * u * v + rate * (left - 2.0 * v + right)


def brusselator(n):
    """n components."""

    def fun(t, y):
        d = np.empty_like(y)
        brusselator_into(t, y, d)
        return d

    y0, x = np.full(n, 3.0), np.arange(1, n // 2 + 1) / (n // 2 + 1)
    y0[::2] = 1.0 + np.sin(2.0 * np.pi * x)
    name = f"Brusselator, n = {n}"
    return Stiff(Problem(name, fun, (0.0, 10.0), y0, (), into=brusselator_into), 1.0, None)


def _published(name, fun, t_end, y0, floor):
    return Stiff(Problem(name, fun, (0.0, t_end), y0, ()), floor, END[name])


STIFF = (
    _published("Robertson", robertson, 1e11, [1.0, 0.0, 0.0], 1e-10),
    _published("van der Pol", van_der_pol, 2.0, [2.0, 0.0], 1e-2),
    _published("HIRES", hires, 321.8122, [1.0, 0, 0, 0, 0, 0, 0, 0.0057], 1e-4),
    _published("OREGO", orego, 360.0, [1.0, 2.0, 3.0], 1e-2),
    brusselator(40),
    brusselator(200),
)
