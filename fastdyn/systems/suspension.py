"""Vehicle on its spring (course 3.3.2, example 2)."""

import dataclasses
import math

import numpy as np

from fastdyn.plot.scene import Scene, spring

from .base import State, System, derived, event, initial, invariant, parameter, quantity


@dataclasses.dataclass(frozen=True)
class Suspension(System):
    """
    Vehicle, as a mass on a spring that stands on the ground, moving vertically.

    Equation of motion::

        m x'' = -k (x - L0) - m g

    State ``[x, v]``, length of the spring in m and its rate in m/s; released from rest at x0.
    The mass is above the spring, x counts upwards, and the weight shortens the spring: the
    course's figure. (Hanging from the spring, m g would have the other sign.) The course gives
    no numbers; the defaults are a quarter of a small car.

    Notes
    -----
    Exact: x = x_eq + (x0 - x_eq) cos(w t), with w = sqrt(k/m) and x_eq = L0 - m g / k. So the
    static deflection m g / k tells the frequency, w = sqrt(g / deflection).
    """

    name = "suspension"
    title = "Suspension"
    source = "course 3.3.2, example 2"
    states = (State("x", "m", "length of the spring"), State("v", "m/s", "its rate"))
    t_end = 3.0

    m: float = parameter(250.0, "kg", "mass", positive=True)
    k: float = parameter(2e4, "N/m", "stiffness of the spring", positive=True)
    L0: float = parameter(0.5, "m", "length without load", positive=True)
    x0: float = initial(0.5, "m", "length at release", positive=True)
    g: float = parameter(9.81, "m/s²", "acceleration of gravity", positive=True)

    def initial_state(self):
        return (self.x0, 0.0)

    @staticmethod
    def rhs(t, w, m, k, L0, g):
        x, v = w
        return [v, -k / m * (x - L0) - g]

    @invariant("J", "energy E")
    def energy(t, w, m, k, L0, g):
        """Kinetic energy, energy of the spring, and weight times height."""
        x, v = w
        return 0.5 * m * v * v + 0.5 * k * (x - L0) ** 2 + m * g * x

    @quantity("N", "spring force")
    def spring_force(t, w, m, k, L0, g):
        """Force of the spring on the vehicle, upwards where the spring is compressed."""
        return k * (L0 - w[0])

    @event()
    def turning(t, w, m, k, L0, g):
        """Zero where the vehicle turns back."""
        return w[1]

    def exact(self, t):
        w = self.natural_frequency
        A = self.x0 - self.equilibrium
        phase = w * np.asarray(t, float)
        return np.array([self.equilibrium + A * np.cos(phase), -w * A * np.sin(phase)])

    @derived("m")
    def static_deflection(self) -> float:
        """How much the weight shortens the spring, m g / k."""
        return self.m * self.g / self.k

    @derived("m")
    def equilibrium(self) -> float:
        """Length of the spring at rest, about which it swings."""
        return self.L0 - self.static_deflection

    @derived("m")
    def amplitude(self) -> float:
        """Greatest distance from the equilibrium."""
        return abs(self.x0 - self.equilibrium)

    @derived("rad/s")
    def natural_frequency(self) -> float:
        """Angular frequency, sqrt(k/m)."""
        return math.sqrt(self.k / self.m)

    @derived("Hz")
    def frequency(self) -> float:
        """Oscillations in a second."""
        return self.natural_frequency / (2.0 * math.pi)

    @derived("s")
    def period(self) -> float:
        """Time of one oscillation."""
        return 2.0 * math.pi / self.natural_frequency

    def figure(self, results, **options):
        """Length of the spring against time, its answers marked; see `System.figure`."""
        from fastdyn import plot

        with plot.slides():
            figure, (axes,) = plot.column(1, **{"figsize": (10, 5.5)} | options)
            for label, result in results.items():
                t, y = plot.curve(result)
                axes.plot(t, y[0], label=label)
                dots = np.linspace(t[0], t[-1], 80)
                exact = plot.exact_curve(result.system, dots)[0]
                axes.plot(dots, exact, "k.", ms=5, label="exact")
            axes.axhline(self.L0, color="0.6", lw=1.2, label="length without load $L_0$")
            axes.axhline(self.equilibrium, color="0.6", ls=":", lw=1.6, label="equilibrium")
            first = next(iter(results.values()))
            start = float(first.t[0])
            end = float(first.t[-1])
            T = self.period
            x = self.equilibrium
            lowest = self.equilibrium - self.amplitude
            if end >= start + 2.5 * T:
                trough = start + (0.5 if self.x0 > x else 1.0) * T
                self._mark(axes, (trough + T, x), (trough + T, lowest), "amplitude")
                level = lowest - 0.2 * self.amplitude
                self._mark(axes, (trough, level), (trough + T, level), "period")
            beside = end + 0.15 * (end - start)
            self._mark(axes, (beside, self.L0), (beside, x), "static\ndeflection\n$mg/k$")
            axes.set(xlabel="t (s)", ylabel="length of the spring x (m)")
            axes.set_xlim(start, beside + 0.05 * (end - start))
            axes.set_xticks([tick for tick in axes.get_xticks() if start <= tick <= end])
            axes.margins(y=0.1)
            plot.legend(figure, axes)
        return figure

    @staticmethod
    def _mark(axes, start, end, label):
        """An arrow with two heads, and its name to the left of it or below it."""
        axes.annotate("", start, end, arrowprops={"arrowstyle": "<->", "color": "0.3", "lw": 1.4})
        axes.plot(*zip(start, end, strict=True), alpha=0.0)  # the axes reach as far
        middle = 0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])
        upright = start[0] == end[0]
        where, ha, va = ((-8, 0), "right", "center") if upright else ((0, -8), "center", "top")
        white = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5}
        axes.annotate(label, middle, xytext=where, textcoords="offset points", ha=ha, va=va,
                      bbox=white)  # fmt: skip

    def scene(self, t, w):
        """The vehicle on its spring; see `System.scene`."""
        size = 0.5 * self.L0
        x = w[0]
        car = (size * np.array([-1, 1, 1, 0.5, 0.3, -0.6, -0.8, -1]),
               x + size * np.array([0, 0, 0.4, 0.5, 0.9, 0.9, 0.5, 0.45]))  # fmt: skip
        lines = [spring((0.0, 0.0), (0.0, x)), ([-size, size], [x, x])]
        names = ("", "length of the spring x (m)")
        return Scene(lines, [(0.0, x)], [], bodies=[car], ground=0.0, axes=names)
