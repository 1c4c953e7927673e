"""Projectile with air resistance (course 3.3.3, example 1)."""

import dataclasses
import math

import numpy as np

from fastdyn.plot import flight

from .base import System, derived, event, initial, parameter, quantity
from .projectile import Projectile


@dataclasses.dataclass(frozen=True)
class Drag(System):
    """
    Ball thrown through air, with wind if there is any.

    Equation of motion, with u the velocity through the air::

        r'' = -g k - c |u| u        u = r' - wind        c = pi rho C_D D² / (8 m)

    State ``[x, y, z, vx, vy, vz]`` in m and m/s, z upwards. Defaults and t = 5 s are those of
    the course's script, in still air; `specific_drag` gives c.

    Notes
    -----
    Exact for a vertical throw in still air: with the terminal speed u = sqrt(g/c), it rises with
    v = u tan(atan(v0/u) - g t/u), and falls with v = -u tanh(g t/u).
    """

    name = "drag"
    title = "Projectile with air resistance"
    source = "course 3.3.3, example 1"
    states = Projectile.states
    t_end = 5.0

    c: float = parameter(0.5, "1/m", "specific drag", negative=False)
    g: float = parameter(9.81, "m/s²", "acceleration of gravity", positive=True)
    x0: float = initial(0.0, "m", "position at launch")
    y0: float = initial(0.0, "m", "position at launch, across")
    z0: float = initial(0.0, "m", "height at launch")
    vx0: float = initial(10.0, "m/s", "velocity at launch")
    vy0: float = initial(10.0, "m/s", "velocity at launch, across")
    vz0: float = initial(20.0, "m/s", "velocity at launch, upwards")
    wx: float = parameter(0.0, "m/s", "wind")
    wy: float = parameter(0.0, "m/s", "wind, across")
    wz: float = parameter(0.0, "m/s", "wind, upwards")

    initial_state = Projectile.initial_state

    @staticmethod
    def rhs(t, w, c, g, wx, wy, wz):
        _, _, _, vx, vy, vz = w
        ux = vx - wx
        uy = vy - wy
        uz = vz - wz
        s = c * math.sqrt(ux * ux + uy * uy + uz * uz)
        return [vx, vy, vz, -s * ux, -s * uy, -s * uz - g]

    @quantity("m²/s²", "energy E/m")
    def energy(t, w, c, g, wx, wy, wz):
        """Kinetic plus potential energy per unit mass; in still air it only decreases."""
        _, _, z, vx, vy, vz = w
        return 0.5 * (vx * vx + vy * vy + vz * vz) + g * z

    @quantity("m/s", "speed")
    def speed(t, w, c, g, wx, wy, wz):
        """Magnitude of the velocity."""
        _, _, _, vx, vy, vz = w
        return np.sqrt(vx * vx + vy * vy + vz * vz)

    @event(direction=-1, terminal=True)
    def ground(t, w, c, g, wx, wy, wz):
        """Zero, and falling, where the projectile hits the ground z = 0; ends the run."""
        return w[2]

    @event(direction=-1)
    def apex(t, w, c, g, wx, wy, wz):
        """Zero, and falling, at the highest point."""
        return w[5]

    def exact(self, t):
        """Exact state without drag, or thrown vertically in still air, as `System.exact`."""
        if self.c == 0.0:
            return self.in_vacuum.exact(t)
        if any((self.vx0, self.vy0, self.wx, self.wy, self.wz)):
            raise ValueError(
                "No exact solution of the drag is known unless it is thrown vertically in still "
                "air, or c is 0."
            )
        t = np.asarray(t, float)
        u = self.terminal_speed
        rise, v = _vertical(self.vz0 / u, self.g / u * t)
        zero = np.zeros_like(t)
        z = self.z0 + u * u / self.g * rise
        return np.array([self.x0 + zero, self.y0 + zero, z, zero, zero, u * v])

    @derived("m/s")
    def terminal_speed(self) -> float:
        """Speed at which drag balances the weight, sqrt(g/c); infinite without drag."""
        return math.sqrt(self.g / self.c) if self.c else math.inf

    @property
    def in_vacuum(self) -> Projectile:
        """The same throw without air."""
        return Projectile(self.g, *self.initial_state())

    @staticmethod
    def specific_drag(rho, C_D, D, m) -> float:
        """
        Specific drag c = pi rho C_D D² / (8 m) of a sphere, 1/m.

        Parameters
        ----------
        rho : float
            Density of the air, kg/m³.
        C_D : float
            Drag coefficient.
        D, m : float
            Diameter, m, and mass, kg, of the sphere.
        """
        return math.pi * rho * C_D * D**2 / (8.0 * m)

    def figure(self, results, **options):
        """Trajectories in space, beside height and speed against time; see `System.figure`."""
        return flight.figure(results, self.speed, **options)

    scene = Projectile.scene


def _vertical(v0, s):
    """Height and velocity of a vertical throw, in units of the terminal speed and g."""
    if v0 > 0.0:
        top = math.atan(v0)
        going_up = np.minimum(s, top)
        fall = np.maximum(s - top, 0.0)
        peak = 0.5 * math.log1p(v0 * v0)
        height = peak + np.where(s < top, np.log(np.cos(top - going_up)), -_log_cosh(fall))
        return height, np.where(s < top, np.tan(top - going_up), -np.tanh(fall))
    down = -v0
    if down == 1.0:
        return -s, -np.ones_like(s)
    # v = -tanh(s + q) below the terminal speed, -coth(s + q) above it; one quotient covers both.
    v = -(down + np.tanh(s)) / (1.0 + down * np.tanh(s))
    return -(_log_cosh(s) + np.log1p(down * np.tanh(s))), v


def _log_cosh(x):
    return np.abs(x) + np.log1p(np.exp(-2.0 * np.abs(x))) - math.log(2.0)


specific_drag = Drag.specific_drag
