"""Nanoparticle thrown up by its thermal motion: how high? (course 3.3.2, example 1)"""

import dataclasses
import math

import numpy as np

from fastdyn.plot.scene import Scene

from .base import State, System, derived, event, initial, invariant, parameter

BOLTZMANN = 1.3806503e-23
"""Boltzmann's constant in J/K, as the course gives it."""


@dataclasses.dataclass(frozen=True)
class Nanoparticle(System):
    """
    Sphere of silicon that leaves a surface straight upwards at its thermal speed.

    Equation of motion, z'' = -g. State ``[z, v]`` in m and m/s, from z = 0 with the root mean
    square speed sqrt(3 k T / m) of thermal motion; nothing but gravity acts.

    Notes
    -----
    It rises to v² / (2 g) = 3 k T / (2 m g), 7.9 mm; the course says "10 mm or so". The mean
    speed sqrt(8 k T / (pi m)) gives 6.7 mm.
    """

    name = "nanoparticle"
    title = "Nanoparticle in thermal motion"
    source = "course 3.3.2, example 1, thermal motion"
    states = (State("z", "m", "height"), State("v", "m/s", "velocity upwards"))
    t_end = 0.08

    radius: float = initial(20e-9, "m", "radius", positive=True)
    density: float = initial(2330.0, "kg/m³", "density", positive=True)
    T: float = initial(293.0, "K", "temperature", positive=True)
    g: float = parameter(9.81, "m/s²", "acceleration of gravity", positive=True)

    def initial_state(self):
        return (0.0, self.rms_speed)

    @staticmethod
    def rhs(t, w, g):
        return [w[1], -g]

    @invariant("m²/s²", "energy E/m")
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

    def exact(self, t):
        t = np.asarray(t, float)
        return np.array([self.rms_speed * t - 0.5 * self.g * t**2, self.rms_speed - self.g * t])

    @derived("kg")
    def mass(self) -> float:
        """Mass of the sphere."""
        return 4.0 / 3.0 * math.pi * self.radius**3 * self.density

    @derived("m/s")
    def rms_speed(self) -> float:
        """Root mean square of the thermal speed."""
        return math.sqrt(3.0 * BOLTZMANN * self.T / self.mass)

    @derived("m/s")
    def mean_speed(self) -> float:
        """Mean of the thermal speed."""
        return math.sqrt(8.0 * BOLTZMANN * self.T / (math.pi * self.mass))

    @derived("s")
    def apex_time(self) -> float:
        """Time of the highest point."""
        return self.rms_speed / self.g

    @derived("m")
    def apex_height(self) -> float:
        """Greatest height."""
        return self.rms_speed**2 / (2.0 * self.g)

    @derived("m")
    def apex_height_at_mean_speed(self) -> float:
        """Greatest height of a particle that starts with the mean speed."""
        return self.mean_speed**2 / (2.0 * self.g)

    def figure(self, results, **options):
        """Height against time, with the highest points; see `System.figure`."""
        from fastdyn import plot

        with plot.slides():
            figure, (axes,) = plot.column(1, **{"figsize": (10, 5.5)} | options)
            for label, result in results.items():
                t, y = plot.curve(result)
                (line,) = axes.plot(1e3 * t, 1e3 * y[0], label=label)
                i = np.argmax(y[0])
                axes.plot(1e3 * t[i], 1e3 * y[0, i], "o", color=line.get_color())
                axes.annotate(f"{1e3 * y[0, i]:.1f} mm", (1e3 * t[i], 1e3 * y[0, i]),
                              xytext=(0, 8), textcoords="offset points", ha="center")  # fmt: skip
            axes.axhline(0.0, color="0.4", lw=3)
            axes.margins(y=0.12)
            axes.set(xlabel="t (ms)", ylabel="height z (mm)")
            plot.legend(figure, axes)
        return figure

    def scene(self, t, w):
        """The particle over its surface, in mm; see `System.scene`."""
        names = ("x (mm)", "height z (mm)")
        return Scene([], [(0.0, 1e3 * w[0])], [], ground=0.0, axes=names)
