"""Pendulum in Cartesian coordinates, held by a constraint (course 3.3.3, example 4)."""

# ruff: noqa: E741 - the course calls the length l
import dataclasses
import math
from typing import ClassVar

import numpy as np

from fastdyn.kernels.algebra.constrained import constrained
from fastdyn.plot import pendulums

from .base import State, System, constraint, derived, event, initial, invariant, parameter, quantity
from .pendulum import Pendulum


@dataclasses.dataclass(frozen=True)
class PendulumXY(System):
    """
    Pendulum in the coordinates (x, y) of its mass, y downwards, with the tension as a reaction.

    Equations of motion, with the constraint x² + y² = l² differentiated twice::

        m x'' + R x/l = 0        m y'' + R y/l = m g        x x'' + y y'' = -(x'² + y'²)

    State ``[x, y, vx, vy]`` in m and m/s; from the lowest point (0, l) with velocity (V0, 0), of
    either sign. Defaults and t = 20 s are those of the course's script. The three equations are
    solved at each evaluation, by `fastdyn.constrained`.

    Notes
    -----
    The same motion as that of `Pendulum`, whose exact solution serves here. Constraining the
    accelerations alone lets the mass drift off the circle; ``solve(project=True)`` takes it back
    after each step, ``baumgarte().solve()`` pulls it back: at the rate b the constraint
    C = (x² + y² - l²)/(2 l) is held by C'' + 2 b C' + b² C = 0 instead of C'' = 0.

    Why accelerations, and not velocities? The equations are solved for x'', y'' and R, and a
    constraint on the velocities says nothing of them: its row is empty and the matrix singular.

    **Erratum.** The course's script divides by a mass ``m`` that it does not define.
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
    explored: ClassVar = {"V0": 4.0}  # a swing of 79 degrees; the default's, of 1.8, is hardly seen

    g: float = parameter(9.81, "m/s²", "acceleration of gravity", positive=True)
    l: float = parameter(1.0, "m", "length of the cable", positive=True)
    V0: float = initial(0.1, "m/s", "horizontal velocity at launch")
    m: float = parameter(1.0, "kg", "mass", positive=True)
    rate: float = parameter(0.0, "1/s", "Baumgarte's rate", negative=False)

    def initial_state(self):
        return (0.0, self.l, self.V0, 0.0)

    @staticmethod
    def rhs(t, w, g, l, m, rate):
        ax, ay, _ = motion(w, g, l, m, rate)
        return [w[2], w[3], ax, ay]

    @staticmethod
    def project(t, w, g, l, m, rate):
        """The nearest state on the circle, with a velocity along it."""
        x, y, vx, vy = w
        shrink = l / math.sqrt(x * x + y * y)
        x = shrink * x
        y = shrink * y
        dx, dy, _ = constrained((m, m), ((x, y),), (0.0, 0.0), (x * vx + y * vy,))
        return [x, y, vx - dx, vy - dy]

    @invariant("J", "energy E")
    def energy(t, w, g, l, m, rate):
        """Kinetic plus potential energy, zero at rest at the bottom; y points downwards."""
        _, y, vx, vy = w
        return m * (0.5 * (vx * vx + vy * vy) + g * (l - y))

    @constraint("m", "circle: sqrt(x² + y²) - l")
    def circle(t, w, g, l, m, rate):
        """How far the mass has left the circle."""
        x, y, _, _ = w
        return np.sqrt(x * x + y * y) - l

    @constraint("m/s", "circle: velocity across it")
    def across(t, w, g, l, m, rate):
        """Velocity along the cable, which the circle forbids."""
        x, y, vx, vy = w
        return (x * vx + y * vy) / l

    @quantity("N", "cable tension R")
    def tension(t, w, g, l, m, rate):
        """The reaction of the constraint; a cable goes slack where it is zero."""
        return motion(w, g, l, m, rate)[2]

    @event(direction=-1, terminal=True)
    def slack(t, w, g, l, m, rate):
        """The tension, for the event that it falls to zero."""
        return motion(w, g, l, m, rate)[2]

    @event()
    def bottom(t, w, g, l, m, rate):
        """Zero where the mass passes its lowest point."""
        return w[0]

    def baumgarte(self):
        """Itself with Baumgarte's pull, at its own rate or at twice that of small swings."""
        rate = self.rate or 2.0 * math.sqrt(self.g / self.l)
        return dataclasses.replace(self, rate=rate)

    @property
    def by_angle(self) -> Pendulum:
        """The same pendulum with the angle as its coordinate."""
        return Pendulum(self.g, self.l, self.V0, self.m)

    def exact(self, t):
        """Exact state, from that of `Pendulum`, as `System.exact`."""
        angle, omega = self.by_angle.exact(t)
        x = self.l * np.sin(angle)
        y = self.l * np.cos(angle)
        return np.array([x, y, y * omega, -x * omega])

    @derived("")
    def regime(self) -> str:
        """Swinging, separatrix or whirling; see `Pendulum.regime`."""
        return self.by_angle.regime

    @derived("s")
    def period(self) -> float:
        """Time of a swing or of a turn; see `Pendulum.period`."""
        return self.by_angle.period

    def figure(self, results, **options):
        """Paths, and tension and distance from the circle against time; see `System.figure`."""
        return pendulums.on_circle(results, self.l, **options)

    def scene(self, t, w):
        """The cable and the mass; see `System.scene`."""
        return pendulums.scene(self.l, w)


def motion(w, g, l, m, rate):
    """Accelerations and the tension R of the cable, (x'', y'', R)."""
    x, y, vx, vy = w
    s = x / l
    c = y / l
    off, speed = 0.5 * (s * x + c * y - l), s * vx + c * vy  # the constraint and its rate
    pull = (vx * vx + vy * vy) / l + 2.0 * rate * speed + rate * rate * off
    return constrained((m, m), ((-s, -c),), (0.0, m * g), (pull,))
