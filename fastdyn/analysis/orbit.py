"""Periodic orbits: shooting with exact sensitivities, Floquet multipliers."""

import dataclasses
import math
from typing import Any

import numpy as np

from fastdyn.solve.ivp import solve_ivp

from .equations import Equations, NotConvergedError, count, equations_of, positive, state_of
from .flow import METHOD, Flow, options_of

ROUNDINGS = 100.0  # residual of an orbit, in units of the tolerance of the solves
MOST_PASSES, HALVINGS = 40, 6
ON_CIRCLE = 1e-4  # distance from 1 of a multiplier's size that is not told from 1
PARTS = (2, 3, 5, 7)  # of a period, which may be periods themselves
POINTS = 401  # of the curve of an orbit


@dataclasses.dataclass(frozen=True)
class PeriodicOrbit:
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

    equations: Equations
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
        return 0.5 * np.ptp(self.y, axis=1)

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

    def plot(self, components=(0, 1), **options) -> Any:
        """The orbit in the plane of two components, and its multipliers beside the unit circle."""
        from fastdyn.plot.analysis.orbits import figure

        return figure(self, components, **options)


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
        As in `solve_ivp`; by default DOP853, rtol = 1e-10, atol = 1e-12.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    NotConvergedError
        If Newton's method does not arrive at an orbit, or arrives at an equilibrium.
    ValueError
        For a function that cannot be traced or differentiated, and without a period for equations
        that depend on the time.

    Notes
    -----
    Newton's method with the exact monodromy matrix, as in Seydel, Practical Bifurcation and
    Stability Analysis, section 7.5. Each pass solves n (n + 2) equations once. Among the orbits of
    a family, as in conservative systems, a nearby one is found.

    Examples
    --------
    >>> def van_der_pol(t, y, mu):
    ...     return [y[1], mu * (1 - y[0] ** 2) * y[1] - y[0]]
    >>> periodic_orbit(van_der_pol, [2, 0], 6.3, args=(1.0,)).period  # 6.6632868593
    """
    equations = equations_of(fun, args)
    y0, t0 = state_of(equations, y0), float(t0)
    flow = Flow(equations, options_of(method, options))
    forced = not equations.differentiated(t0, y0).autonomous
    if forced and period is None:
        raise ValueError(
            "`period` is missing: `fun` depends on the time, and the period of that is needed."
        )
    period = None if period is None else positive(period, "period")
    if transient:
        wait = positive(transient, "transient")
        if forced:
            wait = period * math.ceil(wait / period)
        y0 = flow.curve(y0, t0, wait, 2)[1][:, -1]
    if period is None:
        period = _return_time(flow, y0, t0)
    return _least(flow, shoot(flow, y0, period, t0, forced))


def shoot(flow, y0, period, t0, forced):
    """The PeriodicOrbit that Newton's method finds from a guess."""
    y, T = np.array(y0, float), float(period)
    direction = flow.equations.rates(t0, y)
    if not forced and not np.abs(direction).max() > 0.0:
        raise NotConvergedError("The search begins at an equilibrium: start beside it.")
    near = flow.options["rtol"] * ROUNDINGS
    passage = flow.passage(y, t0, T)
    for _ in range(MOST_PASSES):
        off, size = passage.y - y, _size(y, passage.y)
        if np.abs(off / size).max() <= near:
            break
        step = newton_step(passage, off, None if forced else direction)
        y, T, passage = _damped(flow, y, T, t0, passage, step)
        direction = flow.equations.rates(t0, y)
    else:
        raise _lost(off, size, T)
    step = newton_step(passage, passage.y - y, None if forced else direction)
    last = _tried(flow, y + step[:-1], T + step[-1], t0)  # once more: quadratic convergence
    if last is not None and np.abs(last.y - y - step[:-1]).max() <= np.abs(off).max():
        y, T, passage = y + step[:-1], T + step[-1], last
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


def other_multipliers(values, forced):
    """Multipliers without the one next to 1, which belongs to an orbit's own direction."""
    return values if forced else np.delete(values, np.argmin(np.abs(values - 1.0)))


def newton_step(passage, off, direction):
    """The change of state and period, shape (n + 1,); `direction` is None for a given period."""
    n = len(off)
    matrix = np.zeros((n + 1, n + 1))
    matrix[:n, :n] = passage.by_start - np.eye(n)
    if direction is None:
        matrix[n, n] = 1.0
    else:
        matrix[:n, n] = passage.by_length
        matrix[n, :n] = direction / np.abs(direction).max()
    return np.linalg.lstsq(matrix, np.append(-off, 0.0), rcond=1e-10)[0]


def _damped(flow, y, T, t0, passage, step):
    """A step of Newton's method, halved while it leads away from an orbit."""
    before = np.linalg.norm((passage.y - y) / _size(y, passage.y))
    share = min(1.0, 0.3 * T / max(abs(step[-1]), 1e-300))
    for _ in range(HALVINGS):
        new = y + share * step[:-1]
        found = _tried(flow, new, T + share * step[-1], t0)
        if found is not None:
            after = np.linalg.norm((found.y - new) / _size(new, found.y))
            if after < before:
                return new, T + share * step[-1], found
        share /= 2.0
    raise _lost(passage.y - y, _size(y, passage.y), T)


def _tried(flow, y, T, t0):
    """The passage, or None if the solve fails."""
    try:
        return flow.passage(y, t0, T)
    except NotConvergedError:
        return None


def _size(*states):
    """The size by which residuals are measured: that of the largest component, at least 1e-3."""
    return max(1e-3, *(np.abs(state).max() for state in states))


def _lost(off, size, period):
    return NotConvergedError(
        f"No periodic orbit was found: with a period of {period:.6g} the state after a period is "
        f"off by {np.abs(off / size).max():.2g} of its size, and Newton's method comes no nearer. "
        "Give a state or a period nearer to the orbit, or a `transient` towards it."
    )


def _least(flow, orbit):
    """The orbit with its least period, if the one that was found is a multiple of that."""
    if orbit.forced:
        return orbit
    size = np.ptp(orbit.y, axis=1).max()
    for part in PARTS:
        share = flow.passage(orbit.y0, orbit.t0, orbit.period / part)
        if np.abs(share.y - orbit.y0).max() < 1e-6 * size:
            return _least(flow, shoot(flow, orbit.y0, orbit.period / part, orbit.t0, False))
    return orbit


def _return_time(flow, y0, t0):
    """The time after which the solution crosses the plane across its direction at y0 again."""
    e = flow.equations
    direction = e.rates(t0, y0)
    speed = np.linalg.norm(direction)
    if not speed > 0.0:
        raise NotConvergedError("The search begins at an equilibrium: start beside it.")

    def plane(t, y, *args):
        total = 0.0
        for i in range(len(y0)):
            total = total + direction[i] * (y[i] - y0[i])
        return total

    plane.direction, plane.terminal = 1.0, 3
    result = solve_ivp(
        e.fun, (t0, math.inf), y0, args=e.args, events=plane, t_eval=[], max_steps=100_000,
        **flow.options,
    )  # fmt: skip
    times = result.t_events[0][result.t_events[0] > t0]
    if not len(times):
        raise NotConvergedError(
            "`period` is missing, and the solution does not return to where it begins within "
            "100 000 steps: give a guess of the period, or a `transient` towards the orbit."
        )
    distances = np.linalg.norm(result.y_events[0][-len(times) :] - y0, axis=1)
    return float(times[np.argmin(distances)] - t0)


def _short(values):
    """Complex numbers, real where they are."""
    return [value.real if abs(value.imag) < 1e-12 * max(1.0, abs(value)) else value for value in values]
