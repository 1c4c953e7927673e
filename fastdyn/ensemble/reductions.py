"""Reductions: numbers that an ensemble gathers along each trajectory, in constant memory."""

import math
from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.mode import MOMENTS as OF_MOMENTS
from fastdyn.kernels.output.extrema import MAX, MIN, T_MAX, T_MIN
from fastdyn.problem.events import of_own
from fastdyn.problem.options.tolerances import longer_tolerances
from fastdyn.problem.schedules import in_order
from fastdyn.words import kinds
from fastdyn.words.calls import takes
from fastdyn.words.near import did_you_mean

EXTREMA = {"max": MAX, "max_time": T_MAX, "min": MIN, "min_time": T_MIN}
MOMENTS = ("mean", "rms")
NAMES = (*EXTREMA, *MOMENTS, "final", "first_event")


class Fold(NamedTuple):
    """A number that a function of the user gathers along each trajectory, for `reduce`.

    The number begins as `start` and becomes ``function(value, t, y, *args)`` after each accepted
    step: at the end of the step, or at the event or end of the span that ends the step.

    Parameters
    ----------
    function : callable
        Returns one number.
    start : float, optional
        The number before the first step.
    name : str, optional
        Key in `Trajectories.reduced`; by default the name of the function.

    Examples
    --------
    >>> Fold(lambda farthest, t, y: max(farthest, np.hypot(y[0], y[1])), name="farthest")
    """

    function: Any
    start: float = 0.0
    name: str = ""

    def of_state(self, n, n_copies):
        """The function of (t, [value, state]), for the kernels; the state has n components."""
        function = self.function
        end = n // n_copies + 1

        def fold(t, z, *args):
            return function(z[0], t, z[1:], *args)

        def fold_without_moments(t, z, *args):
            return function(z[0], t, z[1:end], *args)

        called = fold if n_copies == 1 else fold_without_moments
        called.__qualname__ = getattr(function, "__qualname__", called.__qualname__)
        return called


def wanted(reduce, events):
    """The argument `reduce`, checked, as a tuple of names and Folds."""
    if reduce is None:
        return ()
    if not isinstance(reduce, str | Fold):
        kinds.several("reduce", reduce)
    items = (reduce,) if isinstance(reduce, str | Fold) else tuple(reduce)
    for item in items:
        if isinstance(item, Fold):
            kinds.function_of("(value, t, y)")("function of a Fold", item.function)
            kinds.number("start of a Fold", item.start)
            if not math.isfinite(item.start):
                raise ValueError(f"a Fold takes a function and a finite number; got {item!r}.")
        elif item not in NAMES:
            advice = did_you_mean(item, NAMES, form='"{}"')
            advice = advice or f"choose from {', '.join(NAMES)}, or give a Fold."
            raise ValueError(f"`reduce={item!r}` is unknown; {advice}")
    names = [name_of(item) for item in items]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"`reduce` names {', '.join(twice)} twice; give a Fold another `name`.")
    if "first_event" in items and events is None:
        raise ValueError('`reduce="first_event"` needs `events`.')
    return items


def check_folds(items, t0, y0, args):
    """Call the functions of Folds once in Python, so that mistakes are raised as they are."""
    form = ", ".join(["value", "t", "y", *(f"args[{i}]" for i in range(len(args)))])
    for item in folds(items):
        takes("fold", item.function, form)
        found = item.function(float(item.start), t0, y0.copy(), *args)
        if np.size(found) != 1:
            raise ValueError(f"a Fold returned {kinds.shown(found)}; it must return one number.")


def check_jumps(items):
    """Refuse reductions that are not defined for a motion with jumps."""
    for item in items:
        if item not in ("final", "first_event"):
            raise ValueError(
                f"`reduce={name_of(item)!r}` does not see the jumps of `on_event`; with them there "
                'are "final" and "first_event", and a further component of the state for the rest.'
            )


def name_of(item):
    """The key of a reduction in `Trajectories.reduced`."""
    if isinstance(item, str):
        return item
    return item.name or getattr(item.function, "__name__", "fold")


def folds(items):
    """The Folds among the reductions."""
    return tuple(item for item in items if isinstance(item, Fold))


def described(item):
    """A reduction in JSON's types, without its function."""
    return item if isinstance(item, str) else [name_of(item), float(item.start)]


def extrema(items):
    """True if a reduction needs largest or smallest values."""
    return any(name in items for name in EXTREMA)


def moments(items):
    """The mode of the derivative extended by the requested moments; None without moments."""
    return OF_MOMENTS.get(tuple([name for name in MOMENTS if name in items]))


def n_copies(items):
    """The length of the extended state, in lengths of the state."""
    found = moments(items)
    return found.n_copies if found else 1


def extended(problem, how, members):
    """The problem with a state that is followed by the integrals of its moments.

    The integrals do not influence the steps.
    """
    if problem.method.second_order:
        raise ValueError(
            f"{problem.method.name} integrates accelerations alone and cannot take means along; "
            "RK4, Gauss8 and the adaptive methods do."
        )
    if problem.project is not None or problem.inside is not None:
        raise ValueError("means cannot be taken along a motion that is projected or kept inside.")
    n = members.n
    times = how.n_copies
    members.lengthen(times)
    more = (times - 1) * n
    rtol, atol = longer_tolerances(problem.method, problem.rtol, problem.atol, n, more)
    events = problem.events and [of_own(event, n) for event in problem.events]
    y0 = np.tile(problem.y0, times)
    mass = problem.mass
    if mass is not None:
        mass = np.eye(times * n)
        mass[:n, :n] = problem.mass
    return problem._replace(y0=y0, rtol=rtol, atol=atol, mode=how, events=events, mass=mass)


def value(item, results, trajectories):
    """The values of a reduction, one row for each trajectory."""
    if isinstance(item, Fold):
        return results.folded[:, folds(trajectories.reductions).index(item)]
    name = item
    y_end = results.y_end
    n = trajectories.y_end.shape[1]
    if name == "final":
        return trajectories.y_end
    if name == "first_event":
        p = trajectories._problem
        if not p.schedules:
            return results.t_first
        n = len(p.events)
        m = len(p.schedules)
        return results.t_first[:, in_order(range(n), p.schedules, range(n, n + m))]
    if name in EXTREMA:
        return results.best[:, EXTREMA[name], :n]
    span = (trajectories.t_end - trajectories.t_start)[:, None]
    if name == "mean":
        return y_end[:, n : 2 * n] / span
    return np.sqrt(y_end[:, -n:] / span)
