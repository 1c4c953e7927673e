"""DAEs with many parameters, each beside the ordinary differential equation that it reduces to."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np


class ManyDaes(NamedTuple):
    """F(t, y, y', p) = 0 from 0 to `end`, for the parameters p of each trajectory.

    Attributes
    ----------
    name : str
    F : callable
    starts : ndarray, shape (count, n)
        With the components that are free; the others are guesses.
    parameters : ndarray, shape (count,)
    end : float
    reduced : callable
        The right-hand side ``f(t, x, p)`` of the same motion.
    reduced_starts : ndarray, shape (count, m)
    first : callable
        The first component of y from x and p.
    rtol, atol : float
    """

    name: str
    F: Callable
    starts: Any
    parameters: Any
    end: float
    reduced: Callable
    reduced_starts: Any
    first: Callable
    rtol: float = 1e-6
    atol: float = 1e-10


def robertson(t, y, yp, k):
    a, b, c = y
    slow, fast = 0.04 * a, k * b * c
    return [yp[0] + slow - fast, yp[1] - slow + fast + 3e7 * b * b, a + b + c - 1]


def robertson_rates(t, y, k):
    a, b, c = y
    slow, fast, faster = 0.04 * a, k * b * c, 3e7 * b * b
    return [fast - slow, slow - fast - faster, faster]


def divider(t, y, yp, R):
    """A source, a resistor, a capacitor and a diode: voltage at the capacitor and current."""
    u, i = y
    return [0.5 * yp[0] - i + 1e-6 * (math.exp(u / 0.05) - 1), math.sin(t) - R * i - u]


def divider_voltage(t, u, R):
    return [((math.sin(t) - u[0]) / R - 1e-6 * (math.exp(u[0] / 0.05) - 1)) / 0.5]


def pendulum(t, y, yp, length):
    x, z, u, v, force = y
    balance = [yp[0] - u, yp[1] - v, yp[2] + force * x, yp[3] + force * z + 9.81]
    return [*balance, x * x + z * z - length * length]


def pendulum_angle(t, y, length):
    return [y[1], -9.81 / length * math.sin(y[0])]


def many_daes(count):
    """Robertson's reaction and a circuit of index 1, a pendulum of index 3."""
    k = np.linspace(5e3, 2e4, count)
    reaction = np.tile([1.0, 0.0, 0.0], (count, 1))
    yield ManyDaes(
        "Robertson", robertson, reaction, k, 1e4, robertson_rates, reaction, lambda x, p: x[0]
    )
    R, volts = np.linspace(0.5, 4.0, count), np.full((count, 1), 0.2)
    guesses = np.hstack([volts, 0.0 * volts])
    yield ManyDaes("circuit", divider, guesses, R, 10.0, divider_voltage, volts, lambda x, p: x[0])
    lengths, angle = np.linspace(0.5, 2.0, count), 1.2
    hanging = np.zeros((count, 5))
    hanging[:, 0], hanging[:, 1] = lengths * np.sin(angle), -lengths * np.cos(angle)
    yield ManyDaes(
        "pendulum, index 3", pendulum, hanging, lengths, 10.0, pendulum_angle,
        np.tile([angle, 0.0], (count, 1)), lambda x, p: p * np.sin(x[0]),
    )  # fmt: skip
