"""Pendulum on a light cable, with the angle as its coordinate (course 3.3.2, example 4)."""

# ruff: noqa: E741 - the course calls the length l
import dataclasses
import math
from fractions import Fraction
from typing import ClassVar

import numpy as np

from fastdyn.plot import pendulums

from .base import State, System, derived, event, initial, invariant, parameter, quantity
from .formulas import elliptic


@dataclasses.dataclass(frozen=True)
class Pendulum(System):
    """
    Pendulum on a light cable, pushed off at its lowest point, or released at an angle.

    Equation of motion, from Newton's law with the cable force R eliminated::

        theta'' = -(g/l) sin theta        R/m = l theta'² + g cos theta

    State ``[theta, omega]`` with omega = theta', in rad and rad/s, theta counted from the
    vertical and not wrapped; from theta = `theta0`, the lowest point unless given, with
    omega = V0/l, of either sign. The mass scales energy and tension only. Defaults and t = 20 s
    are those of the course's script for the same pendulum in Cartesian coordinates.

    Notes
    -----
    With w0 = sqrt(g/l) and k = V0 / (2 sqrt(g l)) the exact solution from the lowest point is

    - swinging, k < 1: theta = 2 asin(k sn(w0 t | k²)), period 4 K(k²) / w0;
    - separatrix, k = 1: theta = 4 atan(exp(w0 t)) - pi, which takes for ever to reach the top;
    - whirling, k > 1: theta = 2 am(k w0 t | 1/k²), one turn in 2 K(1/k²) / (k w0).

    The course's am jumps from pi to -pi at the top; here the angle goes on growing. A pendulum
    that starts at `theta0` is one that passed the lowest point before, with
    k² = V0² / (4 g l) + sin² (theta0/2).

    The equation holds while R > 0. A cable goes slack at cos theta = (2 - V0²/(g l))/3 if V0²
    lies between 2 g l and 5 g l. ``solve(events="slack")`` notices this and stops,
    the system `cable` goes on in free flight until the cable is taut again; without the event
    the solution is that of a rigid rod.
    """

    name = "pendulum"
    title = "Pendulum"
    source = "course 3.3.2, example 4"
    states = (
        State("theta", "rad", "angle from the vertical"),
        State("omega", "rad/s", "angular velocity"),
    )
    t_end = 20.0
    explored: ClassVar = {"V0": 4.0}  # a swing of 79 degrees; the default's, of 1.8, is hardly seen

    g: float = parameter(9.81, "m/s²", "acceleration of gravity", positive=True)
    l: float = parameter(1.0, "m", "length of the cable", positive=True)
    V0: float = initial(0.1, "m/s", "velocity at launch, across the cable")
    m: float = parameter(1.0, "kg", "mass", positive=True)
    theta0: float = initial(0.0, "rad", "angle at launch")

    def initial_state(self):
        return (self.theta0, self.V0 / self.l)

    @staticmethod
    def rhs(t, w, g, l, m):
        theta, omega = w
        return [omega, -g / l * math.sin(theta)]

    @invariant("J", "energy E")
    def energy(t, w, g, l, m):
        """First integral of the motion: kinetic plus potential energy, zero at the bottom."""
        theta, omega = w
        lift = 2.0 * np.sin(0.5 * theta) ** 2  # 1 - cos theta, without its cancellation
        return m * (0.5 * (l * omega) ** 2 + g * l * lift)

    @quantity("N", "cable tension R")
    def tension(t, w, g, l, m):
        """Force in the cable, m (l theta'² + g cos theta); a cable goes slack where it is zero."""
        theta, omega = w
        return m * (l * omega * omega + g * np.cos(theta))

    @event(direction=-1, terminal=True)
    def slack(t, w, g, l, m):
        """The tension, for the event that it falls to zero; the angle means nothing afterwards."""
        theta, omega = w
        return m * (l * omega * omega + g * math.cos(theta))

    @event()
    def bottom(t, w, g, l, m):
        """Zero where the pendulum passes its lowest point."""
        return math.sin(0.5 * w[0])

    @event()
    def top(t, w, g, l, m):
        """Zero where a whirling pendulum passes its highest point."""
        return math.cos(0.5 * w[0])

    @event()
    def turning(t, w, g, l, m):
        """Zero where a swinging pendulum turns back."""
        return w[1]

    def exact(self, t):
        """Exact state in all three regimes, the angle not wrapped; shape (2,) or (2, n_points)."""
        w0 = self.natural_frequency
        turns = self._turns
        motion = getattr(elliptic, self.regime)
        phase = w0 * np.asarray(t, float) + self._phase
        theta, rate = motion(phase, self.modulus, self._k_squared_beyond_one)
        sign = math.copysign(1.0, self.V0)
        return np.array([sign * theta + turns, sign * w0 * rate])

    def small_angle(self, t):
        """
        Solution for small angles, theta ~ theta0 cos(w0 t) + V0/sqrt(g l) sin(w0 t).

        Its shape is (2,) or (2, n_points).

        Notes
        -----
        For an amplitude A the true period is longer by the fraction A²/16 + ..., so the error
        grows as A³/16 w0 t until the two are out of step.
        """
        s = self.natural_frequency * np.asarray(t, float)
        peak = self.V0 / math.sqrt(self.g * self.l)
        w0 = self.natural_frequency
        angle = self.theta0 * np.cos(s) + peak * np.sin(s)
        return np.array([angle, w0 * (peak * np.cos(s) - self.theta0 * np.sin(s))])

    @derived("")
    def regime(self) -> str:
        """``'swinging'``, ``'separatrix'`` (k is 1 to within its rounding) or ``'whirling'``."""
        beyond = self._k_squared_beyond_one
        if abs(beyond) <= 4.0 * np.finfo(float).eps:
            return "separatrix"
        return "swinging" if beyond < 0.0 else "whirling"

    @derived("")
    def modulus(self) -> float:
        """k, from the bottom |V0| / (2 sqrt(g l)): below 1 the pendulum swings, above it whirls."""
        return math.hypot(self._half_rate, math.sin(0.5 * self.theta0))

    @derived("rad/s")
    def natural_frequency(self) -> float:
        """Angular frequency of small swings, w0 = sqrt(g/l)."""
        return math.sqrt(self.g / self.l)

    @derived("s")
    def period(self) -> float:
        """Time of a full swing, or of a full turn when whirling; infinite between the two."""
        if self.regime == "separatrix":
            return math.inf
        beyond = self._k_squared_beyond_one
        k = self.modulus
        w0 = self.natural_frequency
        if self.regime == "swinging":
            return 4.0 * elliptic.quarter_period(-beyond) / w0
        return 2.0 * elliptic.quarter_period(beyond / k**2) / (k * w0)

    @derived("rad")
    def largest_angle(self) -> float:
        """Angle at which a swinging pendulum turns back; infinite when whirling."""
        if self.regime == "whirling":
            return math.inf
        return 2.0 * math.atan2(self.modulus, math.sqrt(max(0.0, -self._k_squared_beyond_one)))

    @derived("rad")
    def slack_angle(self) -> float:
        """Size of the angle at which the cable goes slack; NaN if it stays taut."""
        cosine = (2.0 - 4.0 * self.modulus**2) / 3.0
        return math.acos(cosine) if -1.0 < cosine < 0.0 else math.nan

    @derived("s")
    def slack_time(self) -> float:
        """Time at which the cable first goes slack; NaN if it stays taut."""
        if self.theta0 == 0.0:
            return self.time_to(math.copysign(self.slack_angle, self.V0))
        if math.isnan(self.slack_angle):
            return math.nan
        if math.cos(self.theta0) < math.cos(self.slack_angle):
            return 0.0  # beyond the angle at which it does
        times = [self.time_to(sign * self.slack_angle + self._turns) for sign in (-1.0, 1.0)]
        return float(np.nanmin(times))

    def time_to(self, theta) -> float:
        """
        Second integral of the motion: the time at which the pendulum first gets to an angle.

        The angle is in rad; from the lowest point with the sign of V0. NaN if it is not reached.
        """
        if self.theta0 == 0.0 and theta * self.V0 < 0.0:
            return math.nan
        angle = (theta - self._turns) * math.copysign(1.0, self.V0)
        passage = elliptic.first_passage(0.5 * abs(angle), self.modulus)
        passages = [math.copysign(float(passage), angle)]
        if self.regime == "swinging":
            half = 0.5 * self.period * self.natural_frequency
            passages += [half - passages[0], passages[0] + 2.0 * half]
        later = [one - self._phase for one in passages if one >= self._phase]
        return min(later, default=math.nan) / self.natural_frequency

    def figure(self, results, **options):
        """Angle with the exact one, and tension, against time; see `System.figure`."""
        return pendulums.by_angle(results, **options)

    def scene(self, t, w):
        """The cable and the mass; see `System.scene`."""
        return pendulums.scene(self.l, self.l * np.array([math.sin(w[0]), math.cos(w[0])]))

    @property
    def _k_squared_beyond_one(self):
        """k² - 1, from the parameters in rational arithmetic: near the separatrix it is small."""
        g = Fraction(self.g)
        length = Fraction(self.l)
        V0 = Fraction(self.V0)
        return float(V0**2 / (4 * g * length) - Fraction(math.cos(0.5 * self.theta0)) ** 2)

    @property
    def _half_rate(self):
        """Half the rate of the angle at launch, in units of the natural frequency; not negative."""
        return abs(self.V0) / (2.0 * math.sqrt(self.g * self.l))

    @property
    def _turns(self):
        """The whole turns in the angle at launch, rad."""
        return 2.0 * math.pi * round(self.theta0 / (2.0 * math.pi))

    @property
    def _phase(self):
        """Phase of the motion from the lowest point at which this one begins."""
        if self.theta0 == 0.0:
            return 0.0
        half = 0.5 * (self.theta0 - self._turns) * math.copysign(1.0, self.V0)
        beyond = 0.0 if self.regime == "separatrix" else self._k_squared_beyond_one
        return elliptic.phase_at(half, self._half_rate, self.modulus, beyond)
