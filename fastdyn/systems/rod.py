"""Block on a rotating rod, with friction (course 3.3.2, example 3)."""

import dataclasses
import itertools
import math

import numpy as np

from fastdyn.plot.scene import Scene

from .base import State, System, derived, initial, invariant, parameter, quantity


@dataclasses.dataclass(frozen=True)
class Rod(System):
    """
    Block that slides out along a rod turning in the horizontal plane at constant speed.

    Equation of motion, from Newton's law in polar coordinates with N = 2 m w r' and T = mu N
    eliminated, w the parameter `omega`::

        r'' + 2 mu w r' - w² r = 0

    State ``[r, v]`` in m and m/s with v = r'; from r = 0 with v = V. The mass scales the forces
    only. The course gives no numbers.

    Notes
    -----
    Exact: r = V / (w s) exp(-mu w t) sinh(s w t) with s = sqrt(1 + mu²): a growing mode of rate
    w (s - mu), whose amplitude is an invariant, and a decaying one of rate -w (s + mu).

    The equation holds for a block that slides inwards, too: there r' and N change their signs
    together, and the friction mu |N| is against the slip either way. Nothing holds a block that
    stops, as N is zero with r'.
    """

    name = "rod"
    title = "Block on a rotating rod"
    source = "course 3.3.2, example 3"
    states = (State("r", "m", "distance from the axis"), State("v", "m/s", "radial velocity"))
    t_end = 2.0

    omega: float = parameter(2.0, "rad/s", "angular velocity of the rod", positive=True)
    mu: float = parameter(0.3, "1", "coefficient of friction", negative=False)
    V: float = initial(0.1, "m/s", "radial speed at the start", positive=True)
    m: float = parameter(1.0, "kg", "mass", positive=True)

    def initial_state(self):
        return (0.0, self.V)

    @staticmethod
    def rhs(t, w, omega, mu, m):
        r, v = w
        return [v, omega * omega * r - 2.0 * mu * omega * v]

    @invariant("m/s", "amplitude of the growing mode")
    def growing(t, w, omega, mu, m):
        """(r' - b r) exp(-a t), with a and b the rates of the growing and the decaying mode."""
        r, v = w
        root = np.sqrt(1.0 + mu * mu)
        return (v + omega * (mu + root) * r) * np.exp(-omega * (root - mu) * t)

    @quantity("N", "normal force N")
    def normal_force(t, w, omega, mu, m):
        """Force of the rod across itself, 2 m w r'."""
        return 2.0 * m * omega * w[1]

    @quantity("N", "friction force T")
    def friction_force(t, w, omega, mu, m):
        """Force of the rod along itself, against the slip, mu N."""
        return mu * 2.0 * m * omega * w[1]

    def exact(self, t):
        t = np.asarray(t, float)
        root = math.hypot(1.0, self.mu)
        up = np.exp(self.growth_rate * t)
        down = np.exp(-self.decay_rate * t)
        scale = self.V / (2.0 * self.omega * root)
        growing = scale * np.expm1(-2.0 * self.omega * root * t)  # 0 at the start, to rounding
        speed = scale * (self.growth_rate * up + self.decay_rate * down)
        return np.array([-growing * up, speed])

    @derived("1/s")
    def growth_rate(self) -> float:
        """Rate w (s - mu) at which r grows in the end."""
        return self.omega / (math.hypot(1.0, self.mu) + self.mu)

    @derived("1/s")
    def decay_rate(self) -> float:
        """Rate w (s + mu) of the mode that dies out."""
        return self.omega * (math.hypot(1.0, self.mu) + self.mu)

    def figure(self, results, **options):
        """Path seen from above, beside the distance and the forces; see `System.figure`."""
        from fastdyn import plot

        with plot.slides():
            figure, (path,), (distance, force) = plot.pictures_and_panels(1, 2, **options)
            later = itertools.cycle(plot.COLOURS[len(results) :] + plot.COLOURS)
            forces = [(Rod.normal_force, later), (Rod.friction_force, later)]
            for label, result in results.items():
                t, y = plot.curve(result)
                angle = result.system.omega * t
                path.plot(y[0] * np.cos(angle), y[0] * np.sin(angle), label=label)
                distance.plot(t, y[0], label=label)
                exact = plot.exact_curve(result.system, t)[0]
                distance.plot(t, exact, "k--", lw=1.2, label="exact")
                for function, colour in forces:
                    values = result.system.along(function, t, y)
                    about = function.label if len(results) == 1 else f"{label}, {function.label}"
                    force.plot(t, values, color=next(colour), label=about)
            path.plot(0, 0, "o", color="0.4", ms=8, label="axis")
            path.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
            path.locator_params(nbins=5)
            distance.set_ylabel("distance r (m)")
            force.set(xlabel="t (s)", ylabel="force (N)")
            for panel in (path, distance, force):
                plot.own_legend(panel)
        return figure

    def scene(self, t, w):
        """The rod and the block seen from above; see `System.scene`."""
        angle = self.omega * t
        reach = 1.1 * float(self.exact(self.t_end)[0])
        direction = np.array([math.cos(angle), math.sin(angle)])
        tip = reach * direction
        return Scene([([0.0, tip[0]], [0.0, tip[1]])], [tuple(w[0] * direction)], [(0.0, 0.0)])
