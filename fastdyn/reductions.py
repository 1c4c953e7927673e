"""What an ensemble gathers along each trajectory instead of keeping it."""

import math

import numpy as np

from .kernels.extrema import MAX, MIN, T_MAX, T_MIN

EXTREMA = {"max": MAX, "max_time": T_MAX, "min": MIN, "min_time": T_MIN}
MOMENTS = ("mean", "rms")
NAMES = (*EXTREMA, *MOMENTS, "final", "first_event")


def wanted(reduce, events):
    """The names in `reduce`, checked, as a tuple."""
    if reduce is None:
        return ()
    names = (reduce,) if isinstance(reduce, str) else tuple(reduce)
    for name in names:
        if name not in NAMES:
            raise ValueError(f"`reduce={name!r}` is unknown; choose from {', '.join(NAMES)}.")
    if "first_event" in names and events is None:
        raise ValueError('`reduce="first_event"` needs `events`.')
    return names


def extrema(names):
    return not set(names).isdisjoint(EXTREMA)


def moments(names):
    """The mode of the derivative that is extended by the moments asked for; "" for none."""
    return " ".join(name for name in MOMENTS if name in names)


def parts(names):
    """How many times the state fits into the extended one."""
    return 1 + len(moments(names).split())


def extended(problem, mode, members):
    """The problem with a state that is followed by the integrals of its moments.

    They have no part in the choice of the steps: their tolerance is infinite, and the others are
    divided by what the longer state takes from the norm.
    """
    if problem.method.second_order:
        raise ValueError(
            f"{problem.method.name} integrates accelerations alone and cannot take means along; "
            "RK4, Gauss8 and the adaptive methods do."
        )
    if problem.project is not None:
        raise ValueError("means cannot be taken along a motion that is projected.")
    n, times = members.n, parts(mode.split())
    members.lengthen(times)
    share = 1.0 if problem.method.name == "ode45" else 1.0 / math.sqrt(times)
    rtol = (
        problem.rtol
        if problem.method.name == "ode45"
        else np.tile(np.broadcast_to(problem.rtol, n) * share, times)
    )
    atol = np.full(times * n, math.inf)
    atol[:n] = np.broadcast_to(problem.atol, n) * share
    return problem._replace(y0=np.tile(problem.y0, times), rtol=rtol, atol=atol, mode=mode)


def value(name, results, trajectories):
    """The reduced values under this name, one row a trajectory."""
    y_end, n = results.y_end, trajectories.y_end.shape[1]
    if name == "final":
        return y_end[:, :n]
    if name == "first_event":
        return results.t_first
    if name in EXTREMA:
        return results.best[:, EXTREMA[name], :n]
    span = (trajectories.t_end - trajectories.t_start)[:, None]
    if name == "mean":
        return y_end[:, n : 2 * n] / span
    return np.sqrt(y_end[:, -n:] / span)
