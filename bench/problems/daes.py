"""Equations F(t, y, y') = 0 of index 1 with published solutions.

F. Mazzia and C. Magherini, "Test Set for Initial Value Problem Solvers", release 2.4, Bari 2008.
"""

import math
from typing import Any, NamedTuple

import numpy as np


class Dae(NamedTuple):
    """F(t, y, y') = 0 from 0 to `end`, and its end state.

    `floor` is the least size of a component that counts, of all or of each.
    """

    name: str
    F: Any
    y0: list
    yp0: list
    end: float
    solution: list
    floor: Any


def robertson(t, y, yp):
    slow, fast, faster = 0.04 * y[0], 1e4 * y[1] * y[2], 3e7 * y[1] ** 2
    return [yp[0] + slow - fast, yp[1] - slow + fast + faster, y[0] + y[1] + y[2] - 1]


def akzo_nobel(t, y, yp):
    """Chemical Akzo Nobel: six species, one in equilibrium."""
    r1 = 18.7 * y[0] ** 4 * np.sqrt(y[1])
    r2 = 0.58 * y[2] * y[3]
    r3 = 0.58 / 34.4 * y[0] * y[4]
    r4 = 0.09 * y[0] * y[3] ** 2
    r5 = 0.42 * y[5] ** 2 * np.sqrt(y[1])
    inflow = 3.3 * (0.9 / 737 - y[1])
    return [
        yp[0] + 2 * r1 - r2 + r3 + r4,
        yp[1] + 0.5 * r1 + r4 + 0.5 * r5 - inflow,
        yp[2] - r1 + r2 - r3,
        yp[3] + r2 - r3 + 2 * r4,
        yp[4] - r2 + r3 - r5,
        115.83 * y[0] * y[3] - y[5],
    ]


def transistor(t, y, yp):
    """Transistor amplifier: eight voltages, capacitors between pairs of nodes."""
    C, U, R0, R = 1e-6, 6.0, 1000.0, 9000.0

    def current(u):
        return 1e-6 * (math.exp(u / 0.026) - 1)

    first, second = current(y[1] - y[2]), current(y[4] - y[5])
    c1, c3, c5 = C * (yp[1] - yp[0]), 3 * C * (yp[4] - yp[3]), 5 * C * (yp[7] - yp[6])
    return [
        (0.1 * math.sin(200 * math.pi * t) - y[0]) / R0 + c1,
        U / R - y[1] * 2 / R - 0.01 * first - c1,
        first - y[2] / R - 2 * C * yp[2],
        (U - y[3]) / R - 0.99 * first + c3,
        U / R - y[4] * 2 / R - 0.01 * second - c3,
        second - y[5] / R - 4 * C * yp[5],
        (U - y[6]) / R - 0.99 * second + c5,
        -y[7] / R - c5,
    ]


ROBERTSON = Dae(
    "Robertson", robertson, [1, 0, 0], [-0.04, 0.04, 0], 1e11,
    [0.2083340149701255e-7, 0.8333360770334713e-13, 0.9999999791665050],
    [1e-6, 1e-11, 1e-6],
)  # fmt: skip
_start = [0.444, 0.00123, 0, 0.007, 0, 115.83 * 0.444 * 0.007]
AKZO_NOBEL = Dae(
    "chemical Akzo Nobel", akzo_nobel, _start, [-r for r in akzo_nobel(0, _start, [0] * 6)], 180,
    [0.1150794920661702, 0.1203831471567715e-2, 0.1611562887407974, 0.3656156421249283e-3,
     0.1708010885264404e-1, 0.4873531310307455e-2],
    1e-4,
)  # fmt: skip
TRANSISTOR = Dae(
    "transistor amplifier", transistor, [0, 3, 3, 6, 3, 3, 6, 0],
    [51.338775, 51.338775, -3 / (2e-6 * 9000), -24.9757667, -24.9757667, -3 / (4e-6 * 9000),
     -10.00564453, -10.00564453], 0.2,
    [-0.5562145012262709e-2, 3.006522471903042, 2.849958788608128, 2.926422536206241,
     2.704617865010554, 2.761837778393145, 4.770927631616772, 1.236995868091548],
    1.0,
)  # fmt: skip

DAES = (ROBERTSON, AKZO_NOBEL, TRANSISTOR)
