"""The exercises of the course's second half: air, orbits, the building, constraints."""

# ruff: noqa: E741, RUF059 - the course calls the length l; states are unpacked whole
import numpy as np

from .exercise import Exercise


def drag(t, y, g, c):
    x, z, vx, vz = y
    speed = np.hypot(vx, vz)
    return [vx, vz, -c * speed * vx, -g - c * speed * vz]


def wind(t, y, g, c, W):
    x, z, vx, vz = y
    speed = np.hypot(vx - W, vz)
    return [vx, vz, -c * speed * (vx - W), -g - c * speed * vz]


def satellite(t, y, GM):
    x, y, vx, vy = y
    r = np.hypot(x, y)
    return [vx, vy, -GM * x / r**3, -GM * y / r**3]


def energy(t, y, GM):
    x, y, vx, vy = y
    return [(vx**2 + vy**2) / 2 - GM / np.hypot(x, y)]


def building(t, y, m, k, L, d, omega, g):
    y1, y2, v1, v2 = y
    lower = 2 * k / m * (y1 - d * np.sin(omega * t) - L)
    upper = 2 * k / m * (y2 - y1 - L)
    return [v1, v2, upper - lower - g, -upper - g]


def pendulum_xy(t, y, m, g, l):
    x, y, vx, vy = y
    matrix = [[m, 0, x / l], [0, m, y / l], [x, y, 0]]
    return np.linalg.solve(matrix, [0, m * g, -(vx**2) - vy**2])


def _flight(wind):
    """Terms of a flight through air."""

    def relative(y, p):
        return y.vx - (p.W if wind else 0.0)

    def speed(y, p):
        return np.hypot(relative(y, p), y.vz)

    return {
        "x'": {"the velocity": lambda t, y, p: y.vx},
        "z'": {"the velocity": lambda t, y, p: y.vz},
        "vx'": {"the drag": lambda t, y, p: -p.c * speed(y, p) * relative(y, p)},
        "vz'": {
            "gravity": lambda t, y, p: -p.g,
            "the drag": lambda t, y, p: -p.c * speed(y, p) * y.vz,
        },
    }


def _reaction(y, p):
    """The tension of the pendulum in x and y, divided by the length, y downwards."""
    return (p.m * p.g * y.y + p.m * (y.vx**2 + y.vy**2)) / (y.x**2 + y.y**2)


def _on_the_circle(y, p):
    """States on the circle whose radius is the length, with velocities along the circle."""
    r = np.hypot(y.x, y.y)
    x = y.x / r
    z = y.y / r
    along = y.vx * z - y.vy * x
    return {"x": p.l * x, "y": p.l * z, "vx": along * z, "vy": -along * x}


FLIGHT = {"x": "m", "z": "m", "vx": "m/s", "vz": "m/s"}
FLOWN = {"x'": "m/s", "z'": "m/s", "vx'": "m/s²", "vz'": "m/s²"}
PLANE = {"x": "m", "y": "m", "vx": "m/s", "vy": "m/s"}

SECOND = [
    Exercise(
        "drag", "A ball flies through air with the specific drag c; z is upwards.",
        FLIGHT, {"g": "m/s²", "c": "1/m"}, FLOWN, _flight(False), drag,
    ),
    Exercise(
        "wind", "The same in a wind W along x.",
        FLIGHT, {"g": "m/s²", "c": "1/m", "W": "m/s"}, FLOWN, _flight(True), wind,
    ),
    Exercise(
        "satellite", "A satellite moves about a planet at the origin.",
        PLANE, {"GM": "m³/s²"}, {"x'": "m/s", "y'": "m/s", "vx'": "m/s²", "vy'": "m/s²"},
        {
            "x'": {"the velocity": lambda t, y, p: y.vx},
            "y'": {"the velocity": lambda t, y, p: y.vy},
            "vx'": {"gravity": lambda t, y, p: -p.GM * y.x / np.hypot(y.x, y.y) ** 3},
            "vy'": {"gravity": lambda t, y, p: -p.GM * y.y / np.hypot(y.x, y.y) ** 3},
        },
        satellite,
    ),
    Exercise(
        "energy", "The energy of that satellite, divided by its mass; its zero is anywhere.",
        PLANE, {"GM": "m³/s²"}, {"E/m": "J/kg"},
        {
            "E/m": {
                "the motion": lambda t, y, p: (y.vx**2 + y.vy**2) / 2,
                "gravity": lambda t, y, p: -p.GM / np.hypot(y.x, y.y),
            }
        },
        energy, free_zero=["E/m"],
    ),
    Exercise(
        "building", "Two floors of mass m on two walls each, of stiffness k and height L; "
        "y1 < y2 are their heights, and the ground moves as d sin(omega t).",
        {"y1": "m", "y2": "m", "v1": "m/s", "v2": "m/s"},
        {"m": "kg", "k": "N/m", "L": "m", "d": "m", "omega": "rad/s", "g": "m/s²"},
        {"y1'": "m/s", "y2'": "m/s", "v1'": "m/s²", "v2'": "m/s²"},
        {
            "y1'": {"the velocity": lambda t, y, p: y.v1},
            "y2'": {"the velocity": lambda t, y, p: y.v2},
            "v1'": {
                "the lower walls":
                    lambda t, y, p: -2 * p.k / p.m * (y.y1 - p.d * np.sin(p.omega * t) - p.L),
                "the upper walls": lambda t, y, p: 2 * p.k / p.m * (y.y2 - y.y1 - p.L),
                "the weight": lambda t, y, p: -p.g,
            },
            "v2'": {
                "the upper walls": lambda t, y, p: -2 * p.k / p.m * (y.y2 - y.y1 - p.L),
                "the weight": lambda t, y, p: -p.g,
            },
        },
        building, ranges={"y1": (2.1, 3.0), "y2": (3.2, 5.0)},  # above the ground, d sin(omega t)
    ),
    Exercise(
        "pendulum_xy", "A pendulum in x and y, y downwards: the accelerations, and the tension R, "
        "for the constraint x² + y² = l² on accelerations.",
        PLANE, {"m": "kg", "g": "m/s²", "l": "m"}, {"vx'": "m/s²", "vy'": "m/s²", "R": "N"},
        {
            "vx'": {"the tension": lambda t, y, p: -_reaction(y, p) * y.x / p.m},
            "vy'": {
                "the tension": lambda t, y, p: -_reaction(y, p) * y.y / p.m,
                "the weight": lambda t, y, p: p.g,
            },
            "R": {
                "the weight":
                    lambda t, y, p: p.m * p.g * y.y * p.l / (y.x**2 + y.y**2),
                "the motion on a circle":
                    lambda t, y, p: p.m * (y.vx**2 + y.vy**2) * p.l / (y.x**2 + y.y**2),
            },
        },
        pendulum_xy, project=_on_the_circle,
        follows={
            "vx'": {"the tension": lambda t, y, p, a: -a.R * y.x / p.l / p.m},
            "vy'": {"the tension": lambda t, y, p, a: -a.R * y.y / p.l / p.m},
        },
    ),
]  # fmt: skip
