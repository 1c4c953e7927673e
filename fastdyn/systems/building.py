"""Two-storey building in an earthquake (course 3.3.3, example 3)."""

import dataclasses
import math
from typing import Any

import numpy as np

from fastdyn.plot import shaking
from fastdyn.words.calls import shown_when_wrong

from .base import State, System, derived, parameter, quantity
from .formulas import ground_motion
from .formulas.forced_response import forced_mode

STIFFNESS = np.array([[4.0, -2.0], [-2.0, 2.0]])
"""Stiffness of the two floors in units of k: walls of 2k to the ground and between the floors."""


@dataclasses.dataclass(frozen=True, eq=False)
class Building(System):
    """
    Two floors on springy walls over ground that moves up and down.

    Equations of motion, with s the height of the ground, d sin(omega t) unless samples are given,
    and two walls in a storey::

        m y1'' = -2k (y1 - s - L) + 2k (y2 - y1 - L) - m g
        m y2'' = -2k (y2 - y1 - L) - m g

    State ``[y1, y2, v1, v2]``, heights of the floors in m and their rates in m/s; from rest in
    static equilibrium, y1 = L - mg/k and y2 = 2L - 3mg/(2k). Defaults and t = 20 s are those of
    the course's script.

    Parameters
    ----------
    times : array_like, shape (n_samples,), optional
        Times of samples of the ground's motion, s, instead of the sine; see `sampled`.
    pieces : array_like, shape (n_samples - 1, 4), optional
        The motion between the samples, coefficients of 1, s, s², s³ with s the time since a sample.

    Notes
    -----
    Exact, for the sine: the two modes are independent oscillators. Their frequencies are
    sqrt(3 -+ sqrt 5) sqrt(k/m), 8.740 and 22.882 rad/s.

    **Erratum.** The script as printed leaves -g out of the lower floor's equation. Its building
    is not in equilibrium at the start and moves without any earthquake (d = 0); this one does
    not. Its last line lacks the semicolon that keeps MATLAB from printing at each evaluation.
    """

    name = "building"
    title = "Two-storey building in an earthquake"
    source = "course 3.3.3, example 3"
    states = (
        State("y1", "m", "height of the lower floor"),
        State("y2", "m", "height of the upper floor"),
        State("v1", "m/s", "velocity of the lower floor"),
        State("v2", "m/s", "velocity of the upper floor"),
    )
    t_end = 20.0

    k: float = parameter(100.0, "N/m", "stiffness of each wall", positive=True)
    m: float = parameter(1.0, "kg", "mass of each floor", positive=True)
    omega: float = parameter(9.0, "rad/s", "angular frequency of the ground", positive=True)
    d: float = parameter(0.1, "m", "amplitude of the ground")
    L: float = parameter(10.0, "m", "length of the walls without load", positive=True)
    g: float = parameter(9.81, "m/s²", "acceleration of gravity", positive=True)
    times: Any = None
    pieces: Any = None

    def __post_init__(self):
        super().__post_init__()
        if (self.times is None) != (self.pieces is None):
            raise ValueError("`times` and `pieces` go together; `Building.sampled` makes both.")
        if self.times is not None:
            times, pieces = ground_motion.checked(self.times, self.pieces)
            object.__setattr__(self, "times", times)
            object.__setattr__(self, "pieces", pieces)

    def _key(self):
        sampled = self.times is not None
        samples = (self.times.tobytes(), self.pieces.tobytes()) if sampled else ()
        return (*self.args[:6], *samples)

    def __eq__(self, other):
        return isinstance(other, Building) and self._key() == other._key()

    def __hash__(self):
        return hash(self._key())

    @classmethod
    @shown_when_wrong()
    def sampled(cls, times, *, displacements=None, accelerations=None, **parameters):
        """
        Building over ground whose motion is given by samples, joined by straight lines.

        Parameters
        ----------
        times : array_like, shape (n_samples,)
            Times of the samples, s, increasing. Before the first and after the last sample the
            ground stays at the displacement there.
        displacements : array_like, shape (n_samples,), optional
            Height of the ground, m.
        accelerations : array_like, shape (n_samples,), optional
            Its acceleration instead, m/s², integrated twice, exactly, from rest at height 0.
        **parameters
            Those of the building.
        """
        pieces = ground_motion.pieces(times, displacements, accelerations)
        return cls(times=times, pieces=pieces, **parameters)

    def initial_state(self):
        """Static equilibrium, at rest."""
        sag = self.m * self.g / self.k
        return (self.L - sag, 2.0 * self.L - 1.5 * sag, 0.0, 0.0)

    @staticmethod
    def rhs(t, w, k, m, omega, d, L, g, times, pieces):
        y1, y2, v1, v2 = w
        if times is not None:  # settled when compiled
            s = ground_motion.height(t, times, pieces)
        else:
            s = d * math.sin(omega * t)
        lower = 2.0 * k * (y1 - s - L)
        upper = 2.0 * k * (y2 - y1 - L)
        return [v1, v2, (upper - lower) / m - g, -upper / m - g]

    @property
    def breakpoints(self):
        """Times of the samples, where the ground has kinks and steps must end; None for a sine."""
        return self.times

    def ground(self, t):
        """Height of the ground at times t, m."""
        if self.times is not None:
            t = np.asarray(t, float)
            return np.vectorize(lambda x: ground_motion.height(x, self.times, self.pieces))(t)
        return self.d * np.sin(self.omega * np.asarray(t, float))

    def ground_acceleration(self, t):
        """Acceleration of the ground at times t, m/s²; at a sample that of the piece after it."""
        t = np.asarray(t, float)
        if self.times is None:
            return -self.d * self.omega**2 * np.sin(self.omega * t)
        piece = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.pieces) - 1)
        _, _, square, cube = self.pieces[piece].T
        inside = (t >= self.times[0]) & (t <= self.times[-1])
        return np.where(inside, 2.0 * square + 6.0 * cube * (t - self.times[piece]), 0.0)

    @quantity("J", "energy E")
    def energy(t, w, k, m, omega, d, L, g, times, pieces):
        """Kinetic energy, energy of walls and weight, over ground at rest; 0 in equilibrium."""
        y1, y2, v1, v2 = w
        u1 = y1 - L + m * g / k
        u2 = y2 - 2.0 * L + 1.5 * m * g / k
        return 0.5 * m * (v1 * v1 + v2 * v2) + k * (u1 * u1 + (u2 - u1) ** 2)

    @quantity("m", "deflection of the upper floor")
    def deflection(t, w, k, m, omega, d, L, g, times, pieces):
        """Height of the upper floor above its equilibrium over ground at rest."""
        return w[1] - 2.0 * L + 1.5 * m * g / k

    def exact(self, t):
        """Exact state over ground that moves as a sine, as `System.exact`."""
        if self.times is not None:
            raise ValueError("No exact solution of the building over sampled ground is known.")
        t = np.asarray(t, float)
        _, modes = np.linalg.eigh(STIFFNESS)  # of the same order as `frequencies`
        push = modes.T @ np.array([2.0 * self.k * self.d / self.m, 0.0])
        each = [
            forced_mode(t, w, f, self.omega) for w, f in zip(self.frequencies, push, strict=True)
        ]
        u, v = (np.tensordot(modes, np.array(part), 1) for part in zip(*each, strict=True))
        rest = np.array(self.initial_state()[:2]).reshape(2, *[1] * t.ndim)
        return np.concatenate([rest + u, v])

    @property
    def steady_amplitudes(self) -> np.ndarray:
        """Amplitudes of both floors under the sine alone, without the free vibration, m."""
        push = np.array([2.0 * self.k * self.d / self.m, 0.0])
        return np.linalg.solve(STIFFNESS * self.k / self.m - self.omega**2 * np.eye(2), push)

    @property
    def frequencies(self) -> tuple[float, float]:
        """Angular frequencies of the two modes, rad/s."""
        unit = math.sqrt(self.k / self.m)
        return unit * math.sqrt(3.0 - math.sqrt(5.0)), unit * math.sqrt(3.0 + math.sqrt(5.0))

    @derived("rad/s")
    def lower_frequency(self) -> float:
        """Angular frequency at which the floors swing together."""
        return self.frequencies[0]

    @derived("rad/s")
    def upper_frequency(self) -> float:
        """Angular frequency at which they swing against each other."""
        return self.frequencies[1]

    @derived("s")
    def lower_period(self) -> float:
        """Period of the lower mode."""
        return 2.0 * math.pi / self.frequencies[0]

    @derived("s")
    def upper_period(self) -> float:
        """Period of the upper mode."""
        return 2.0 * math.pi / self.frequencies[1]

    def figure(self, results, **options):
        """Movement of both floors and of the ground, a panel for each result."""
        return shaking.figure(results, **options)

    def scene(self, t, w):
        """Ground, floors and walls; see `System.scene`."""
        return shaking.scene(float(self.ground(t)), w, 0.25 * self.L)
