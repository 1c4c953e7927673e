"""Delay equations of published test sets, with their exact solutions.

DDETST: W. H. Enright and H. Hayashi, "The evaluation of numerical software for delay differential
equations", in The Quality of Numerical Software, 1997.  Of the state: those which C. A. H. Paul, "A
test set of functional differential equations", Manchester, Numerical Analysis Report 243, 1994,
takes from Neves, and from Feldstein and Neves, SIAM J. Numer. Anal. 21 (1984).
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np


class Published(NamedTuple):
    """An equation ``y' = fun(t, y, past)`` from t0 to tf, and its solution, also the history."""

    name: str
    fun: Callable
    t0: float
    tf: float
    solution: Callable
    neutral: bool = False
    history: Any = None  # where the history is not the solution before the start
    jumps: tuple = ()  # of the history


def _b2(t, y, past):
    return [(1.0 if past(t / 2)[0] < 0 else -1.0) - y[0]]


def _b2_solution(t):
    if t <= 2 * np.log(2):
        return [2 * np.exp(-t) - 1]
    return [1 - 6 * np.exp(-t) if t <= 2 * np.log(6) else 66 * np.exp(-t) - 1]


def _d1(t, y, past):
    early = np.exp(1 - y[1])
    return [y[1], -past(early)[1] * y[1] ** 2 * early]


def _f1(t, y, past):
    s = t / 2
    power = past(s)[0] ** (2 * np.cos(t))
    slope = past.derivative(s)[0]
    return [2 * np.cos(2 * t) * power + np.log(slope) - np.log(2 * np.cos(t)) - np.sin(t)]


def _f2_solution(t):
    """A piece for each interval from (1 - 2^-i) / 2 on, joined where the pieces meet."""
    b = c = k = 0.0
    i = 0
    while t > (1 - 0.5 ** (i + 1)) / 2:
        i += 1
        x = (1 - 0.5**i) / 2
        b_old, c_old, k_old = b, c, k
        b = 2 * (4.0 ** (i - 1) + b_old)
        c = -(4.0 ** (i - 2)) - b_old / 2 + c_old
        before = np.exp(-(4.0 ** (i - 1)) * x**2 + b_old * x + c_old) / 2.0 ** (i - 1) + k_old
        k = before - np.exp(-(4.0**i) * x**2 + b * x + c) / 2.0**i
    return [np.exp(-(4.0**i) * t**2 + b * t + c) / 2.0**i + k]


def _f3(weight):
    def fun(t, y, past):
        early = 0.5 * t * (1 - np.cos(2 * np.pi * t))
        slope = past.derivative(early)[0]
        return [np.exp(-y[0]) + weight * (np.sin(slope) - np.sin(1 / (3 + early)))]

    return fun


def _h1(t, y, past):
    square = y[0] ** 2
    logarithm = np.log(np.cos(2 * t))
    slope = past.derivative(t * square / (1 + square))[0]
    return [-4 * t * square / (4 + logarithm**2) + np.tan(2 * t) + 0.5 * np.arctan(slope)]


def _h2(weight):
    def fun(t, y, past):
        early = t * y[0] ** 2
        exact = t * np.sin(t) ** 2
        return [
            np.cos(t) * (1 + past(early)[0])
            + weight * y[0] * past.derivative(early)[0]
            + (1 - weight) * np.sin(t) * np.cos(exact)
            - np.sin(t + exact)
        ]

    return fun


def _log3(t):
    return [np.log(t + 3)]


def _sine(t):
    return [np.sin(t)]


DDETST = (
    Published("B1", lambda t, y, past: 1 - past(np.exp(1 - 1 / t)), 0.1, 10.0,
              lambda t: [np.log(t)]),
    Published("B2", _b2, 0.0, 2 * np.log(66), _b2_solution),
    Published("D1", _d1, 0.1, 5.0, lambda t: [np.log(t), 1 / t]),
    Published("F1", _f1, 0.0, 1.0, lambda t: [np.exp(np.sin(2 * t))], True),
    Published("F2", lambda t, y, past: past.derivative(2 * t - 0.5), 0.25, 0.499, _f2_solution,
              True, lambda t: [np.exp(-(t**2))]),
    Published("F3", _f3(0.2), 0.0, 10.0, _log3, True),
    Published("F4", _f3(0.4), 0.0, 10.0, _log3, True),
    Published("F5", _f3(0.6), 0.0, 10.0, _log3, True),
    Published("G1", lambda t, y, past: -past.derivative(t - y[0] ** 2 / 4), 0.0, 1.0,
              lambda t: [t + 1], True, lambda t: [1 - t]),
    Published("G2", lambda t, y, past: -past.derivative(y[0] - 2), 0.0, 1.0,
              lambda t: [t + 1], True, lambda t: [1 - t]),
    Published("H1", _h1, 0.0, 0.225 * np.pi, lambda t: [-np.log(np.cos(2 * t)) / 2], True),
    Published("H2", _h2(0.1), 0.0, np.pi, _sine, True),
    Published("H3", _h2(0.3), 0.0, np.pi, _sine, True),
    Published("H4", _h2(0.5), 0.0, np.pi, _sine, True),
)  # fmt: skip


def _neves(t, y, past):
    return [past(y[0] - np.sqrt(2) + 1)[0] / (2 * np.sqrt(t))]


def _neves_solution(t):
    root = np.sqrt(t)
    return [root if t <= 2 else t / 4 + 0.5 + (1 - np.sqrt(0.5)) * root]


def _feldstein(t, y, past):
    return [y[0] * past(np.log(y[0]))[0] / t]


def _feldstein_solution(t):
    e = np.e
    return [t if t <= e else np.exp(t / e) if t <= e**2 else (e / (3 - np.log(t))) ** e]


def _paul_solution(t):
    """By the explicit pieces; y jumps at t = 2, and y' where y = 2."""
    if t <= 4:
        return [t / 2 if t >= 2 else 0.5]
    if t <= 4 + 2 * np.log(2):
        return [2 * np.exp(t / 2 - 2)]
    return [4 - 2 * np.log(5 + 2 * np.log(2) - t)]


OF_THE_STATE = (
    Published("Paul", lambda t, y, past: past(y[0]), 2.0, 5.5, _paul_solution),
    Published("Neves", _neves, 1.0, 5.0, _neves_solution, history=[1.0]),
    Published("Feldstein and Neves", _feldstein, 1.0, 10.0, _feldstein_solution, history=[1.0]),
)


def _of_powers(t):
    """y' = y(t - 1), y = 1 before."""
    return [sum((t - k + 1) ** k / math.factorial(k) for k in range(int(t) + 2))]


def _four_delays(t, y, past):
    return -past(t - 1.0) + past(t - 2.0) - past(t - 3.0) * past(t - 4.0)


def _four_delays_solution(t):
    return [np.polyval([-1 / 120, 1 / 6, -5 / 3, 109 / 12, -24, 2689 / 120], t)]


def _growing(t):
    """y' = 5 y + y(t - 1), y = 5 before."""
    return [6 * np.exp(5 * t) - 1 if t < 1 else 6 * (np.exp(5) + t - 1.2) * np.exp(5 * t - 5) + 0.2]


def _product(sign):
    """y' = sign y(t - pi) y, which jumps at -pi / 2 and at 0; up to 2 pi."""

    def solution(t):
        rises = 0.5 * (np.exp(sign * (3 * np.pi - 2 * t)) - 1)
        return [-np.exp(rises - sign * 1.5 * np.pi)]

    return Published(
        f"1.1.{10 if sign > 0 else 11}", lambda t, y, past: sign * past(t - np.pi) * y, 0.0, 6.0,
        solution, history=lambda t: [-1.0 if t >= 0 else -2.0 if t >= -np.pi / 2 else 0.0],
        jumps=(-np.pi / 2, 0.0),
    )  # fmt: skip


def _from_a_third(t):
    """y' = y + y(t - 1), y = 1 from -1/3 to 0, 0 before; from 2 to 8/3."""
    e = np.exp
    c1 = 1 + e(-2 / 3)
    c2 = c1 - 2 * e(-1)
    c3 = 5 / 3 * e(-1) * (1 - c1) + c2 - e(-5 / 3)
    c4 = e(-2) + c3 + 2 * (c1 - c2) * e(-1)
    return [(t**2 / 2 - t) * e(t - 2) + c2 * t * e(t - 1) + c4 * e(t)]


def _turning(t, y, past):
    """x'' and y'' with x = sin t cos 2t, y = cos t sin 2t."""
    p = past(t - np.pi)
    return [y[2], y[3], 5 * p[0] - 4 * y[1], 5 * p[1] - 4 * y[0]]


def _turning_solution(t):
    s, c, s2, c2 = np.sin(t), np.cos(t), np.sin(2 * t), np.cos(2 * t)
    return [s * c2, c * s2, c * c2 - 2 * s * s2, 2 * c * c2 - s * s2]


def _exponent(t, y, past):
    forced = np.exp(np.sin(t)) * (np.cos(t) ** 2 - np.sin(t)) - 2 * np.exp(-np.cos(t))
    return [y[1], 2 * past(t - np.pi / 2)[0] + forced]


# The numbers are those of the report, whose solutions are exact but for 1.2.1 and 1.2.3, where the
# number at the end is.
PAUL = (
    Published("1.1.1", lambda t, y, past: past(t - 1.0), 0.0, 10.0, _of_powers, history=[1.0]),
    Published("1.1.2", lambda t, y, past: -past(t - np.pi / 2), 0.0, 10.0, _sine),
    Published("1.1.5", lambda t, y, past: y + past(t - np.pi) + 3 * np.cos(t) + 5 * np.sin(t),
              0.0, 10.0, lambda t: [3 * np.sin(t) - 5 * np.cos(t)]),
    Published("1.1.6", _four_delays, 0.0, 5.0, _four_delays_solution,
              history=lambda t: [1.0 if t < 0 else 0.0], jumps=(0.0,)),
    Published("1.1.9", lambda t, y, past: 5 * y + past(t - 1.0), 0.0, 2.0, _growing,
              history=[5.0]),
    _product(1.0), _product(-1.0),
    Published("1.1.12", lambda t, y, past: y + past(t - 1.0), 0.0, 8 / 3, _from_a_third,
              history=lambda t: [1.0 if t >= -1 / 3 else 0.0], jumps=(-1 / 3,)),
    Published("1.2.1", lambda t, y, past: 3 * past(0.95 * t**1.1), 0.0, 0.95**-10,
              lambda t: [91.22490537957470909], history=[1.0]),
    Published("1.2.3", lambda t, y, past: past(2 * t - 1), 0.0, 1.0,
              lambda t: [2.271492555500812], history=[1.0]),
    Published("1.4.9", _turning, 0.0, 5.0, _turning_solution),
    Published("1.4.12", _exponent, 0.0, 5.0,
              lambda t: [np.exp(np.sin(t)), np.cos(t) * np.exp(np.sin(t))]),
)  # fmt: skip
