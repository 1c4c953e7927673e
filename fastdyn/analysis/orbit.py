"""Periodic orbits: shooting with exact sensitivities, Floquet multipliers."""

import dataclasses
import math
from typing import Any

import numpy as np

from fastdyn.plot.displayed import Displayed
from fastdyn.problem.options.docstrings import filled
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .equations import NotConvergedError, SystemEquations, equations_of, positive, state_of
from .flow import METHOD, Flow, options_of
from .period import check_period
from .shooting import return_time, shoot

ADVICE = "Give the period of the equations, or a multiple of that."
ON_CIRCLE = 1e-4  # distance from 1 of a multiplier's size that is not told from 1
PARTS = (2, 3, 5, 7)  # of a period, which may be periods themselves
POINTS = 401  # of the curve of an orbit


@dataclasses.dataclass(frozen=True, repr=False)
class PeriodicOrbit(Displayed):
    """
    A periodic orbit.

    Attributes
    ----------
    y0 : ndarray, shape (n,)
        State of the orbit at `t0`.
    period, t0 : float
    forced : bool
        Whether the equations depend on the time.
    multipliers : ndarray of complex, shape (n,)
        Floquet multipliers, by decreasing size. Of an orbit that is not forced, one is 1.
    monodromy : ndarray, shape (n, n)
        Derivative of the state after a period with respect to `y0`.
    residual : float
        Largest distance, by component, of the state after a period from `y0`, in units of the size
        of the orbit.
    stable : bool or None
        None where a multiplier other than that of the orbit's own direction is 1 in size.
    t, y : ndarray, shape (n_points,), (n, n_points)
        The orbit.
    """

    equations: SystemEquations
    y0: np.ndarray
    period: float
    t0: float
    forced: bool
    multipliers: np.ndarray
    monodromy: np.ndarray
    residual: float
    stable: bool | None
    t: np.ndarray
    y: np.ndarray
    flow: Flow

    @property
    def exponents(self):
        """Real parts of the Floquet exponents, log|multiplier| / period."""
        with np.errstate(divide="ignore"):
            return np.log(np.abs(self.multipliers)) / self.period

    @property
    def amplitude(self):
        """Half the distance between largest and smallest value of each component, shape (n,)."""
        return half_ranges(self.y)

    def others(self):
        """The multipliers without that of the orbit's own direction."""
        return other_multipliers(self.multipliers, self.forced)

    def __str__(self):
        what = {True: "stable", False: "unstable", None: "neither attracting nor repelling"}
        multipliers = ", ".join(f"{value:.6g}" for value in _short(self.multipliers))
        return (
            f"Periodic orbit, {what[self.stable]}: period {self.period:.10g}, "
            f"multipliers {multipliers}"
        )

    @filled()
    def plot(self, components=(0, 1), **options) -> Any:
        """Draw the orbit in a plane, and the multipliers beside the unit circle.

        Parameters
        ----------
        components : pair of int or name
            The two components of the state that span the plane.
        {figure}
        """
        from fastdyn.plot.analysis.orbits import figure

        return figure(self, components, **options)


@filled()
@shown_when_wrong(t0=kinds.number, period=kinds.number, transient=kinds.number, method=kinds.method)
def periodic_orbit(
    fun, y0=None, period=None, args=(), t0=0.0, transient=0.0, method=METHOD, **options
):
    """Find a periodic orbit by shooting.

    Parameters
    ----------
    fun : callable or System
        ``fun(t, y, *args)``, or a system.
    y0 : array_like, shape (n,), optional
        A state near the orbit; of a system, its initial state by default.
    period : float, optional
        Period of the equations, if they depend on the time: an orbit of this period is found, and
        for a subharmonic orbit a multiple is given. Otherwise a guess; by default the time of a
        return to the neighbourhood of the state after the transient.
    args : tuple
        Arguments of a function.
    t0 : float
        Time of `y0`.
    transient : float
        Time for which the equations are solved first, towards an attracting orbit.
    method, **options
        As in `solve_ivp`; by default DOP853, rtol = {rtol of periodic_orbit}, atol =
        {atol of periodic_orbit}.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    NotConvergedError
        If the search does not arrive at an orbit, or arrives at an equilibrium.
    ValueError
        For a function that cannot be traced or differentiated, and for equations that depend on
        the time without a period, or with one that they do not have.

    Notes
    -----
    Shooting with the exact monodromy matrix, as in Seydel, Practical Bifurcation and Stability
    Analysis, section 7.5, by Levenberg and Marquardt's method (SciPy's `root`). Each pass solves
    n (n + 2) equations once. Among the orbits of a family, as in conservative systems, a nearby one
    is found.

    Examples
    --------
    >>> def van_der_pol(t, y, mu):
    ...     return [y[1], mu * (1 - y[0] ** 2) * y[1] - y[0]]
    >>> periodic_orbit(van_der_pol, [2, 0], 6.3, args=(1.0,)).period  # 6.6632868593
    """
    equations = equations_of(fun, args)
    y0 = state_of(equations, y0)
    t0 = float(t0)
    flow = Flow(equations, options_of(periodic_orbit, method, options))
    forced = not equations.differentiated(t0, y0).autonomous
    if forced and period is None:
        raise ValueError(
            "`period` is missing: `fun` depends on the time, and the period of that is needed."
        )
    period = None if period is None else positive(period, "period")
    if forced:
        check_period(equations, t0, y0, period, ADVICE)
    if transient:
        wait = positive(transient, "transient")
        if forced and period is not None:
            wait = period * math.ceil(wait / period)
        y0 = flow.curve(y0, t0, wait, 2)[1][:, -1]
    if period is None:
        period = return_time(flow, y0, t0)
    return _least(flow, found_orbit(flow, y0, period, t0, forced))


def found_orbit(flow, y0, period, t0, forced):
    """The PeriodicOrbit that shooting finds from a guess."""
    y, T, passage = shoot(flow, y0, period, t0, forced)
    return orbit_at(flow, y, T, t0, forced, passage)


def orbit_at(flow, y, T, t0, forced, passage):
    """The PeriodicOrbit through a state."""
    t, curve = flow.curve(y, t0, T, POINTS)
    size = np.ptp(curve, axis=1).max()
    if not forced and size <= 1e-6 * max(1.0, np.abs(y).max()):
        raise NotConvergedError(
            f"The search arrived at an equilibrium, {y}, not at an orbit: start farther from it."
        )
    residual = float(np.abs(passage.y - y).max() / max(size, np.abs(y).max(), 1e-300))
    values = np.linalg.eigvals(passage.by_start).astype(complex)
    values = values[np.lexsort((-values.imag, -np.abs(values)))]
    sizes = np.abs(other_multipliers(values, forced))
    stable = None
    if (sizes > 1.0 + ON_CIRCLE).any():
        stable = False
    elif (sizes < 1.0 - ON_CIRCLE).all():
        stable = True
    return PeriodicOrbit(
        flow.equations, y, T, t0, forced, values, passage.by_start, residual, stable, t, curve, flow
    )


def half_ranges(curve):
    """Half the range of each row of a periodic curve, between its points by parabolas."""
    ends = []
    for sign in (1.0, -1.0):
        values = sign * curve[:, :-1]
        rows = np.arange(len(values))
        at = values.argmax(axis=1)
        before, top, after = (values[rows, (at + k) % values.shape[1]] for k in (-1, 0, 1))
        bend = before - 2.0 * top + after
        with np.errstate(divide="ignore", invalid="ignore"):
            ends.append(top - np.where(bend < 0.0, (before - after) ** 2 / (8.0 * bend), 0.0))
    return 0.5 * (ends[0] + ends[1])


def other_multipliers(values, forced):
    """Multipliers without the one next to 1, which belongs to an orbit's own direction."""
    return values if forced else np.delete(values, np.argmin(np.abs(values - 1.0)))


def _least(flow, orbit):
    """The orbit with its least period, if the one that was found is a multiple of that."""
    if orbit.forced:
        return orbit
    size = np.ptp(orbit.y, axis=1).max()
    for part in PARTS:
        share = flow.passage(orbit.y0, orbit.t0, orbit.period / part)
        if np.abs(share.y - orbit.y0).max() < 1e-6 * size:
            return _least(flow, found_orbit(flow, orbit.y0, orbit.period / part, orbit.t0, False))
    return orbit


def _short(values):
    """Complex numbers, real where they are."""
    return [
        value.real if abs(value.imag) < 1e-12 * max(1.0, abs(value)) else value for value in values
    ]
