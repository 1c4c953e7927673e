"""Branches of periodic orbits over a parameter: continuation by pseudo-arclength."""

import dataclasses
from typing import Any

import numpy as np

from .equations import NotConvergedError, count, positive
from .orbit import PeriodicOrbit
from .path import Path, Special

FAST = 3  # passes of Newton's method after which the step becomes longer
LONGER, SHORTER, SHORTEST = 1.6, 0.5, 1e-6  # factors of the step; its least share of the first
SMALL = 0.02  # amplitude near an equilibrium, as a share of that of the first orbit
STEP = 0.02  # first step, as a share of the range of the parameter


@dataclasses.dataclass(frozen=True)
class Branch:
    """
    Periodic orbits along a branch.

    Attributes
    ----------
    parameter : str
        Name of the parameter.
    values : ndarray, shape (n_orbits,)
        The values of the parameter, which turn back at folds.
    orbits : list of PeriodicOrbit
    special : list of Special
        Folds, period doublings, branch points, and bifurcations of a torus, in their order.
    message : str
        The reason why the branch ends.
    """

    parameter: str
    unit: str
    values: np.ndarray
    orbits: list[PeriodicOrbit]
    special: list[Special]
    message: str

    @property
    def periods(self):
        """Periods, shape (n_orbits,)."""
        return np.array([orbit.period for orbit in self.orbits])

    @property
    def amplitudes(self):
        """Half the range of each component, shape (n, n_orbits)."""
        return np.array([orbit.amplitude for orbit in self.orbits]).T

    @property
    def stable(self):
        """Which orbits are stable, shape (n_orbits,)."""
        return np.array([orbit.stable is True for orbit in self.orbits])

    def __str__(self):
        head = f"Branch of {len(self.orbits)} orbits over {self.parameter}. {self.message}"
        return "\n".join([head, *(f"  {s.kind} at {s.value:.8g}" for s in self.special)])

    def plot(self, component=0, **options) -> Any:
        """Draw the amplitude of a component, and the period, over the parameter.

        Parameters
        ----------
        component : int or name
            The component of the state.
        **options
            Options of ``matplotlib.pyplot.figure``.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from fastdyn.plot.analysis.orbits import branch

        return branch(self, component, **options)


def continuation(orbit, parameter, end, period=None, step=None, n_orbits=200, largest=2.5):
    """Follow a periodic orbit over a parameter, around folds.

    Parameters
    ----------
    orbit : PeriodicOrbit
        A result of `periodic_orbit`, the start of the branch.
    parameter : str or int
        Name of the parameter, or its position among the arguments.
    end : float
        Value towards which the branch is followed. The branch ends at this value, or when the
        parameter returns to its value at the start.
    period : callable, optional
        For equations that depend on the time: the period as a function of the parameter, such as
        ``lambda omega: 2 * math.pi / omega``; by default constant.
    step : float, optional
        First step along the branch, in units of the range of the parameter; 0.02 by default.
    n_orbits : int
        The most orbits.
    largest : float
        The longest step, in units of the first step.

    Returns
    -------
    Branch
        `message` gives the reason for the end of the branch, also for an early end.

    Raises
    ------
    ValueError, TypeError
        For an unknown parameter, a parameter that is no number, and an `end` at its present value.

    Notes
    -----
    Pseudo-arclength continuation with exact derivatives with respect to state, period and
    parameter (Keller 1977; Seydel, section 4.5). At a special point, one of four test functions
    changes: the direction of the parameter (fold), the product of all (multiplier + 1) (period
    doubling), the product of all (multiplier - 1) (branch point), the number of complex multipliers
    outside the unit circle (torus). Halving the step between two orbits locates the special point
    to the accuracy of the orbits.

    Examples
    --------
    >>> orbit = periodic_orbit(duffing, [0.2, 0], 2 * math.pi / 0.8, (0.8,), transient=200)
    >>> branch = continuation(orbit, "omega", 2.0, lambda omega: 2 * math.pi / omega)
    """
    path = Path.of(orbit, parameter, end, period)
    count(n_orbits, "n_orbits")
    length = first = STEP if step is None else positive(step, "step")
    here = path.begin()
    points, special, message = [here], [], f"It has {n_orbits} orbits, the most."
    while len(points) < n_orbits:
        try:
            there, passes = path.next(here, length)
        except NotConvergedError as reason:
            length *= SHORTER
            if length < SHORTEST * first:
                message = f"It is lost at {path.value(here):.6g}. {reason}"
                break
            continue
        special += path.between(here, there, length)
        points.append(there)
        here, value = there, path.value(there)
        if passes <= FAST:
            length = min(length * LONGER, largest * first)
        if (value - path.end) * path.sign >= 0.0:
            points[-1] = path.at_value(points[-2], there, path.end)
            message = f"It reaches {end:g}."
            break
        if (value - path.start) * path.sign < 0.0:
            message = f"It comes back to {path.start:g}."
            break
        if not orbit.forced and there.orbit.amplitude.max() < SMALL * orbit.amplitude.max():
            message = f"It shrinks to an equilibrium at {value:.4g}."
            break
    label = orbit.equations.parameter_label(path.j)
    values = np.array([path.value(point) for point in points])
    special = [s for s in special if (s.value - path.end) * path.sign <= 0.0]
    return Branch(label.name, label.unit, values, [p.orbit for p in points], special, message)
