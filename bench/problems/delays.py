"""Equations with constant delays: one function for fastdyn, JiTCDDE and ddeint.

Infectious disease: E. Hairer, S. P. Norsett and G. Wanner, "Solving Ordinary Differential Equations
I", 2nd edition, Springer 1993, section II.17.  Blood cells: M. C. Mackey and L. Glass, "Oscillation
and chaos in physiological control systems", Science 197 (1977), 287.
"""

import math
from fractions import Fraction
from typing import Any, NamedTuple


class Delayed(NamedTuple):
    """y' = fun(t, y, past) from a constant history to `end`, and its state there.

    `code` names the function in `cpp/delays.cpp`.
    """

    name: str
    fun: Any
    delays: list
    history: list
    end: float
    code: str
    solution: list


def linear(t, y, past):
    return [-past(t - 1.0)[0]]


def blood_cells(t, y, past):
    p = past(t - 14.0)[0]
    return [0.2 * p / (1.0 + p**10) - 0.1 * y[0]]


def infection(t, y, past):
    caught, lost = y[0] * past(t - 1.0)[1], past(t - 10.0)[1]
    return [lost - caught, caught - y[1], y[1] - lost]


def method_of_steps(end):
    """y(end) of y' = -y(t - 1) and y = 1 before: sum of (-1)^k (end - k + 1)^k / k!, exactly."""
    terms = [Fraction((k - end - 1) ** k, math.factorial(k)) for k in range(end + 2)]
    return float(sum(terms))


# The last two by Vern9 at 3e-14; at 1e-13 its ends differ by less than 5e-14.
DELAYS = [
    Delayed("linear", linear, [1.0], [1.0], 10.0, "linear", [method_of_steps(10)]),
    Delayed("blood cells", blood_cells, [14.0], [0.5], 500.0, "blood_cells", [1.0104431117001]),
    Delayed(
        "infectious disease", infection, [1.0, 10.0], [5.0, 0.1, 1.0], 40.0, "infection",
        [0.0912491205664, 0.0202995003351, 5.98845137909857],
    ),
]  # fmt: skip
