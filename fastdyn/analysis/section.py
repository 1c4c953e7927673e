"""Poincaré sections: by a function of the state, or once in each period of the equations."""

import dataclasses
from typing import Any

import numpy as np

from fastdyn.plot.displayed import Displayed
from fastdyn.problem.options.docstrings import filled
from fastdyn.solve.ivp import solve_ivp
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .equations import SystemEquations, count, equations_of, positive, state_of
from .flow import METHOD, options_of
from .period import check_period
from .shooting import longest

ADVICE = "Give the period of the equations, or a multiple; `solve_ivp` samples at any times."
STEPS = 2000  # between two crossings on the average, before a run is given up


class Crossing:
    """A section as a terminal event that ends a run at crossing number `terminal`."""

    def __init__(self, section, direction, terminal):
        self.section = section
        self.direction = direction
        self.terminal = terminal
        self.__name__ = getattr(section, "__name__", "section")

    def __call__(self, t, y, *args):
        return self.section(t, y, *args)


@dataclasses.dataclass(frozen=True, repr=False)
class Section(Displayed):
    """
    Points of a section.

    Attributes
    ----------
    t : ndarray, shape (n_points,)
        Times, of one start after the other.
    y : ndarray, shape (n, n_points)
    start : ndarray of int, shape (n_points,)
        The start that a point belongs to.
    y0 : ndarray, shape (m, n)
        The starts.
    complete : bool
        Whether each start has as many points as were asked for.
    message : str
        Otherwise the reason, of the first start that has not.
    """

    equations: SystemEquations
    t: np.ndarray
    y: np.ndarray
    start: np.ndarray
    y0: np.ndarray
    complete: bool
    message: str

    def __str__(self):
        return f"Section of {len(self.t)} points from {len(self.y0)} starts. {self.message}".strip()

    @filled()
    def plot(self, components=(0, 1), angles=(), **options) -> Any:
        """Draw the points in the plane of two components.

        Parameters
        ----------
        components : pair of name or int
        angles : name or int, or sequence of them
            Components that are drawn between -pi and pi.
        {figure}
        """
        from fastdyn.plot.analysis.chaos import section

        return section(self, components, angles, **options)


@filled()
@shown_when_wrong(y0=kinds.array, direction=kinds.number)
def poincare(
    fun, y0=None, section=None, period=None, args=(), n_points=1000, n_skipped=0, direction=None,
    **options,
):  # fmt: skip
    """Points at which solutions cross a section, or that they pass once in each period.

    Parameters
    ----------
    fun : callable or System
        ``fun(t, y, *args)``, or a system.
    y0 : array_like, shape (n,) or (m, n), optional
        One start or several; of a system, its initial state by default.
    section : callable or str
        Function of ``(t, y, *args)`` that is zero on the section, or the name of an event of the
        system.
    period : float
        Instead of `section`: the points at t = 0, period, 2 period, ...
    args : tuple
        Arguments of a function.
    n_points : int
        Points from each start.
    n_skipped : int
        Points that are left out before, the transient.
    direction : {1, -1, 0}, optional
        Sign of the rate of `section` at the crossings that count, 0 for both; by default the
        attribute `direction` of the function, or 1 without it.
    **options
        As in `solve_ivp`, `method` among them; by default DOP853, rtol = {rtol of poincare}, atol =
        {atol of poincare}.
        `max_steps` is 2000 for each point by default.

    Returns
    -------
    Section
        With fewer points, or none, if a run failed or stopped crossing: see `complete` and
        `message`.

    Raises
    ------
    ValueError
        For a period that the equations do not have, and arguments that make no sense.

    Notes
    -----
    The compiled loop locates the crossings on the interpolant, as those of events, and keeps
    nothing else of the solution.

    Examples
    --------
    >>> def henon_heiles(t, w):
    ...     x, y, u, v = w
    ...     return [u, v, -x - 2 * x * y, -y - x * x + y * y]
    >>> poincare(henon_heiles, [0, 0.1, 0.4, 0], lambda t, w: w[0], n_points=5000).plot((1, 3))
    """
    equations = equations_of(fun, args)
    rows = [y0] if y0 is None or np.ndim(y0) == 1 else y0
    starts = np.array([state_of(equations, row) for row in rows])
    n_points = count(n_points, "n_points")
    n_skipped = count(n_skipped, "n_skipped", 0)
    max_steps = options.get("max_steps")
    options = options_of(poincare, options.pop("method", METHOD), options)
    if (section is None) == (period is None):
        raise ValueError("Give a `section`, a function that is zero on it, or a `period`.")
    wanted = n_points + n_skipped
    if period is None:
        event = _event(equations, section, direction, wanted)
        most = {"max_steps": STEPS * max(wanted, 100)}
        given = {**options, "events": event, "t_eval": [], **(most if max_steps is None else {})}
        ends = [wanted * longest(equations, 0.0, start) for start in starts]
    else:
        period = positive(period, "period")
        check_period(equations, 0.0, starts[0], period, ADVICE)
        times = period * np.arange(wanted)
        given = {"t_eval": times[n_skipped:], **options}
        ends = [times[-1]] * len(starts)
    parts = []
    message = ""
    for i, (start, end) in enumerate(zip(starts, ends, strict=True)):
        run = solve_ivp(equations.fun, (0.0, end), start, args=equations.args, **given)
        if period is None:
            t = run.t_events[0]
            y = run.y_events[0].reshape(-1, len(start))
        else:
            t = np.asarray(run.t, float)
            y = np.asarray(run.y).reshape(len(start), -1).T
        found = len(t) if period is None else len(t) + n_skipped
        if found < wanted and not message:
            reason = run.message if period is not None else _ended(run, given["max_steps"], end)
            message = f"Start {i} has {found} points of {wanted}: {reason}"
        skipped = n_skipped if period is None else 0
        parts.append((t[skipped:], y[skipped:]))
    return _section(equations, starts, parts, message)


def _ended(run, max_steps, end):
    """Why a run has fewer crossings than were asked for."""
    if run.success:
        return f"the solution does not cross the section again until t = {end:.3g}."
    if run.n_accepted >= max_steps:
        return (
            f"the solution does not cross the section again in the {max_steps} steps (`max_steps`) "
            "that were taken."
        )
    return run.message


def _event(equations, section, direction, terminal):
    if isinstance(section, str):
        events = equations.system.events if equations.system is not None else {}
        if section not in events:
            known = ", ".join(events) or "none"
            raise ValueError(f"There is no event {section!r} for a section; there are: {known}.")
        section = events[section]
    if not callable(section):
        raise TypeError(f"`section` must be a function of (t, y, *args); got {section!r}.")
    if direction is None:
        direction = getattr(section, "direction", 0) or 1
    if direction not in (-1, 0, 1):
        raise ValueError(f"`direction` must be 1, -1 or 0; got {direction!r}.")
    return Crossing(section, direction, terminal)


def _section(equations, starts, parts, message):
    t = np.concatenate([t for t, _ in parts])
    y = np.concatenate([y for _, y in parts]).T
    start = np.repeat(np.arange(len(parts)), [len(t) for t, _ in parts])
    return Section(equations, t, y, start, starts, not message, message)
