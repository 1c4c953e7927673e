"""Vehicle on its spring (course 3.3.2, example 2)."""

import dataclasses
import math
from typing import ClassVar

import numpy as np

from fastdyn.systems.base.declare import State, initial, parameter, quantity
from fastdyn.systems.base.system import System


@quantity("J", "energy E")
def energy(t, w, m, k, L0, g):
    """Kinetic energy, energy of the spring, and weight times height."""
    x, v = w
    return 0.5 * m * v * v + 0.5 * k * (x - L0) ** 2 + m * g * x


@quantity("N", "spring force")
def spring_force(t, w, m, k, L0, g):
    """Force of the spring on the vehicle, upwards where the spring is compressed."""
    return k * (L0 - w[0])


def turning(t, w, m, k, L0, g):
    """Zero where the vehicle turns back."""
    return w[1]


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

    Parameters
    ----------
    m : float
        Mass, kg.
    k : float
        Stiffness of the spring, N/m.
    L0 : float
        Length of the spring without load, m.
    x0 : float
        Length from which it is released, m.
    g : float
        Acceleration of gravity, m/s².

    Raises
    ------
    TypeError, ValueError
        For an unknown parameter, one that is not a finite number, or m, k, L0, x0 or g not above
        zero.

    Notes
    -----
    Exact: x = x_eq + (x0 - x_eq) cos(w t), with w = sqrt(k/m) and x_eq = L0 - m g / k. So the
    static deflection m g / k tells the frequency, w = sqrt(g / deflection).

    Source: course, chapter 3.3.2, example 2.
    """

    name = "suspension"
    title = "Suspension"
    source = "course 3.3.2, example 2"
    states = (State("x", "m", "length of the spring"), State("v", "m/s", "its rate"))
    t_end = 3.0
    invariants: ClassVar = {"energy": energy}
    quantities: ClassVar = {"spring_force": spring_force}
    events: ClassVar = {"turning": turning}
    derived: ClassVar = {
        "static_deflection": "m",
        "equilibrium": "m",
        "amplitude": "m",
        "natural_frequency": "rad/s",
        "frequency": "Hz",
        "period": "s",
    }

    m: float = parameter(250.0, "kg", "mass", positive=True)
    k: float = parameter(2e4, "N/m", "stiffness of the spring", positive=True)
    L0: float = parameter(0.5, "m", "length without load", positive=True)
    x0: float = initial(0.5, "m", "length at release", positive=True)
    g: float = parameter(9.81, "m/s²", "acceleration of gravity", positive=True)

    @staticmethod
    def rhs(t, w, m, k, L0, g):
        """Derivative of the state."""
        x, v = w
        return [v, -k / m * (x - L0) - g]

    def initial_state(self):
        """State (x0, 0)."""
        return (self.x0, 0.0)

    def exact(self, t):
        """Exact state, shape (2,) or (2, n_points)."""
        w, A = self.natural_frequency, self.x0 - self.equilibrium
        phase = w * np.asarray(t, float)
        return np.array([self.equilibrium + A * np.cos(phase), -w * A * np.sin(phase)])

    @property
    def static_deflection(self) -> float:
        """How much the weight shortens the spring, m g / k, m."""
        return self.m * self.g / self.k

    @property
    def equilibrium(self) -> float:
        """Length of the spring at rest, about which it swings, m."""
        return self.L0 - self.static_deflection

    @property
    def amplitude(self) -> float:
        """Greatest distance from the equilibrium, m."""
        return abs(self.x0 - self.equilibrium)

    @property
    def natural_frequency(self) -> float:
        """Angular frequency sqrt(k/m), rad/s."""
        return math.sqrt(self.k / self.m)

    @property
    def frequency(self) -> float:
        """Oscillations in a second, Hz."""
        return self.natural_frequency / (2.0 * math.pi)

    @property
    def period(self) -> float:
        """Time of one oscillation, s."""
        return 2.0 * math.pi / self.natural_frequency

    def figure(self, results, **options):
        """Length of the spring against time, with its equilibrium; see `System.figure`."""
        from fastdyn import plot

        with plot.slides():
            figure, (axes,) = plot.column(1, **{"figsize": (10, 5.5)} | options)
            for label, result in results.items():
                t, y = plot.curve(result)
                axes.plot(t, y[0], label=label)
                axes.plot(t, plot.exact_curve(result.system, t)[0], "k--", lw=1.2, label="exact")
            axes.axhline(self.L0, color="0.6", lw=1.2, label="length without load")
            axes.axhline(self.equilibrium, color="0.6", ls=":", lw=1.6, label="equilibrium")
            axes.set(xlabel="t (s)", ylabel="length of the spring x (m)")
            plot.legend(figure, axes)
        return figure
