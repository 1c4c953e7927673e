"""Satellite in orbit around a fixed planet (course 3.3.3, example 2)."""

import contextlib
import dataclasses
import itertools
import math

import numpy as np

from fastdyn.plot.scene import Scene

from .base import State, System, derived, event, initial, invariant, parameter, quantity
from .formulas.kepler import eccentric_anomaly


@dataclasses.dataclass(frozen=True)
class Satellite(System):
    """
    Satellite in orbit around a fixed planet, in the plane of its orbit.

    Equations of motion, with r² = x² + y²::

        x'' = -GM x / r³        y'' = -GM y / r³

    State ``[x, y, vx, vy]`` in m and m/s. The satellite is launched from (R, 0) with velocity
    (0, V), clockwise if V is negative; the course takes GM = R = V = 1, a circular orbit, and
    t = 100 s, almost 16 revolutions.

    Notes
    -----
    Launched perpendicular to the radius, the satellite starts at an end of the major axis of
    its ellipse: the near end if V² > GM/R, the far end if V² < GM/R. With the signed eccentricity
    e = R V²/GM - 1 one formula serves both::

        x = a (cos u - e)       y = a sqrt(1 - e²) sin u       sqrt(GM/a³) t = u - e sin u

    **Erratum.** The course's script computes the speed for the energy as
    ``vmag = sqrt(w_values(i,1)^2 + w_values(i,2)^2)``, which is the distance: components 1 and 2
    are x and y. The speed is in components 3 and 4. On the exact circular orbit with
    GM = R = V = 1 both are 1, so the slip does not show there; on any other orbit the printed
    formula makes the energy vary although the motion is exact. The script also has ``Time`` and
    ``time``, ``length(t)`` where t is called ``t_values``, and ``w_vlues``.
    """

    name = "satellite"
    title = "Satellite orbit"
    source = "course 3.3.3, example 2"
    states = (
        State("x", "m", "position"),
        State("y", "m", "position"),
        State("vx", "m/s", "velocity"),
        State("vy", "m/s", "velocity"),
    )
    t_end = 100.0

    GM: float = parameter(1.0, "m³/s²", "gravitational constant times mass", positive=True)
    R: float = initial(1.0, "m", "distance at launch", positive=True)
    V: float = initial(1.0, "m/s", "speed at launch, across the radius")

    def initial_state(self):
        return (self.R, 0.0, 0.0, self.V)

    @staticmethod
    def rhs(t, w, GM):
        x, y, vx, vy = w
        r = math.sqrt(x * x + y * y)
        pull = -GM / (r * r * r)
        return [vx, vy, pull * x, pull * y]

    @invariant("m²/s²", "energy E/m")
    def energy(t, w, GM):
        """Kinetic plus potential energy per unit mass, v²/2 - GM/r, with v² = vx² + vy²."""
        x, y, vx, vy = w
        return 0.5 * (vx * vx + vy * vy) - GM / np.sqrt(x * x + y * y)

    @invariant("m²/s", "angular momentum H/m")
    def angular_momentum(t, w, GM):
        """Angular momentum about the planet per unit mass, x vy - y vx."""
        x, y, vx, vy = w
        return x * vy - y * vx

    @quantity("m", "distance r")
    def distance(t, w, GM):
        """Distance from the planet's centre."""
        x, y, _, _ = w
        return np.sqrt(x * x + y * y)

    @event()
    def apsis(t, w, GM):
        """Zero where the distance is smallest or largest (everywhere, on a circular orbit)."""
        x, y, vx, vy = w
        return x * vx + y * vy

    @event(direction=1)
    def periapsis(t, w, GM):
        """Zero, and rising, where the distance is smallest."""
        x, y, vx, vy = w
        return x * vx + y * vy

    @event(direction=-1)
    def apoapsis(t, w, GM):
        """Zero, and falling, where the distance is largest."""
        x, y, vx, vy = w
        return x * vx + y * vy

    @event(direction=1)
    def revolution(t, w, GM):
        """Zero, and rising, where the x axis is passed on the side of the launch."""
        x, y, vx, vy = w
        return math.copysign(1.0, x * vy - y * vx) * y

    def exact(self, t):
        """
        Exact state from Kepler's equation, as `System.exact`.

        Raises
        ------
        ValueError
            If V is zero (a radial fall) or at least the escape speed (no ellipse).
        """
        t = np.asarray(t, float)
        a = self.semi_major_axis
        e = self.signed_eccentricity
        b = self.R * self.V * math.sqrt(a / self.GM)  # sqrt(1 - e²) a, with the sense of V
        n = math.sqrt(self.GM / a**3)
        u = eccentric_anomaly(n * t, e)
        rate = n / (1.0 - e * np.cos(u))
        return np.array(
            [a * (np.cos(u) - e), b * np.sin(u), -a * np.sin(u) * rate, b * np.cos(u) * rate]
        )

    @derived("s")
    def period(self) -> float:
        """Time of one revolution, 2 pi sqrt(a³/GM); ValueError if there is no ellipse."""
        return 2.0 * math.pi * math.sqrt(self.semi_major_axis**3 / self.GM)

    @derived("m")
    def semi_major_axis(self) -> float:
        """Half the longest diameter, 1/(2/R - V²/GM); ValueError if there is no ellipse."""
        if 1.0 - self.eccentricity <= np.finfo(float).eps:
            if self.V**2 < self.GM / self.R:
                why = "a launch without speed across the radius falls straight onto the planet"
            else:
                why = "at or above the escape speed the satellite does not come back"
            raise ValueError(
                f"The satellite with V = {self.V:g} m/s is on no ellipse: {why}. "
                f"Choose V between 0 and {self.escape_speed:g} m/s, either sense."
            )
        return 1.0 / (2.0 / self.R - self.V**2 / self.GM)

    @derived("")
    def eccentricity(self) -> float:
        """0 for a circle, below 1 for an ellipse, 1 for a parabola or a radial fall."""
        return abs(self.signed_eccentricity)

    @property
    def signed_eccentricity(self) -> float:
        """R V²/GM - 1: positive for a launch at the near end of the ellipse, else negative."""
        return self.R * self.V**2 / self.GM - 1.0

    @derived("m/s")
    def circular_speed(self) -> float:
        """Speed of the circular orbit at distance R, sqrt(GM/R)."""
        return math.sqrt(self.GM / self.R)

    @derived("m/s")
    def escape_speed(self) -> float:
        """Speed at which the satellite does not come back, sqrt(2 GM/R)."""
        return math.sqrt(2.0 * self.GM / self.R)

    def figure(self, results, **options):
        """
        Orbits beside the exact ellipse, above energy and angular momentum against time.

        See `System.figure`; the options go to `matplotlib.pyplot.figure`.
        """
        from fastdyn import plot

        duration = max(result.t[-1] for result in results.values())
        with contextlib.suppress(ValueError):  # an orbit that does not close
            duration = min(duration, self.period)
        exact = plot.exact_curve(self, np.linspace(0.0, duration, 721))
        with plot.slides():
            figure, pictures, panels = plot.pictures_and_panels(len(results), 2, **options)
            colours = itertools.cycle(plot.COLOURS)
            for axes, colour, (label, result) in zip(
                pictures, colours, results.items(), strict=False
            ):
                alone = label if len(results) == 1 else None
                plot.plane(axes, exact[:2], plot.curve(result)[1][:2], colour, alone)
                axes.plot(0, 0, "o", color="0.4", ms=9, label="planet")
                if alone is None:
                    axes.set_title(label, color=colour)
            plot.invariants(panels, self, results)
            plot.legend(figure, *pictures)
        return figure

    def scene(self, t, w):
        """The satellite and its planet; see `System.scene`."""
        around = np.linspace(0.0, 2.0 * math.pi, 61)
        planet = (0.12 * self.R * np.cos(around), 0.12 * self.R * np.sin(around))
        return Scene([], [(w[0], w[1])], [], bodies=[planet])
