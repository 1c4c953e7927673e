"""Nanoparticle thrown up by its thermal motion: how high? (course 3.3.2, example 1)"""

import dataclasses
import math
from typing import ClassVar

import numpy as np

from fastdyn.systems.base.declare import State, event, initial, parameter, quantity
from fastdyn.systems.base.system import System

BOLTZMANN = 1.3806503e-23
"""Boltzmann's constant in J/K, as the course gives it."""


@quantity("m²/s²", "energy E/m")
def energy(t, w, g):
    """Kinetic plus potential energy per unit mass."""
    z, v = w
    return 0.5 * v * v + g * z


@event(direction=-1)
def apex(t, w, g):
    """Zero, and falling, at the highest point."""
    return w[1]


@event(direction=-1, terminal=True)
def ground(t, w, g):
    """Zero, and falling, where the particle is back on the surface; ends the run."""
    return w[0]


@dataclasses.dataclass(frozen=True)
class Nanoparticle(System):
    """
    Sphere of silicon that leaves a surface straight upwards at its thermal speed.

    Equation of motion, z'' = -g. State ``[z, v]`` in m and m/s, from z = 0 with the root mean
    square speed sqrt(3 k T / m) of thermal motion; nothing but gravity acts.

    Parameters
    ----------
    radius : float
        Radius of the sphere, m.
    density : float
        Density, kg/m³; 2330 for silicon.
    T : float
        Temperature, K.
    g : float
        Acceleration of gravity, m/s².

    Raises
    ------
    TypeError, ValueError
        For an unknown parameter, or one that is not a finite number above zero.

    Notes
    -----
    It rises to v² / (2 g) = 3 k T / (2 m g), 7.9 mm; the course says "10 mm or so". The mean
    speed sqrt(8 k T / (pi m)) gives 6.7 mm.

    Source: course, chapter 3.3.2, example 1.
    """

    name = "nanoparticle"
    title = "Nanoparticle in thermal motion"
    source = "course 3.3.2, example 1, thermal motion"
    states = (State("z", "m", "height"), State("v", "m/s", "velocity upwards"))
    t_end = 0.08
    invariants: ClassVar = {"energy": energy}
    events: ClassVar = {"apex": apex, "ground": ground}
    derived: ClassVar = {
        "mass": "kg",
        "rms_speed": "m/s",
        "mean_speed": "m/s",
        "apex_time": "s",
        "apex_height": "m",
        "apex_height_at_mean_speed": "m",
    }

    radius: float = initial(20e-9, "m", "radius", positive=True)
    density: float = initial(2330.0, "kg/m³", "density", positive=True)
    T: float = initial(293.0, "K", "temperature", positive=True)
    g: float = parameter(9.81, "m/s²", "acceleration of gravity", positive=True)

    @staticmethod
    def rhs(t, w, g):
        """Derivative of the state; the particle enters through its initial speed."""
        return [w[1], -g]

    def initial_state(self):
        """State (0, root mean square speed)."""
        return (0.0, self.rms_speed)

    def exact(self, t):
        """Exact state, shape (2,) or (2, n_points)."""
        t = np.asarray(t, float)
        return np.array([self.rms_speed * t - 0.5 * self.g * t**2, self.rms_speed - self.g * t])

    @property
    def mass(self) -> float:
        """Mass, kg."""
        return 4.0 / 3.0 * math.pi * self.radius**3 * self.density

    @property
    def rms_speed(self) -> float:
        """Root mean square of the thermal speed, m/s."""
        return math.sqrt(3.0 * BOLTZMANN * self.T / self.mass)

    @property
    def mean_speed(self) -> float:
        """Mean of the thermal speed, m/s."""
        return math.sqrt(8.0 * BOLTZMANN * self.T / (math.pi * self.mass))

    @property
    def apex_time(self) -> float:
        """Time of the highest point, s."""
        return self.rms_speed / self.g

    @property
    def apex_height(self) -> float:
        """Greatest height, m."""
        return self.rms_speed**2 / (2.0 * self.g)

    @property
    def apex_height_at_mean_speed(self) -> float:
        """Greatest height of a particle that starts with the mean speed, m."""
        return self.mean_speed**2 / (2.0 * self.g)
