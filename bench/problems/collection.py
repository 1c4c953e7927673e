"""The problems: initial states, spans, parameters."""

import math

import numpy as np

from fastdyn import solve_linear
from fastdyn.systems import SYSTEMS

from . import equations
from .problem import Problem, large, small

BODIES, CHAIN = "bodies", "chain"  # C++ functions for any number of components


def _satellite(e):
    start = [1.0, 0.0, 0.0, math.sqrt(1.0 + e)]
    return small(equations.satellite, 100.0, start, (1.0,), f"satellite, e = {e:g}")


def _vehicle():
    """In motion from the start: at rest |v| v has no Taylor series."""
    slope = math.tan(0.1)  # the front wheel's angle at t = 0, L = 1
    start = [0.0, 0.0, 0.0, 1.0, -0.5 * slope, slope]
    return small(equations.vehicle, 20.0, start, (1.0, 1.0, 0.1), "vehicle", "vehicle_explicit")


def _pleiades():
    places = [3, 3, -1, -3, 2, -2, 2, 3, -3, 2, 0, 0, -4, 4]
    rates = [0, 0, 0, 0, 0, 1.75, -1.5, 0, 0, 0, -1.25, 1, 0, 0]
    start = np.array([*places, *rates], dtype=float)
    into, arrays = equations.pleiades_into, equations.pleiades_arrays
    return large("Pleiades", into, 3.0, start, "pleiades", terms=equations.pleiades, arrays=arrays)


SATELLITE, PROJECTILE, PENDULUM = PROBLEMS = (
    _satellite(0.0)._replace(name="satellite"),
    small(equations.projectile, 5.0, [0.0, 0.0, 0.0, 10.0, 10.0, 20.0], (0.5, 9.81)),
    small(equations.pendulum, 20.0, [0.0, 0.1], (9.81, 1.0)),
)
BUILDING = SYSTEMS["building"]()
LEAP = (0.994, 0.0, 0.0, -2.00158510637908252240537862224)
WORK = (
    _satellite(0.0),
    _satellite(0.3),
    _satellite(0.6),
    PROJECTILE._replace(name="projectile with drag"),
    small(equations.building, 20.0, list(BUILDING.initial_state()), BUILDING.args[:6]),
    PENDULUM._replace(name="pendulum, swinging", y0=[0.0, 5.0]),
    small(
        equations.constrained_pendulum, 20.0, [0.0, 1.0, 4.0, 0.0], (9.81,), "constrained pendulum"
    ),
    _vehicle(),
    small(equations.arenstorf, 17.0652165601579625588917206249, LEAP, (0.012277471,), "Arenstorf"),
    _pleiades(),
    small(equations.lorenz, 10.0, [1.0, 1.0, 1.0], (10.0, 28.0, 8.0 / 3.0), "Lorenz"),
    small(equations.henon_heiles, 100.0, [0.0, 0.1, 0.5, 0.0], (), "Hénon-Heiles"),
)


def five_equations(t, w, g, l, m, rate):  # noqa: E741
    """The constrained pendulum as the course writes it, the whole matrix at each evaluation."""
    x, y, vx, vy = w
    r = m * math.sqrt(x * x + y * y)
    solved = solve_linear(
        (
            (1.0, 0.0, 0.0, 0.0, 0.0),
            (0.0, 1.0, 0.0, 0.0, 0.0),
            (0.0, 0.0, 1.0, 0.0, x / r),
            (0.0, 0.0, 0.0, 1.0, y / r),
            (0.0, 0.0, x, y, 0.0),
        ),
        (vx, vy, 0.0, g, -vx * vx - vy * vy),
    )
    return [solved[0], solved[1], solved[2], solved[3]]


def course():
    """The systems of the course that have a C++ counterpart, t = 20."""
    pairs = [PENDULUM]
    for name in ("building", "pendulum_xy", "vehicle"):
        system = SYSTEMS[name]()
        start = list(system.initial_state())
        pairs.append(Problem(name, system.rhs, (0.0, 20.0), start, system.args, name))
    whole = pairs[2]._replace(name="pendulum_xy, 5x5 as in C++", fun=five_equations)
    return [*pairs, whole]


def chain_of(n):
    """A chain of n / 2 equal masses on springs between two walls, one end plucked."""
    y0 = np.zeros(n)
    y0[0] = 1.0
    into, arrays = equations.chain_into, equations.chain_arrays
    return large(f"chain {n}", into, 20.0, y0, CHAIN, arrays=arrays)


def bodies_of(count):
    """`count` bodies of one mass in all, at rest at random places of the unit cube."""
    half = 3 * count
    y0 = np.zeros(2 * half)
    y0[:half] = np.random.default_rng(1).random(half)
    into, arrays = equations.bodies_into, equations.bodies_arrays
    return large(f"{count} bodies", into, 0.01, y0, BODIES, arrays=arrays)
