"""The exercises of the course's first half: flights, springs, the rod, the pendulum."""

# ruff: noqa: E741, RUF059 - the course calls the length l; states are unpacked whole
import numpy as np

from .exercise import Exercise


def projectile(t, y, g):
    x, z, vx, vz = y
    return [vx, vz, 0.0, -g]


def suspension(t, y, m, k, L0, g):
    x, v = y
    return [v, -k / m * (x - L0) - g]


def rod(t, y, mu, omega):
    r, v = y
    return [v, omega**2 * r - 2 * mu * omega * v]


def normal_force(t, y, m, omega):
    r, v = y
    return [2 * m * omega * v]


def pendulum(t, y, g, l):
    theta, omega = y
    return [omega, -g / l * np.sin(theta)]


def tension(t, y, m, g, l):
    theta, omega = y
    return [m * l * omega**2 + m * g * np.cos(theta)]


OUTWARDS = {"r": (0.2, 1.5), "v": (0.2, 1.5)}
RATE = {"its rate": lambda t, y, p: y.v}

FIRST = [
    Exercise(
        "projectile", "A ball flies without air: x is horizontal, z upwards.",
        {"x": "m", "z": "m", "vx": "m/s", "vz": "m/s"}, {"g": "m/s²"},
        {"x'": "m/s", "z'": "m/s", "vx'": "m/s²", "vz'": "m/s²"},
        {
            "x'": {"the velocity": lambda t, y, p: y.vx},
            "z'": {"the velocity": lambda t, y, p: y.vz},
            "vx'": {"nothing": lambda t, y, p: 0.0 * t},
            "vz'": {"gravity": lambda t, y, p: -p.g},
        },
        projectile,
    ),
    Exercise(
        "suspension", "A vehicle stands on a spring of stiffness k and length L0; x is the length "
        "of the spring, upwards.",
        {"x": "m", "v": "m/s"}, {"m": "kg", "k": "N/m", "L0": "m", "g": "m/s²"},
        {"x'": "m/s", "v'": "m/s²"},
        {
            "x'": RATE,
            "v'": {
                "the position in the spring's force": lambda t, y, p: -p.k * y.x / p.m,
                "the natural length in the spring's force": lambda t, y, p: p.k * p.L0 / p.m,
                "the weight": lambda t, y, p: -p.g,
            },
        },
        suspension, ranges={"x": (0.2, 1.5)},
    ),
    Exercise(
        "rod", "A block slides along a rod that turns in the horizontal plane at omega, with "
        "friction mu; it slides outwards.",
        {"r": "m", "v": "m/s"}, {"mu": "1", "omega": "rad/s"}, {"r'": "m/s", "v'": "m/s²"},
        {
            "r'": RATE,
            "v'": {
                "the centripetal acceleration": lambda t, y, p: p.omega**2 * y.r,
                "friction": lambda t, y, p: -2 * p.mu * p.omega * y.v,
            },
        },
        rod, ranges=OUTWARDS,
    ),
    Exercise(
        "normal_force", "The force between that rod and the block, which slides outwards.",
        {"r": "m", "v": "m/s"}, {"m": "kg", "omega": "rad/s"}, {"N": "N"},
        {"N": {"the Coriolis acceleration": lambda t, y, p: 2 * p.m * p.omega * y.v}},
        normal_force, ranges=OUTWARDS,
    ),
    Exercise(
        "pendulum", "A pendulum of length l by its angle from the lowest point.",
        {"theta": "rad", "omega": "rad/s"}, {"g": "m/s²", "l": "m"},
        {"theta'": "rad/s", "omega'": "rad/s²"},
        {
            "theta'": {"its rate": lambda t, y, p: y.omega},
            "omega'": {"the weight": lambda t, y, p: -p.g / p.l * np.sin(y.theta)},
        },
        pendulum,
    ),
    Exercise(
        "tension", "The tension in the cable of that pendulum.",
        {"theta": "rad", "omega": "rad/s"}, {"m": "kg", "g": "m/s²", "l": "m"}, {"R": "N"},
        {
            "R": {
                "the motion on a circle": lambda t, y, p: p.m * p.l * y.omega**2,
                "the weight": lambda t, y, p: p.m * p.g * np.cos(y.theta),
            }
        },
        tension,
    ),
]  # fmt: skip
