"""Projectile without air resistance (course 3.3.2, example 1)."""

import dataclasses
import math

import numpy as np

from fastdyn.plot import flight

from .base import State, System, derived, event, initial, invariant, parameter, quantity


@dataclasses.dataclass(frozen=True)
class Projectile(System):
    """
    Particle thrown near the surface of the earth, in a vacuum.

    Equations of motion::

        x'' = 0        y'' = 0        z'' = -g

    State ``[x, y, z, vx, vy, vz]`` in m and m/s, z upwards. The defaults are those of the
    course's script for the projectile with air resistance, to compare the two.

    Notes
    -----
    Exact: r = r0 + v0 t - g t²/2 k.
    """

    name = "projectile"
    title = "Projectile"
    source = "course 3.3.2, example 1"
    states = (
        State("x", "m", "position"),
        State("y", "m", "position across"),
        State("z", "m", "height"),
        State("vx", "m/s", "velocity"),
        State("vy", "m/s", "velocity across"),
        State("vz", "m/s", "velocity upwards"),
    )
    t_end = 5.0

    g: float = parameter(9.81, "m/s²", "acceleration of gravity", positive=True)
    x0: float = initial(0.0, "m", "position at launch")
    y0: float = initial(0.0, "m", "position at launch, across")
    z0: float = initial(0.0, "m", "height at launch")
    vx0: float = initial(10.0, "m/s", "velocity at launch")
    vy0: float = initial(10.0, "m/s", "velocity at launch, across")
    vz0: float = initial(20.0, "m/s", "velocity at launch, upwards")

    def initial_state(self):
        return (self.x0, self.y0, self.z0, self.vx0, self.vy0, self.vz0)

    @staticmethod
    def rhs(t, w, g):
        return [w[3], w[4], w[5], 0.0, 0.0, -g]

    @invariant("m²/s²", "energy E/m")
    def energy(t, w, g):
        """Kinetic plus potential energy per unit mass, zero at rest on the ground."""
        _, _, z, vx, vy, vz = w
        return 0.5 * (vx * vx + vy * vy + vz * vz) + g * z

    @quantity("m/s", "speed")
    def speed(t, w, g):
        """Magnitude of the velocity."""
        _, _, _, vx, vy, vz = w
        return np.sqrt(vx * vx + vy * vy + vz * vz)

    @event(direction=-1, terminal=True)
    def ground(t, w, g):
        """Zero, and falling, where the projectile hits the ground z = 0; ends the run."""
        return w[2]

    @event(direction=-1)
    def apex(t, w, g):
        """Zero, and falling, at the highest point."""
        return w[5]

    def exact(self, t):
        """Exact state, as `System.exact`; it goes on through the ground."""
        t = np.asarray(t, float)
        start = np.array(self.initial_state()).reshape(6, *[1] * t.ndim)
        place = start[:3]
        velocity = start[3:]
        pull = np.array([0.0, 0.0, -self.g]).reshape(3, *[1] * t.ndim)
        return np.concatenate([place + velocity * t + 0.5 * pull * t**2, velocity + pull * t])

    @derived("s")
    def apex_time(self) -> float:
        """Time of the highest point; 0 if it is thrown downwards."""
        return max(0.0, self.vz0 / self.g)

    @derived("m")
    def apex_height(self) -> float:
        """Greatest height above the ground."""
        return self.z0 + max(0.0, self.vz0) ** 2 / (2.0 * self.g)

    @derived("s")
    def flight_time(self) -> float:
        """Time at which it hits the ground; NaN if it starts below."""
        square = self.vz0**2 + 2.0 * self.g * self.z0
        return (self.vz0 + math.sqrt(square)) / self.g if self.z0 >= 0.0 else math.nan

    @derived("m")
    def range(self) -> float:
        """Horizontal distance from the launch to the impact."""
        return math.hypot(self.vx0, self.vy0) * self.flight_time

    def figure(self, results, **options):
        """Trajectories in space, beside height and speed against time; see `System.figure`."""
        return flight.figure(results, self.speed, **options)

    def scene(self, t, w):
        """The ball from the side; see `System.scene`."""
        return flight.scene(w, self.initial_state())
