"""Explicit methods that stability holds back say so, once for each function.

E. Hairer and G. Wanner, "Solving Ordinary Differential Equations II", section IV.2: the steps h of
a method whose stability ends at -z on the real axis are held back by stability where z / h is the
size of an eigenvalue of the Jacobian, while the solution hardly moves in a step.
"""

import contextlib
import contextvars
import warnings

import numpy as np

from fastdyn.compile.diagnostics import levels_inside
from fastdyn.compile.taylor.accuracy import order_for
from fastdyn.kernels.methods import ON_PAIRS
from fastdyn.kernels.state.record import Y_OLD, Y

from .check_jacobian import evaluated
from .loop import counters

LIMITS = {  # where |R(-z)| first exceeds 1
    "RK23": 2.51, "RK45": 3.30, "DOP853": 6.39, "Tsit5": 3.50, "Vern7": 4.64, "Vern9": 4.47,
    "ode23": 2.51, "ode45": 3.30,
}  # fmt: skip
OF_SERIES = {13: 6.21, 17: 7.70, 25: 10.69}  # the same, by the order: R is a part of exp's series
MANY = 2000  # steps: below, nothing is lost
MOST = 4  # solves of a function that are looked at
NEAR, SLOW = 0.6, 0.02  # of the limit; of the largest component, what a step changes
FEW = 32  # components, for which Rodas5P is mostly the fastest
ITERATIONS, SIZE = 40, 1e-6  # of the power method; of its displacements

_asked: dict = {}
_gives_up = contextvars.ContextVar("gives up", default=False)


class StiffnessWarning(UserWarning):
    """A problem is stiff, and an explicit method slow for it."""


class Stiff(Exception):
    """A run has been given up, because the problem is stiff."""


@contextlib.contextmanager
def given_up():
    """Within, runs of explicit methods raise `Stiff` between two chunks where stability holds."""
    token = _gives_up.set(True)
    try:
        yield
    finally:
        _gives_up.reset(token)


def gives_up():
    """Whether that is asked for."""
    return _gives_up.get()


def watch(problem, run):
    """Let a run be given up, if that is asked for."""
    run.between_chunks = (lambda: _give_up(problem, run)) if _gives_up.get() else None


def _give_up(problem, run):
    found = _held_back(problem, run)
    if found is not None:
        raise Stiff(found)


def notice(problem, run):
    """Warn if stability, and not accuracy, has chosen the steps at the end of a run."""
    function = run.bounds[0].function
    if function is None or counters(run.memory)[0] < MANY:
        return
    place = function.address
    _asked[place] = _asked.get(place, 0) + 1
    if _asked[place] > MOST:
        return
    found = _held_back(problem, run)
    if found is not None:
        _asked[place] = MOST
        few = len(problem.y0) <= FEW and problem.mode != "complex"
        advice = f"Take method='{'Rodas5P' if few else 'BDF'}' or 'Radau'."
        warnings.warn(f"{found} {advice}", StiffnessWarning, stacklevel=levels_inside())


def _held_back(problem, run):
    """What is to be said of a run whose last step stability has chosen; None of others."""
    n_steps, limit, bound = counters(run.memory)[0], _limit(problem), run.bounds[0]
    if n_steps < MANY or limit is None or bound.function is None or bound.pair:
        return None
    state, work = run.view("solve.state")[0], run.view("solve.work")
    t = float(state["t"])
    y, h = work[Y].copy(), abs(t - float(state["t_old"]))
    h = max(h, float(state["h"]))  # the last step may have been cut short
    moved = np.abs(y - work[Y_OLD]).max() / max(np.abs(y).max(), 1e-300)
    if not (np.isfinite(y).all() and moved < SLOW):
        return None
    size = _damped_eigenvalue(bound, t, y)
    if h * size < NEAR * limit:
        return None
    return (
        f"{problem.method.name} took {n_steps} steps, and at t = {t:.6g} they are as "
        f"long as stability allows ({h:.2g}, with an eigenvalue of -{size:.2g} of the Jacobian), "
        "not as accuracy asks: the problem is stiff."
    )


def _limit(problem):
    """Where stability ends on the real axis; None if that is not known."""
    if problem.method.series:
        return OF_SERIES[order_for(problem.rtol, problem.atol, problem.y0)]
    return LIMITS.get(problem.method.name.removesuffix(ON_PAIRS))


def _damped_eigenvalue(bound, t, y):
    """The size of the eigenvalue of largest size, by the power method; 0 unless it is negative.

    The Jacobian is met in differences of the derivative alone.
    """
    n = len(y)
    f, v = evaluated(bound, t, y, n), np.random.default_rng(0).standard_normal(n)
    step, size, along = SIZE * max(np.abs(y).max(), SIZE), 0.0, 0.0
    for _ in range(ITERATIONS):
        v *= step / np.linalg.norm(v)
        change = evaluated(bound, t, y + v, n) - f
        length = np.linalg.norm(change)
        if not 0.0 < length < np.inf:
            return 0.0
        along = float(v @ change) / (step * length)
        size, v = length / step, change
    return size if along < -0.9 else 0.0
