"""Planets: masses, places and velocities, and their motion by the method WisdomHolman."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from . import equations
from .checks import refuse_if_not_planetary

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import Path, Times, TimeSpan
    from fastdyn.run.result import OdeResult


class Planets:
    """
    Point masses that attract each other: a dominant one, and small ones in orbit around it.

    Parameters
    ----------
    masses : array_like, shape (n,)
        The dominant mass first; none is negative.
    q0, v0 : array_like, shape (n, 3)
        Places and velocities in an inertial frame, at rest with the centre of mass or not.
    G : float
        The constant of gravitation in the same units, 1 by default.  For solar masses, au and days
        it is 2.959122e-4, for solar masses, au and years 4 pi^2.

    Attributes
    ----------
    masses, q0, v0 : ndarray
    G : float
    period : float
        The shortest period of an orbit around the first mass; ValueError if there is no ellipse.
    rhs : callable
        ``rhs(t, y, G, *masses)``, the rates of y = [q_0, ..., v_0, ...], for `solve_ivp` with any
        method: ``solve_ivp(p.rhs, t_span, p.initial_state(), "Taylor", args=p.args)``.
    args : tuple
    invariants : dict of str to callable
        "energy" and "angular momentum", for `energy_drift`.

    Raises
    ------
    ValueError, TypeError
        For wrong shapes, values that are not finite, and two bodies in one place.
    """

    rhs = staticmethod(equations.rhs)

    def __init__(self, masses: Any, q0: Any, v0: Any, G: float = 1.0):
        kinds.number("G", G)
        self.G = float(np.asarray(G, float).item())
        self.masses = _array("masses", masses, 1)
        n = len(self.masses)
        if n < 2:
            raise ValueError(f"`masses` must be of two bodies or more; got {n}.")
        self.q0, self.v0 = _array("q0", q0, 2), _array("v0", v0, 2)
        for name, value in (("q0", self.q0), ("v0", self.v0)):
            if value.shape != (n, 3):
                raise ValueError(
                    f"`{name}` must have a row of three numbers for each of the {n} masses, shape "
                    f"({n}, 3); got shape {value.shape}."
                )
        if not 0.0 < self.G < math.inf:
            raise ValueError(f"`G` must be a positive number; got {self.G}.")
        if not (self.masses >= 0.0).all() or self.masses[0] == 0.0:
            raise ValueError("`masses` must not be negative, and the first must be positive.")
        if len(np.unique(self.q0, axis=0)) < n:
            raise ValueError("`q0`: two bodies are in one place.")

    def __repr__(self):
        return f"<Planets: {len(self.masses)} bodies, G = {self.G:g}>"

    @property
    def args(self) -> tuple:
        """The arguments of `rhs` and of the invariants behind the state: G and the masses."""
        return (self.G, *map(float, self.masses))

    @property
    def invariants(self) -> dict:
        """Functions of ``(t, y, G, *masses)`` that the exact motion keeps constant, by name."""
        return {
            "energy": equations.energy,
            "angular momentum": equations.angular_momentum,
        }

    @property
    def period(self) -> float:
        """The shortest period of an orbit around the first mass."""
        _, axes = self.orbits()
        periods = [
            2.0 * math.pi * math.sqrt(a**3 / (self.G * (self.masses[0] + m)))
            for a, m in zip(axes, self.masses[1:], strict=True)
            if 0.0 < a < math.inf
        ]
        if not periods:
            raise ValueError("no orbit around the first mass is an ellipse: there is no period.")
        return min(periods)

    def orbits(self) -> tuple:
        """Distances from the first mass, and semi-major axes; negative ones of hyperbolas."""
        q = self.q0[1:] - self.q0[0]
        v = self.v0[1:] - self.v0[0]
        r = np.linalg.norm(q, axis=1)
        mu = self.G * (self.masses[0] + self.masses[1:])
        with np.errstate(divide="ignore"):
            return r, 1.0 / (2.0 / r - (v * v).sum(1) / mu)

    def initial_state(self) -> np.ndarray:
        """The state y = [q_0, ..., v_0, ...], shape (6 n,)."""
        return np.r_[self.q0.ravel(), self.v0.ravel()]

    def exact(self, t: Any) -> np.ndarray:
        """Raise ValueError: only two bodies have a formula."""
        raise ValueError("the motion of planets has no formula.")

    @shown_when_wrong()
    def solve(
        self,
        t_span: TimeSpan,
        *,
        step: float,
        t_eval: Times | None = None,
        corrector: int = 17,
        checkpoint: Path | None = None,
        progress: bool = False,
    ) -> OdeResult:
        """
        Follow the motion by the splitting of Wisdom and Holman, at constant step.

        Parameters
        ----------
        t_span : 2-tuple of float
            Start and end; the end may lie before the start.
        step : float
            Size of the steps; a twentieth of the shortest period for pictures, less for accuracy.
        t_eval : array_like, optional
            Times of output, by default start and end.  An output takes as long as up to a hundred
            steps, between steps as at a step.
        corrector : int
            Order of the symplectic corrector: 3, 5, 7, 11 or 17; 0 is the method of Wisdom and
            Holman (1991), without a corrector.
        checkpoint : str or path, optional
            A file, written every few seconds, from which the same call goes on after a stop, bit
            for bit.
        progress : bool
            Show a progress bar.

        Returns
        -------
        OdeResult
            `y` has shape (6 n, n_points): the places of all bodies, then their velocities.  `nfev`
            counts the evaluations of the perturbations in the steps.  If two planets come within
            three mutual Hill radii, at a step or between two, the result ends before this step,
            with `status` -1 and a message that names the time.

        Raises
        ------
        ValueError, TypeError
            For wrong arguments, and if the first mass does not dominate the motion: for three
            bodies or more, a perturbation must not exceed a tenth of the attraction.
        OSError
            Before the run, if the checkpoint cannot be written.

        Warns
        -----
        RuntimeWarning
            If the steps are too long for the motion near the first mass.
        """
        from .run import solve

        return solve(self, t_span, step, t_eval, corrector, checkpoint, progress)

    def arranged(self) -> np.ndarray:
        """The bodies from the first mass to the outside; ValueError unless that mass dominates."""
        r, axes = self.orbits()
        outside = np.argsort(np.where(axes > 0.0, axes, np.inf) + 0.0 * r, kind="stable")
        order = np.r_[0, 1 + outside]
        refuse_if_not_planetary(self, order)
        return order


def _array(name, value, ndim):
    """An array of finite numbers of a copy of `value`."""
    kinds.numbers(name, value)
    found = np.array(value, float)
    if found.ndim != ndim:
        wanted = "a row of numbers" if ndim == 1 else "rows of three numbers, shape (n, 3)"
        raise ValueError(f"`{name}` must be {wanted}; got shape {found.shape}.")
    if not np.isfinite(found).all():
        raise ValueError(f"`{name}` must be finite.")
    found.setflags(write=False)
    return found
