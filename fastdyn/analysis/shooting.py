"""Shooting: the search for a state that a period takes back to itself."""

import numpy as np
from scipy.optimize import root

from fastdyn.solve.ivp import solve_ivp

from .equations import NotConvergedError

ROUNDINGS = 100.0  # residual of an orbit, in units of the tolerance of the solves
SHORTEST = 0.02  # period of an orbit, as a share of the guess: at 0 all states are periodic
FAR = 1e6  # residual where a solve fails
SEARCH = {"xtol": 1e-14, "ftol": 1e-14, "factor": 0.1}  # a first step of a tenth of the state
MANY = 1e9  # passages of a state
RETURN = 20_000  # steps in which a solution comes back


class Plane:
    """The event that a solution crosses the plane through a state, across a direction."""

    direction = 1.0
    terminal = 3

    def __init__(self, through, across):
        self.through = through
        self.across = across

    def __call__(self, t, y, *args):
        total = 0.0
        for i in range(len(self.through)):
            total = total + self.across[i] * (y[i] - self.through[i])
        return total


def shoot(flow, y0, period, t0, forced):
    """(state, period, Passage) of a periodic orbit, found from a guess.

    The unknowns are the state and, unless `forced`, the logarithm of the period; the state stays in
    the plane through `y0` across the flow.
    """
    n, size = len(y0), _size(y0)
    across = flow.equations.rates(t0, y0)
    if not forced and not np.abs(across).max() > 0.0:
        raise NotConvergedError("The search begins at an equilibrium: start beside it.")
    across = across / max(np.abs(across).max(), 1e-300)

    def residuals(u):
        y = u[:n]
        T = period if forced else period * np.exp(u[n])
        passage = flow.passage(y, t0, T)
        off = passage.y - y
        matrix = passage.by_start - np.eye(n)
        if not forced:
            off = np.append(off, across @ (y - y0))
            matrix = np.block([[matrix, T * passage.by_length[:, None]], [across, np.zeros(1)]])
        return off / size, matrix / size

    u = np.array(y0, float) if forced else np.append(y0, 0.0)
    u = _least_squares(residuals, u)
    T = period if forced else period * np.exp(u[n])
    passage = flow.passage(u[:n], t0, T)
    off = np.abs(passage.y - u[:n]).max() / _size(u[:n], passage.y)
    if not off <= ROUNDINGS * flow.options["rtol"] or not T > SHORTEST * period:
        raise NotConvergedError(
            f"No periodic orbit was found: with a period of {T:.6g} the state after a period is "
            f"off by {off:.2g} of its size, and the search comes no nearer. Give a state or a "
            "period nearer to the orbit, or a `transient` towards it."
        )
    return u[:n], T, passage


def _least_squares(residuals, u):
    """Levenberg and Marquardt's method; where a solve fails, the step is too long."""
    last = residuals(u)

    def guarded(u):
        nonlocal last
        try:
            last = residuals(u)
        except NotConvergedError:
            return np.full(len(u), FAR), last[1]
        return last

    with np.errstate(all="ignore"):
        return root(guarded, u, jac=True, method="lm", options=SEARCH).x


def _size(*states):
    """The size by which residuals are measured: that of the largest component, at least 1e-3."""
    return max(1e-3, *(np.abs(state).max() for state in states))


def longest(equations, t0, y0):
    """A time after which nothing is awaited any more: many times that of a passage of the state.

    It is finite, as the steps of motions that only drift away grow and grow.
    """
    speed = np.abs(equations.rates(t0, y0)).max()
    return MANY * max(1.0, min(_size(y0) / speed, MANY)) if speed > 0.0 else MANY


def return_time(flow, y0, t0):
    """The time after which the solution crosses the plane across its direction at y0 again."""
    e = flow.equations
    direction = e.rates(t0, y0)
    if not np.linalg.norm(direction) > 0.0:
        raise NotConvergedError("The search begins at an equilibrium: start beside it.")
    span = longest(e, t0, y0)
    result = solve_ivp(
        e.fun, (t0, t0 + span), y0, args=e.args, events=Plane(y0, direction), t_eval=[],
        **{**flow.options, "max_steps": RETURN},
    )  # fmt: skip
    times = result.t_events[0][result.t_events[0] > t0]
    if not len(times):
        raise NotConvergedError(
            "`period` is missing, and the solution does not return to where it begins within "
            f"{RETURN} steps, or a time of {span:.3g}: give a guess of the "
            "period, or a `transient` towards the orbit."
        )
    distances = np.linalg.norm(result.y_events[0][-len(times) :] - y0, axis=1)
    return float(times[np.argmin(distances)] - t0)
