"""A pendulum whose cable cannot push: taut along the circle, slack in free flight."""

# ruff: noqa: E741 - the course calls the length l
import dataclasses
import math
from typing import Any, ClassVar

import numpy as np

from fastdyn.plot import pendulums
from fastdyn.solve.phases import Phase, solve_phases

from .base import System, derived, event, initial, parameter, quantity
from .base.declare import of_instance
from .base.result import SystemResult
from .base.solve_arguments import completed, full_state, span
from .pendulum_xy import PendulumXY, motion

NOTHING = 1e-9  # of a length, a speed or a weight


@dataclasses.dataclass(frozen=True)
class Cable(System):
    """
    Pendulum on a cable that goes slack: a mass on the circle, or in free flight inside it.

    Equations of motion, y downwards; taut those of `PendulumXY`, slack those of free fall::

        m x'' + R x/l = 0    m y'' + R y/l = m g    x x'' + y y'' = -(x'² + y'²)    (taut)
        x'' = 0              y'' = g                                               (slack)

    Where the tension R falls to zero the mass flies on freely, until the cable is taut again. Then
    the velocity along the cable is lost at once, the velocity across it is kept (an inelastic
    impact), and the mass goes on along the circle, held there by projection.

    State ``[x, y, vx, vy]`` in m and m/s; from the lowest point (0, l) with velocity (V0, 0), of
    either sign. The course gives no numbers; the defaults are its pendulum, pushed off so that the
    cable goes slack.

    Notes
    -----
    The cable goes slack for V0² between 2 g l and 5 g l, at the angle with
    cos theta = (2 - V0²/(g l))/3. Parabola and circle touch thrice there, so they meet again at
    -3 times that angle. Where the cable stays taut the exact solution is that of `Pendulum`.
    """

    name = "cable"
    title = "Pendulum on a slack cable"
    source = "course 3.3.2, example 4, slack cable"
    states = PendulumXY.states
    t_end = 4.0
    none_in: ClassVar = {"flight": ("tension",)}

    g: float = parameter(9.81, "m/s²", "acceleration of gravity", positive=True)
    l: float = parameter(1.0, "m", "length of the cable", positive=True)
    V0: float = initial(5.9, "m/s", "horizontal velocity at launch")
    m: float = parameter(1.0, "kg", "mass", positive=True)

    initial_state = PendulumXY.initial_state

    @staticmethod
    def rhs(t, w, g, l, m):
        """Derivative of the state while the cable is taut; see `falling` for the flight."""
        ax, ay, _ = motion(w, g, l, m, 0.0)
        return [w[2], w[3], ax, ay]

    @staticmethod
    def falling(t, w, g, l, m):
        """Derivative of the state in free flight, while the cable is slack."""
        return [w[2], w[3], 0.0, g]

    @staticmethod
    def project(t, w, g, l, m):
        """The nearest state on the circle, with a velocity along it."""
        return PendulumXY.project(t, w, g, l, m, 0.0)

    @quantity("J", "energy E")
    def energy(t, w, g, l, m):
        """Kinetic plus potential energy, zero at rest at the bottom; each impact takes some."""
        _, y, vx, vy = w
        return m * (0.5 * (vx * vx + vy * vy) + g * (l - y))

    @quantity("N", "cable tension R")
    def tension(t, w, g, l, m):
        """Force in the cable where it is taut; the state alone does not tell whether it is."""
        return motion(w, g, l, m, 0.0)[2]

    @quantity("m", "distance from the pivot")
    def distance(t, w, g, l, m):
        """Distance from the pivot, the length of the cable where it is taut."""
        return np.sqrt(w[0] * w[0] + w[1] * w[1])

    @event()
    def bottom(t, w, g, l, m):
        """Zero where the mass is below the pivot, or above it."""
        return w[0]

    @of_instance
    def solve(self, t_span=None, y0=None, method="RK45", project=None, **options):
        """
        Solve through the phases of the cable; see `fastdyn.solve.phases.solve_phases`.

        Parameters
        ----------
        t_span, y0, method, **options
            As for `System.solve`; there is always a dense output.
        project : None or True
            The circle is always held by projection.

        Returns
        -------
        SystemResult
            With `phases`, a list of ("cable" or "flight", start, end); at an impact the time is
            there twice, with the state before and after.

        Raises
        ------
        ValueError
            As `System.solve` does, for a start beyond the reach of the cable, and for SciPy's
            methods.
        """
        if project not in (None, True):
            raise ValueError("leave `project` out: the cable always projects onto its own circle.")
        given: dict[str, Any] = {"dense_output": True} | completed(self, method, options)
        t_span = span(self, t_span)
        w = np.array(self.initial_state() if y0 is None else full_state(self, y0), dtype=float)
        first, w = self.first_phase(w)
        run = solve_phases(self.phases(), first, t_span, w, method, args=self.args, **given)
        return CableResult(run, self.as_started(t_span[0], y0))

    @of_instance
    def ensemble(self, t_span=None, y0=None, method="RK45", **given):
        """Refused: a motion in phases is solved one by one."""
        raise ValueError("A cable that goes slack is solved one by one: call `solve` in a loop.")

    def phases(self):
        """The motion on the cable, and the flight: see `System.phases`."""
        return {
            "cable": Phase(self.rhs, slack, after_slack, {"project": self.project}),
            "flight": Phase(self.falling, taut, after_flight),
        }

    def first_phase(self, w):
        """Name of the first phase and the state that it starts from."""
        x, y, vx, vy = w
        r = math.hypot(x, y)
        if r > self.l * (1.0 + NOTHING):
            raise ValueError(
                f"`y0` is {r:g} m from the pivot: farther than the cable of {self.l:g} m reaches."
            )
        inwards = x * vx + y * vy < -NOTHING * r * math.hypot(vx, vy)
        if r < self.l * (1.0 - NOTHING) or inwards:
            return "flight", w
        return after_flight(0.0, w, *self.args)

    by_angle = PendulumXY.by_angle

    def exact(self, t):
        """Exact state if the cable stays taut, as `System.exact`."""
        if not math.isnan(self.slack_angle):
            raise ValueError("No exact solution of a cable that goes slack is known to fastdyn.")
        return PendulumXY(self.g, self.l, self.V0, self.m).exact(t)

    @derived("rad")
    def slack_angle(self) -> float:
        """Size of the angle at which the cable first goes slack; NaN if it stays taut."""
        return self.by_angle.slack_angle

    @derived("s")
    def slack_time(self) -> float:
        """Time at which the cable first goes slack; NaN if it stays taut."""
        return self.by_angle.slack_time

    @derived("rad")
    def taut_angle(self) -> float:
        """Angle from the bottom at which the cable is first taut again; NaN if never slack."""
        if math.isnan(self.slack_angle):
            return math.nan
        return abs(math.remainder(3.0 * self.slack_angle, 2.0 * math.pi))

    def figure(self, results, **options):
        """Paths, and tension and slack against time; see `System.figure`."""
        return pendulums.cable(results, self.l, **options)

    scene = PendulumXY.scene


@event(direction=-1, terminal=True)
def slack(t, w, g, l, m):
    """Zero, and falling, where the cable would have to push."""
    return motion(w, g, l, m, 0.0)[2]


@event(direction=1, terminal=True)
def taut(t, w, g, l, m):
    """Zero, and rising, where the slack cable is stretched again."""
    x, y, _, _ = w
    return x * x + y * y - l * l


def after_slack(t, w, g, l, m):
    """The mass flies on from where it is."""
    return "flight", w


def after_flight(t, w, g, l, m):
    """The cable stops the velocity along itself, which is lost; then it pulls, or not at all."""
    w = Cable.project(t, w, g, l, m)
    return ("cable" if Cable.tension(t, w, g, l, m) > -NOTHING * m * g else "flight"), w


class CableResult(SystemResult):
    """A SystemResult with `phases`, a list of ("cable" or "flight", start, end)."""

    def quantities(self):
        """As of any system, with no tension in the slack cable."""
        found = super().quantities()
        slack = pendulums.in_flight(self.t, self.phases)
        slack[1:] &= np.diff(self.t) != 0.0  # a time that is there twice: its second is taut again
        for name in Cable.none_in["flight"]:
            found[name] = np.where(slack, 0.0, np.maximum(found[name], 0.0))
        return found
