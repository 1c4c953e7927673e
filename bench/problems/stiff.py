"""Stiff problems, with the end states of the IVP test set (Mazzia and Magherini, release 2.4).

E5 ends at 1e11, at the state of E. Hairer's test set, instead of 1e13.  y2 = y3 + y4 holds always,
and a rounding error in it is never damped: 1e-25 is 1e-5 of y2 at 1e11, but 1e-3 at 1e13, where the
end state of release 2.4 is as far from it.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from .problem import Problem

END = {
    "Robertson": [0.2083340149701255e-07, 0.8333360770334713e-13, 0.9999999791665050],
    "van der Pol": [0.1706167732170483e1, -0.8928097010247975],
    "HIRES": [
        0.7371312573325668e-3, 0.1442485726316185e-3, 0.5888729740967575e-4, 0.1175651343283149e-2,
        0.2386356198831331e-2, 0.6238968252742796e-2, 0.2849998395185769e-2, 0.2850001604814231e-2,
    ],
    "OREGO": [0.1000814870318523e1, 0.1228178521549917e4, 0.1320554942846706e3],
    "E5": [0.0, 0.1019258256766029e-19, 0.1019258256766029e-19, 0.0],
    "pollution": [
        0.5646255480022769e-1, 0.1342484130422339, 0.4139734331099427e-8, 0.5523140207484359e-2,
        0.2018977262302196e-6, 0.1464541863493966e-6, 0.7784249118997964e-1, 0.3245075353396018,
        0.7494013383880406e-2, 0.1622293157301561e-7, 0.1135863833257075e-7, 0.2230505975721359e-2,
        0.2087162882798630e-3, 0.1396921016840158e-4, 0.8964884856898295e-2, 0.4352846369330103e-17,
        0.6899219696263405e-2, 0.1007803037365946e-3, 0.1772146513969984e-5, 0.5682943292316392e-4,
    ],
    "ring modulator": [
        -0.2339057358486745e-1, -0.7367485485540825e-2, 0.2582956709291169, -0.4064465721283450,
        -0.4039455665149794, 0.2607966765422943, 0.1106761861269975, 0.2939904342435596e-6,
        -0.2840029933642329e-7, 0.7267198267264553e-3, 0.7929487196960840e-3,
        -0.7255283495698965e-3, -0.7941401968526521e-3, 0.7088495416976114e-4,
        0.2390059075236570e-4,
    ],
}  # fmt: skip


class Stiff(NamedTuple):
    """A stiff Problem.

    Attributes
    ----------
    problem : Problem
    floor : float or ndarray
        The least size of a component that counts, of all or of each.
    end : array_like or None
        The end state, None if Radau at rtol 1e-12 is to find it.
    band : tuple of int, optional
        Diagonals of the Jacobian below and above the main one.
    jacobian : callable, optional
        ``jacobian(t, y, j)``, the Jacobian's nonzero elements written into j.
    mass : ndarray, optional
        M of M y' = f(t, y).
    long : bool
        Whether a loop in Python takes minutes, and is left out.
    """

    problem: Problem
    floor: float
    end: Any
    band: tuple | None = None
    jacobian: Callable | None = None
    mass: Any = None
    long: bool = False


def robertson(t, y):
    a, b, c = y
    return [-0.04 * a + 1e4 * b * c, 0.04 * a - 1e4 * b * c - 3e7 * b * b, 3e7 * b * b]


def robertson_jacobian(t, y, j):
    _, b, c = y
    j[0, 0], j[0, 1], j[0, 2] = -0.04, 1e4 * c, 1e4 * b
    j[1, 0], j[1, 1], j[1, 2] = 0.04, -1e4 * c - 6e7 * b, -1e4 * b
    j[2, 1] = 6e7 * b


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


def e5(t, y):
    """Pyrolysis: W. Enright, T. Hull and B. Lindberg, BIT 15 (1975)."""
    a, b, c, d = y
    first, second, third, fourth = 7.89e-10 * a, 1.1e7 * a * c, 1.13e9 * b * c, 1.13e3 * d
    b_rate, d_rate = first - third, second - fourth
    return [-first - second, b_rate, b_rate - d_rate, d_rate]


def pollution(t, y):
    """25 reactions of 20 pollutants: J. Verwer, SIAM J. Sci. Comput. 15 (1994)."""
    r1, r2, r3 = 0.35 * y[0], 26.6 * y[1] * y[3], 12300.0 * y[4] * y[1]
    r4, r5, r6 = 0.00086 * y[6], 0.00082 * y[6], 15000.0 * y[6] * y[5]
    r7, r8, r9 = 0.00013 * y[8], 24000.0 * y[8] * y[5], 16500.0 * y[10] * y[1]
    r10, r11, r12 = 9000.0 * y[10] * y[0], 0.022 * y[12], 12000.0 * y[9] * y[1]
    r13, r14, r15 = 1.88 * y[13], 16300.0 * y[0] * y[5], 4.8e6 * y[2]
    r16, r17, r18 = 0.00035 * y[3], 0.0175 * y[3], 1e8 * y[15]
    r19, r20, r21 = 4.44e11 * y[15], 1240.0 * y[16] * y[5], 2.1 * y[18]
    r22, r23, r24, r25 = 5.78 * y[18], 0.0474 * y[0] * y[3], 1780.0 * y[18] * y[0], 3.12 * y[19]
    return [
        r2 + r3 + r9 + r11 + r12 + r22 + r25 - r1 - r10 - r14 - r23 - r24,
        r1 + r21 - r2 - r3 - r9 - r12,
        r1 + r17 + r19 + r22 - r15,
        r15 - r2 - r16 - r17 - r23,
        2.0 * r4 + r6 + r7 + r13 + r20 - r3,
        r3 + 2.0 * r18 - r6 - r8 - r14 - r20,
        r13 - r4 - r5 - r6,
        r4 + r5 + r6 + r7,
        -r7 - r8,
        r7 + r9 - r12,
        r8 + r11 - r9 - r10,
        r9,
        r10 - r11,
        r12 - r13,
        r14,
        r16 - r18 - r19,
        -r20,
        r20,
        r23 + r25 - r21 - r22 - r24,
        r24 - r25,
    ]


@njit
def diode(voltage):
    """The current; infinite, not an error, at a voltage that a trial step makes too large."""
    return 40.67286402e-9 * (np.exp(17.7493332 * voltage) - 1.0)


def ring_modulator(t, y):
    """Seven voltages and eight currents: E. Horneber (1985), with capacities of 2 pF at diodes."""
    v1, v2, v3, v4, v5, v6, v7, i1, i2, i3, i4, i5, i6, i7, i8 = y
    low = 0.5 * math.sin(2e3 * math.pi * t)
    high = v7 + 2.0 * math.sin(2e4 * math.pi * t)
    d1, d2 = diode(v3 - v5 - high), diode(v6 - v4 - high)
    d3, d4 = diode(v4 + v5 + high), diode(high - v3 - v6)
    return [
        (i1 + 0.5 * (i4 - i3) + i7 - v1 / 25e3) / 1.6e-8,
        (i2 + 0.5 * (i6 - i5) + i8 - v2 / 25e3) / 1.6e-8,
        (i3 - d1 + d4) / 2e-12,
        (d2 - d3 - i4) / 2e-12,
        (i5 + d1 - d3) / 2e-12,
        (d4 - d2 - i6) / 2e-12,
        (d1 + d2 - d3 - d4 - v7 / 50.0) / 1e-8,
        -v1 / 4.45,
        -v2 / 4.45,
        (0.5 * v1 - v3 - 17.3 * i3) / 5e-4,
        (v4 - 0.5 * v1 - 17.3 * i4) / 5e-4,
        (0.5 * v2 - v5 - 17.3 * i5) / 5e-4,
        (v6 - 0.5 * v2 - 17.3 * i6) / 5e-4,
        (low - v1 - 86.3 * i7) / 2e-3,
        (-v2 - 636.3 * i8) / 2e-3,
    ]


def spring_pendulum(t, y):
    """A mass on a metre of spring, k / m = 1e6 / s^2, its length critically damped."""
    x, z, u, w = y
    length = math.sqrt(x * x + z * z)
    pull = (1e6 * (length - 1.0) + 2e3 * (x * u + z * w) / length) / length
    return [u, w, -pull * x, -9.81 - pull * z]


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


def brusselator_jacobian(t, y, j):
    n = len(y) // 2
    rate = (n + 1) ** 2 / 50.0
    for i in range(0, 2 * n, 2):
        u, v = y[i], y[i + 1]
        j[i, i], j[i, i + 1] = 2.0 * u * v - 4.0 - 2.0 * rate, u * u
        j[i + 1, i], j[i + 1, i + 1] = 3.0 - 2.0 * u * v, -u * u - 2.0 * rate
    for i in range(2 * n - 2):
        j[i, i + 2] = j[i + 2, i] = rate


def brusselator(n):
    """n components."""

    def fun(t, y):
        d = np.empty_like(y)
        brusselator_into(t, y, d)
        return d

    y0, x = np.full(n, 3.0), np.arange(1, n // 2 + 1) / (n // 2 + 1)
    y0[::2] = 1.0 + np.sin(2.0 * np.pi * x)
    name = f"Brusselator, n = {n}"
    problem = Problem(name, fun, (0.0, 10.0), y0, (), into=brusselator_into)
    return Stiff(problem, 1.0, None, band=(2, 2), jacobian=brusselator_jacobian)


def _published(name, fun, t_end, y0, floor, jacobian=None):
    return Stiff(Problem(name, fun, (0.0, t_end), y0, ()), floor, END[name], jacobian=jacobian)


POLLUTED = [0, 0.2, 0, 0.04, 0, 0, 0.1, 0.3, 0.01, 0, 0, 0, 0, 0, 0, 0, 0.007, 0, 0, 0]
STIFF = (
    _published("Robertson", robertson, 1e11, [1.0, 0.0, 0.0], 1e-10, robertson_jacobian),
    _published("van der Pol", van_der_pol, 2.0, [2.0, 0.0], 1e-2),
    _published("HIRES", hires, 321.8122, [1.0, 0, 0, 0, 0, 0, 0, 0.0057], 1e-4),
    _published("OREGO", orego, 360.0, [1.0, 2.0, 3.0], 1e-2),
    _published("E5", e5, 1e11, [1.76e-3, 0.0, 0.0, 0.0], 1e-22),
    _published("pollution", pollution, 60.0, POLLUTED, 1e-9),
    _published("ring modulator", ring_modulator, 1e-3, [0.0] * 15, 1e-4)._replace(long=True),
    Stiff(
        Problem("spring pendulum", spring_pendulum, (0.0, 10.0), [1.0, 0.0, 0.0, 0.0], ()),
        1e-2,
        None,
    ),
    brusselator(40),
    brusselator(200),
)
