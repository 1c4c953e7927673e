"""The result of ode45, and deval."""

import copy
import dis
import sys
from typing import Any, NamedTuple

import numpy as np

from fastdyn.compile.sentences import warn
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

ATTRIBUTES = ("x", "y", "xe", "ye", "ie", "te", "stats", "solver")  # of a Solution


class Request(NamedTuple):
    """The request of a solution: its solver, its function and its options."""

    solver: Any
    fun: Any
    options: Any


class Solution:
    """
    The result of `ode45` or another solver: MATLAB's struct, which unpacks to MATLAB's outputs.

    ``t, y = ode45(...)`` unpacks to the times, shape (n_points,), and the states, shape
    (n_points, n): the refined steps, or the times of a `tspan` of more than two times. With the
    option Events, ``t, y, te, ye, ie = ode45(...)`` also gives times, states (rows) and indices of
    the events. As in MATLAB, the number of names on the left decides.

    Attributes
    ----------
    solver : str
    x : ndarray, shape (n_steps + 1,)
        The ends of the steps, not refined.
    y : ndarray, shape (n, n_steps + 1)
        One column for each step, as in MATLAB's struct.
    xe, ye, ie : ndarray, shapes (n_events,), (n, n_events), (n_events,)
        Events in the order of time, one column for each; indices count from 0. None without the
        option Events. `te` equals `xe`.
    stats : dict
        ``nsteps``, ``nfailed``, ``nfevals``.
    """

    def __init__(self, call, result, output, events):
        self.call = call
        self.solver = call.solver.name
        self.interpolant = result.sol
        self.result = result
        self.x, self.y = np.asarray(result.t), np.asarray(result.y)
        self.xe: Any = None
        self.ye: Any = None
        self.ie: Any = None
        if events is not None:
            self.xe, ye, self.ie = events
            self.ye = ye.T
        counts = result.n_accepted, result.n_rejected, result.nfev
        self.stats = dict(zip(("nsteps", "nfailed", "nfevals"), counts, strict=True))
        self._output = output

    @property
    def te(self):
        """Times of the events, as `xe`."""
        return self.xe

    def __iter__(self):
        names = _names_on_the_left(sys._getframe(1))
        if names > 2 and self.ye is None:
            raise ValueError(
                f"{self.solver} has two outputs here, t and y, for {names} names: te, ye and ie "
                "need the option Events, odeset('Events', events)."
            )
        t, y = self._output(self)
        found = (t, y) if self.ye is None else (t, y, self.xe, self.ye.T, self.ie)
        return iter(found[: names or None])

    def __getattr__(self, name):
        raise AttributeError(f"a solution has no `{name}`; it has {', '.join(ATTRIBUTES)}.")

    def __getitem__(self, index):
        raise TypeError(
            f"a solution has no entry {index!r}: write `t, y = {self.solver}(...)`, or take its "
            "parts by name, `sol.x` and `sol.y`."
        )

    def joined(self, later):
        """The Solution that consists of this Solution and of `later`, which begins at its end."""
        both = copy.copy(later)
        first = 1 if np.array_equal(later.y[:, 0], self.y[:, -1]) else 0
        both.x = np.append(self.x, later.x[first:])
        both.y = np.column_stack([self.y, later.y[:, first:]])
        both.interpolant = Joined(self.interpolant, later.interpolant, self.x[-1])
        if later.xe is not None and self.xe is not None:
            both.xe = np.append(self.xe, later.xe)
            both.ye = np.column_stack([self.ye, later.ye])
            both.ie = np.append(self.ie, later.ie)
        both.stats = {name: self.stats[name] + later.stats[name] for name in self.stats}
        both._output = Both(self, later, first)
        return both

    def __repr__(self):
        n, points = self.y.shape
        events = "" if self.xe is None else f", {len(self.xe)} events"
        return (
            f"<{self.solver}: {points - 1} steps of {n} components from {self.x[0]:g} to "
            f"{self.x[-1]:g}{events}>"
        )


def _names_on_the_left(frame, behind_call=False):
    """The number of names to which the caller unpacks, as MATLAB's nargout; 0 without unpacking.

    A frame unpacks now, or next, `behind_call` that it makes.
    """
    code = frame.f_code.co_code
    place = frame.f_lasti
    if behind_call:
        place += 2
        while code[place] == dis.opmap["CACHE"]:
            place += 2
    unpacks = place >= 0 and code[place] == dis.opmap["UNPACK_SEQUENCE"]
    return code[place + 1] if unpacks else 0


class Joined(NamedTuple):
    """The continuous solutions of two runs, the first up to a time."""

    first: Any
    second: Any
    time: float

    def __call__(self, t):
        return self._joined(self.first, self.second, t)

    def derivative(self, t):
        """The derivative, as of one run."""
        return self._joined(self.first.derivative, self.second.derivative, t)

    def _joined(self, first, second, t):
        t = np.asarray(t, float)
        forwards = self.second.ts[-1] >= self.second.ts[0]
        early = t <= self.time if forwards else t >= self.time
        if t.ndim == 0:
            return (first if early else second)(t)
        y = second(t)
        y[:, early] = first(t[early])
        return y


class Both(NamedTuple):
    """The output of two solutions, the second from its first or second point on."""

    before: Any
    later: Any
    first: int

    def __call__(self, _) -> Any:
        (t, y), (s, z) = (one._output(one) for one in (self.before, self.later))
        return np.append(t, s[self.first :]), np.vstack([y, z[self.first :]])


class Refined(NamedTuple):
    """Output at every step and, evenly spaced, between them: `refine` points a step."""

    refine: int

    def __call__(self, solution) -> Any:
        x = solution.x
        y = solution.y.T
        if self.refine == 1 or len(x) < 2:
            return x, y
        share = np.arange(1, self.refine) / self.refine
        between = x[:-1, None] + np.diff(x)[:, None] * share
        t = np.append(np.column_stack([x[:-1], between]).ravel(), x[-1])
        values = np.empty((len(t), y.shape[1]))
        values[:: self.refine] = y
        inside = np.arange(len(t)) % self.refine > 0
        values[inside] = solution.interpolant(t[inside]).T
        return t, values


class AtTimes(NamedTuple):
    """Output at given times up to the end of the run, and at an event that ended the run."""

    times: np.ndarray
    ended: bool

    def __call__(self, solution) -> Any:
        x = solution.x
        y = solution.y.T
        there = (self.times - x[0]) * (x[-1] - self.times) >= 0.0
        t = self.times[there]
        if self.ended and t[-1] != x[-1]:
            t = np.append(t, x[-1])
        values = solution.interpolant(t).T if len(x) > 1 else y[: len(t)]
        at_end = t == x[-1]
        at_start = t == x[0]
        values[at_end], values[at_start] = y[-1], y[0]
        return t, values


@shown_when_wrong(idx=kinds.array)
def deval(sol, xint, idx=None) -> Any:
    """
    The continuous solution, as MATLAB's deval; ``y, yp = deval(...)`` has its derivative, too.

    Parameters
    ----------
    sol : Solution
        The result of a solver; it may also be the second argument.
    xint : float or array_like, shape (k,)
        Times within the span of the solution.
    idx : int or list of int, optional
        The components to return, counted from 0; by default all.

    Returns
    -------
    ndarray, shape (n, k)
        One column for each time; shape (n,) for a single time.  As in MATLAB, the number of names
        on the left decides: two names are this array and an array of derivatives.

    Raises
    ------
    ValueError
        For times outside the span.

    Warns
    -----
    UserWarning
        If two names may be meant for the two components.
    """
    if isinstance(xint, Solution):
        sol, xint = xint, sol
    if not isinstance(sol, Solution):
        raise TypeError("deval takes what `sol = ode45(...)` returned, and times.")
    kinds.numbers("xint", xint)
    x = np.asarray(xint, float)
    low, high = sorted((sol.x[0], sol.x[-1]))
    if x.ndim > 1 or not ((low <= x) & (x <= high)).all():
        raise ValueError(f"deval knows the solution from {low:g} to {high:g}; got {xint!r}.")
    y = sol.interpolant(x)
    chosen = slice(None) if idx is None else idx
    both = _names_on_the_left(sys._getframe(2), behind_call=True) == 2
    if both and len(y) == 2 and idx is None:
        warn(
            "`y, yp = deval(...)` has the solution and its derivative, as in MATLAB; the two "
            "components are rows of one output, y = deval(...): y[0], y[1]."
        )
    try:
        return (y[chosen], sol.interpolant.derivative(x)[chosen]) if both else y[chosen]
    except IndexError as error:
        raise kinds.noted(
            error, f"`idx` counts components from 0 to {len(y) - 1}; got {idx!r}."
        ) from None
