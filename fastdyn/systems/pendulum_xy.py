"""Pendulum in Cartesian coordinates, held by a constraint (course 3.3.3, example 4)."""

# ruff: noqa: E741 - the course calls the length l
import dataclasses
import math
from typing import ClassVar

import numpy as np

from fastdyn.kernels.algebra.constrained import constrained
from fastdyn.plot import pendulums
from fastdyn.systems.base.declare import State, event, initial, parameter, quantity
from fastdyn.systems.base.system import System

from .pendulum import Pendulum


@quantity("J", "energy E")
def energy(t, w, g, l, m, rate):
    """Kinetic plus potential energy, zero at rest at the bottom; y points downwards."""
    _, y, vx, vy = w
    return m * (0.5 * (vx * vx + vy * vy) + g * (l - y))


@quantity("m", "circle: sqrt(x² + y²) - l")
def circle(t, w, g, l, m, rate):
    """How far the mass has left the circle."""
    x, y, _, _ = w
    return np.sqrt(x * x + y * y) - l


@quantity("m/s", "circle: velocity across it")
def across(t, w, g, l, m, rate):
    """Velocity along the cable, which the circle forbids."""
    x, y, vx, vy = w
    return (x * vx + y * vy) / l


def motion(w, g, l, m, rate):
    """Accelerations and the tension R of the cable, (x'', y'', R)."""
    x, y, vx, vy = w
    s, c = x / l, y / l
    off, speed = 0.5 * (s * x + c * y - l), s * vx + c * vy  # the constraint and its rate
    pull = (vx * vx + vy * vy) / l + 2.0 * rate * speed + rate * rate * off
    return constrained((m, m), ((-s, -c),), (0.0, m * g), (pull,))


@quantity("N", "cable tension R")
def tension(t, w, g, l, m, rate):
    """The reaction of the constraint; a cable goes slack where it is zero."""
    return motion(w, g, l, m, rate)[2]


@event(direction=-1, terminal=True)
def slack(t, w, g, l, m, rate):
    """The tension, for the event that it falls to zero."""
    return motion(w, g, l, m, rate)[2]


def bottom(t, w, g, l, m, rate):
    """Zero where the mass passes its lowest point."""
    return w[0]


@dataclasses.dataclass(frozen=True)
class PendulumXY(System):
    """
    Pendulum in the coordinates (x, y) of its mass, y downwards, with the tension as a reaction.

    Equations of motion, with the constraint x² + y² = l² differentiated twice::

        m x'' + R x/l = 0        m y'' + R y/l = m g        x x'' + y y'' = -(x'² + y'²)

    State ``[x, y, vx, vy]`` in m and m/s; from the lowest point (0, l) with velocity (V0, 0).
    Defaults and t = 20 s are those of the course's script. The three equations are solved at
    each evaluation, by `fastdyn.constrained`.

    Parameters
    ----------
    g : float
        Acceleration of gravity, m/s².
    l : float
        Length of the cable, m.
    V0 : float
        Horizontal velocity at launch, m/s, of either sign.
    m : float
        Mass, kg.
    rate : float
        Baumgarte's rate b, 1/s: the constraint C = (x² + y² - l²)/(2 l) is held by
        C'' + 2 b C' + b² C = 0 instead of C'' = 0, which is b = 0.

    Raises
    ------
    TypeError, ValueError
        For an unknown parameter, one that is not a finite number, g, l or m not above zero, or a
        negative rate.

    Notes
    -----
    The same motion as that of `Pendulum`, whose exact solution serves here. Constraining the
    accelerations alone lets the mass drift off the circle; ``solve(project=True)`` takes it back
    after each step, ``baumgarte().solve()`` pulls it back.

    Why accelerations, and not velocities? The equations are solved for x'', y'' and R, and a
    constraint on the velocities says nothing of them: its row is empty and the matrix singular.

    Source: course, chapter 3.3.3, example 4.
    """

    name = "pendulum_xy"
    title = "Pendulum with a constraint"
    source = "course 3.3.3, example 4"
    states = (
        State("x", "m", "position across"),
        State("y", "m", "position downwards"),
        State("vx", "m/s", "velocity across"),
        State("vy", "m/s", "velocity downwards"),
    )
    t_end = 20.0
    invariants: ClassVar = {"energy": energy}
    quantities: ClassVar = {"tension": tension}
    constraints: ClassVar = {"circle": circle, "across": across}
    events: ClassVar = {"slack": slack, "bottom": bottom}
    derived: ClassVar = {"regime": "", "period": "s"}

    g: float = parameter(9.81, "m/s²", "acceleration of gravity", positive=True)
    l: float = parameter(1.0, "m", "length of the cable", positive=True)
    V0: float = initial(0.1, "m/s", "horizontal velocity at launch")
    m: float = parameter(1.0, "kg", "mass", positive=True)
    rate: float = parameter(0.0, "1/s", "Baumgarte's rate")

    def __post_init__(self):
        super().__post_init__()
        if self.rate < 0.0:
            raise ValueError(
                f"Parameter `rate` of the pendulum_xy must not be negative, but is {self.rate:g}."
            )

    @staticmethod
    def rhs(t, w, g, l, m, rate):
        """Derivative of the state."""
        ax, ay, _ = motion(w, g, l, m, rate)
        return [w[2], w[3], ax, ay]

    @staticmethod
    def project(t, w, g, l, m, rate):
        """The nearest state on the circle, with a velocity along it."""
        x, y, vx, vy = w
        shrink = l / math.sqrt(x * x + y * y)
        x, y = shrink * x, shrink * y
        dx, dy, _ = constrained((m, m), ((x, y),), (0.0, 0.0), (x * vx + y * vy,))
        return [x, y, vx - dx, vy - dy]

    def initial_state(self):
        """State (0, l, V0, 0)."""
        return (0.0, self.l, self.V0, 0.0)

    def baumgarte(self):
        """Itself with Baumgarte's pull, at its own rate or at twice that of small swings."""
        rate = self.rate or 2.0 * math.sqrt(self.g / self.l)
        return dataclasses.replace(self, rate=rate)

    @property
    def by_angle(self) -> Pendulum:
        """The same pendulum with the angle as its coordinate."""
        return Pendulum(self.g, self.l, self.V0, self.m)

    @property
    def regime(self) -> str:
        """Swinging, separatrix or whirling; see `Pendulum.regime`."""
        return self.by_angle.regime

    @property
    def period(self) -> float:
        """Time of a swing or of a turn, s; see `Pendulum.period`."""
        return self.by_angle.period

    def exact(self, t):
        """Exact state, shape (4,) or (4, n_points), from that of `Pendulum`."""
        angle, omega = self.by_angle.exact(t)
        x, y = self.l * np.sin(angle), self.l * np.cos(angle)
        return np.array([x, y, y * omega, -x * omega])

    def scene(self, t, w):
        """The cable and the mass, for moving pictures."""
        return pendulums.scene(self.l, w)

    def figure(self, results, **options):
        """Paths, and tension and distance from the circle against time; see `System.figure`."""
        return pendulums.on_circle(results, self.l, **options)
