"""Stone thrown from a tower: how far? (course 3.3.2, example 1)"""

import dataclasses
import math

import numpy as np

from fastdyn.plot.scene import Scene

from .base import State, System, derived, event, initial, invariant, parameter

MILE_PER_HOUR = 0.44704  # m/s, exactly


@dataclasses.dataclass(frozen=True)
class Tower(System):
    """
    Stone thrown from the top of a tower, without air resistance.

    Equations of motion, x'' = 0 and z'' = -g. State ``[x, z, vx, vz]`` in m and m/s, z upwards
    from the ground; from (0, h) with speed V at `angle` above the horizontal. Defaults: the
    Kremlin palace, 71 m, and 25 mph at 45 degrees.

    Notes
    -----
    The stone lands at D = V cos a [V sin a + sqrt((V sin a)² + 2 g h)] / g, farthest for
    tan a = V / sqrt(V² + 2 g h), at D = V sqrt(V² + 2 g h) / g.

    The course prints 36 m (118 ft); 25 mph gives 37.10 m. The printed distance belongs to 25 mph
    rounded to 11 m/s, 36.40 m. At the best angle, 16 degrees, the distance is 44.39 m.
    """

    name = "tower"
    title = "Throw from a tower"
    source = "course 3.3.2, example 1, throw"
    states = (
        State("x", "m", "distance"),
        State("z", "m", "height"),
        State("vx", "m/s", "velocity"),
        State("vz", "m/s", "velocity upwards"),
    )
    t_end = 10.0

    h: float = initial(71.0, "m", "height of the tower", positive=True)
    V: float = initial(25.0 * MILE_PER_HOUR, "m/s", "speed of the throw", positive=True)
    angle: float = initial(0.25 * math.pi, "rad", "angle above the horizontal")
    g: float = parameter(9.81, "m/s²", "acceleration of gravity", positive=True)

    def initial_state(self):
        return (0.0, self.h, self.V * math.cos(self.angle), self.V * math.sin(self.angle))

    @staticmethod
    def rhs(t, w, g):
        return [w[2], w[3], 0.0, -g]

    @invariant("m²/s²", "energy E/m")
    def energy(t, w, g):
        """Kinetic plus potential energy per unit mass, zero at rest on the ground."""
        _, z, vx, vz = w
        return 0.5 * (vx * vx + vz * vz) + g * z

    @event(direction=-1, terminal=True)
    def ground(t, w, g):
        """Zero, and falling, where the stone hits the ground z = 0; ends the run."""
        return w[1]

    @event(direction=-1)
    def apex(t, w, g):
        """Zero, and falling, at the highest point."""
        return w[3]

    def exact(self, t):
        """Exact state, as `System.exact`; the motion goes on through the ground."""
        t = np.asarray(t, float)
        _, h, vx, vz = self.initial_state()
        return np.array([vx * t, h + vz * t - 0.5 * self.g * t**2, vx + 0.0 * t, vz - self.g * t])

    @derived("s")
    def flight_time(self) -> float:
        """Time at which the stone lands."""
        up = self.V * math.sin(self.angle)
        return (up + math.sqrt(up**2 + 2.0 * self.g * self.h)) / self.g

    @derived("m")
    def range(self) -> float:
        """Distance D at which the stone lands."""
        return self.V * math.cos(self.angle) * self.flight_time

    @derived("m")
    def apex_height(self) -> float:
        """Greatest height above the ground."""
        return self.h + max(0.0, self.V * math.sin(self.angle)) ** 2 / (2.0 * self.g)

    @derived("rad")
    def best_angle(self) -> float:
        """Angle of the farthest throw."""
        return math.atan2(self.V, math.sqrt(self.V**2 + 2.0 * self.g * self.h))

    @derived("m")
    def best_range(self) -> float:
        """Distance of the farthest throw."""
        return self.V * math.sqrt(self.V**2 + 2.0 * self.g * self.h) / self.g

    def figure(self, results, **options):
        """Trajectories in their plane; see `System.figure`."""
        from fastdyn import plot

        with plot.slides():
            figure, (axes,) = plot.column(1, **{"figsize": (9, 8)} | options)
            for label, result in results.items():
                axes.plot(*plot.curve(result)[1][:2], label=label)
            axes.axhline(0.0, color="0.4", lw=3)
            axes.plot([0.0, 0.0], [0.0, self.h], color="0.4", lw=6, label="tower")
            axes.set(xlabel="distance x (m)", ylabel="height z (m)", aspect="equal")
            plot.legend(figure, axes)
        return figure

    def scene(self, t, w):
        """The tower and the stone; see `System.scene`."""
        thick = 0.03 * self.h
        tower = ([-thick, 0.0, 0.0, -thick], [0.0, 0.0, self.h, self.h])
        names = ("distance x (m)", "height z (m)")
        return Scene([], [(w[0], w[1])], [], bodies=[tower], ground=0.0, axes=names)
