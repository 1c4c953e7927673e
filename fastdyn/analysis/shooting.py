"""Shooting: Newton's method for a state that a period takes back to itself."""

import math

import numpy as np

from fastdyn.solve.ivp import solve_ivp

from .equations import NotConvergedError

ROUNDINGS = 100.0  # residual of an orbit, in units of the tolerance of the solves
MOST_PASSES, HALVINGS = 40, 6
LARGEST = 0.3  # change of the period in one step, as a share of it
RETURN = 20_000  # steps in which a solution comes back


class Plane:
    """The event that a solution crosses the plane through a state, across a direction."""

    direction, terminal = 1.0, 3

    def __init__(self, through, across):
        self.through, self.across = through, across

    def __call__(self, t, y, *args):
        total = 0.0
        for i in range(len(self.through)):
            total = total + self.across[i] * (y[i] - self.through[i])
        return total


def shoot(flow, y0, period, t0, forced):
    """(state, period, Passage) of the periodic orbit that Newton's method finds from a guess."""
    y, T = np.array(y0, float), float(period)
    direction = flow.equations.rates(t0, y)
    if not forced and not np.abs(direction).max() > 0.0:
        raise NotConvergedError("The search begins at an equilibrium: start beside it.")
    near = flow.options["rtol"] * ROUNDINGS
    passage = flow.passage(y, t0, T)
    for _ in range(MOST_PASSES):
        if np.abs(passage.y - y).max() <= near * _size(y, passage.y):
            break
        step = newton_step(passage, passage.y - y, None if forced else direction)
        y, T, passage = _damped(flow, y, T, t0, passage, step)
        direction = flow.equations.rates(t0, y)
    else:
        raise _lost(passage.y - y, _size(y, passage.y), T)
    step = newton_step(passage, passage.y - y, None if forced else direction)
    last = _tried(flow, y + step[:-1], T + step[-1], t0)  # once more: quadratic convergence
    if last is not None and np.abs(last.y - y - step[:-1]).max() <= np.abs(passage.y - y).max():
        y, T, passage = y + step[:-1], T + step[-1], last
    return y, T, passage


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
    share = min(1.0, LARGEST * T / max(abs(step[-1]), 1e-300))
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
    """The Passage, or None if the solve fails."""
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


def return_time(flow, y0, t0):
    """The time after which the solution crosses the plane across its direction at y0 again."""
    e = flow.equations
    direction = e.rates(t0, y0)
    speed = np.linalg.norm(direction)
    if not speed > 0.0:
        raise NotConvergedError("The search begins at an equilibrium: start beside it.")
    result = solve_ivp(
        e.fun, (t0, math.inf), y0, args=e.args, events=Plane(y0, direction), t_eval=[],
        max_steps=RETURN, **flow.options,
    )  # fmt: skip
    times = result.t_events[0][result.t_events[0] > t0]
    if not len(times):
        raise NotConvergedError(
            "`period` is missing, and the solution does not return to where it begins within "
            f"{RETURN} steps: give a guess of the period, or a `transient` towards the orbit."
        )
    distances = np.linalg.norm(result.y_events[0][-len(times) :] - y0, axis=1)
    return float(times[np.argmin(distances)] - t0)
