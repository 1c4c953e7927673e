"""Basins of attraction: an ensemble of starts on a grid, classified by attractor."""

import dataclasses
from typing import Any

import numpy as np

from fastdyn.ensemble.plan import OWN
from fastdyn.ensemble.solve import solve_ensemble
from fastdyn.plot.displayed import Displayed
from fastdyn.problem.options.docstrings import filled
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .attractors import APART, UNDECIDED, attraction, clusters, described, drifting, fitted, grown
from .equations import SystemEquations, box_of, count, equations_of, positive, shared
from .flow import METHOD, options_of

ESCAPED = -2  # label
NEAR = 0.05  # share of the range of all ends: nearer ends belong to one attractor
LEAST = 0.1  # least range, as a share of the box
FEWEST = 5e-4  # least share of the grid for an attractor
WINDOW = 0.1  # length of a window, as a share of t_end


@dataclasses.dataclass(frozen=True, repr=False)
class Basin(Displayed):
    """
    Basins of attraction on a grid of starts.

    Attributes
    ----------
    x, y : ndarray, shape (k,), (l,)
        The values of the two components on the grid.
    labels : ndarray of int, shape (l, k)
        Number of the attractor. -1: the motion has not settled on an attractor. -2: the solve
        failed, or the motion grows beyond all bounds. -3: no attractor, as without damping: the
        motion keeps its distance from neighbouring motions.
    attractors : list of (ndarray, ndarray)
        Smallest and largest value of each component on each attractor, shape (n,); both are the
        state of an equilibrium.
    shares : ndarray
        Share of the grid that belongs to each attractor.
    near : float
        The largest distance of ends that belong to one attractor.
    undecided, escaped, apart : float
        Shares of the labels -1, -2 and -3.
    """

    equations: SystemEquations
    components: tuple
    x: np.ndarray
    y: np.ndarray
    labels: np.ndarray
    attractors: list
    near: float

    @property
    def shares(self):
        return np.array([(self.labels == k).mean() for k in range(len(self.attractors))])

    @property
    def undecided(self):
        return float((self.labels == UNDECIDED).mean())

    @property
    def escaped(self):
        return float((self.labels == ESCAPED).mean())

    @property
    def apart(self):
        return float((self.labels == APART).mean())

    @property
    def names(self):
        """The attractors in words."""
        return [described(low, high, self.near) for low, high in self.attractors]

    @property
    def others(self):
        """(share, words) of the labels -1, -2 and -3."""
        return [
            (self.undecided, "not settled"),
            (self.apart, "nothing attracts: neighbours stay apart"),
            (self.escaped, "failed or beyond all bounds"),
        ]

    def __str__(self):
        many = {0: "No attractor was found", 1: "Basin of one attractor"}
        head = many.get(len(self.attractors), f"Basins of {len(self.attractors)} attractors")
        lines = [f"{head} from {self.labels.size} starts"]
        for share, name in zip(self.shares, self.names, strict=True):
            lines.append(f"  {share:6.1%}  {name}")
        for share, what in self.others:
            if share:
                lines.append(f"  {share:6.1%}  {what}")
        return "\n".join(lines)

    @filled()
    def plot(self, **options) -> Any:
        """Draw the plane of the starts, with a colour for each attractor.

        Parameters
        ----------
        {figure}
        """
        from fastdyn.plot.analysis.chaos import basin

        return basin(self, **options)


@filled()
@shown_when_wrong(at=kinds.numbers, components=kinds.several, attractors=kinds.numbers)
def basin(
    fun, box, args=(), at=None, components=(0, 1), n=200, t_end=100.0, window=None,
    attractors=None, near=None, **options,
):  # fmt: skip
    """Find the attractor that the motion from each start of a grid approaches.

    Parameters
    ----------
    fun : callable or System
        ``fun(t, y, *args)``, or a system.
    box : array_like, shape (2, 2)
        A pair (low, high) for each of the two components of the grid.
    args : tuple
        Arguments of a function.
    at : array_like, shape (n,), optional
        The values of the other components; by default the initial state of a system, or zeros in
        two dimensions.
    components : pair of int
        The two components of the grid.
    n : int or pair of int
        Points of the grid along each component.
    t_end : float
        Time after which the motions have settled.
    window : float, optional
        Length of each of two windows after `t_end`, in which the range of each component is taken;
        by default a tenth of `t_end`. A window must contain a period of each periodic attractor.
    attractors : array_like, shape (k, n), optional
        Equilibria that motions may approach; by default attractors are found as clusters of the
        ranges of all components.
    near : float, optional
        The largest distance of ends that belong to one attractor, in each component; by default 5 %
        of the largest range of all motions at the end.
    **options
        As in `solve_ensemble`; by default DOP853, rtol = {rtol of basin}, atol =
        {atol of basin}.

    Returns
    -------
    Basin
        A motion whose ranges differ between the two windows by more than `near` is undecided.

    Raises
    ------
    ValueError
        For arguments that make no sense.

    Examples
    --------
    >>> well = lambda t, y: [y[1], y[0] - y[0] ** 3 - 0.2 * y[1]]
    >>> basin(well, [(-2, 2), (-2, 2)]).plot()
    """
    equations, region = equations_of(fun, args), box_of(box, 2)
    state = _rest(equations, at)
    i, j = _pair(components, len(state))
    sides = list(n) if np.iterable(n) and not isinstance(n, str) else [n, n]
    x, y = (
        np.linspace(low, high, count(side, "n", 2))
        for (low, high), side in zip(region, sides, strict=True)
    )
    starts = np.tile(state, (len(x) * len(y), 1))
    starts[:, i], starts[:, j] = np.tile(x, len(y)), np.repeat(y, len(x))
    t_end = positive(t_end, "t_end")
    window = WINDOW * t_end if window is None else positive(window, "window")
    options = options_of(basin, options.pop("method", METHOD), options, OWN)
    first, second, ends, fine = _ranges(equations, starts, t_end, window, options)
    fine &= ~grown(first, second, np.abs(np.concatenate([region.ravel(), state])).max())
    labels = np.full(len(starts), UNDECIDED)
    labels[~fine] = ESCAPED
    size = np.ptp(region, axis=1).max()
    still = fine & ~drifting(first, second, LEAST * size)
    low, high = np.split(second[still], 2, axis=1)
    spread = (high.max(axis=0) - low.min(axis=0)).max() if still.any() else 0.0
    near = NEAR * max(spread, LEAST * size) if near is None else positive(near, "near")
    settled = still & (np.abs(first - second) <= near).all(axis=1)
    if attractors is None:
        centres = clusters(second[settled], near, max(2.0, FEWEST * len(starts)))
    else:
        given = np.atleast_2d(np.asarray(attractors, float))
        if given.shape[1] != len(state) or not np.isfinite(given).all():
            raise ValueError(f"`attractors` must be finite states, of shape (k, {len(state)}).")
        centres = np.hstack([given, given])
    if len(centres):
        distances = np.abs(second[settled][:, None] - centres).max(axis=2)
        nearest = distances.argmin(axis=1)
        labels[settled] = np.where(distances.min(axis=1) <= near, nearest, UNDECIDED)
    if attractors is None and len(centres):
        began = t_end + 2.0 * window

        def later(states):
            return _ranges(equations, states, t_end, window, options, began)[1]

        kinds = np.array(attraction(first, second, ends, labels, centres, near, later))
        if (kinds == APART).any():
            labels[settled & (labels == UNDECIDED)] = APART
        real = kinds >= 0
        numbers = np.where(real, np.cumsum(real) - 1, kinds)
        labels[labels >= 0] = numbers[labels[labels >= 0]]
        centres = centres[real]
    found = fitted(first, second, labels, centres, near)
    return Basin(equations, (i, j), x, y, labels.reshape(len(y), len(x)), found, near)


def _rest(equations, at):
    """The start whose components are replaced."""
    if at is None and equations.system is None:
        return np.zeros(2)
    at = equations.system.initial_state() if at is None else at
    state = np.asarray(at, float)
    if state.ndim != 1 or len(state) < 2 or not np.isfinite(state).all():
        raise ValueError("`at` must be one finite state, of two components at least.")
    return state


def _pair(components, n):
    found = tuple(components)
    if len(found) != 2 or found[0] == found[1] or any(k not in range(n) for k in found):
        raise ValueError(f"`components` must be two of 0 to {n - 1}; got {components!r}.")
    return found


def _ranges(equations, starts, t_end, window, options, begin=0.0):
    """(lowest, highest) of each component in two windows, the ends, and the success of solves."""
    e = equations
    ranges = []
    fine = np.ones(len(starts), bool)
    for length, reduce in ((t_end, None), (window, ["min", "max"]), (window, ["min", "max"])):
        run = solve_ensemble(
            e.fun, (begin, begin + length), starts, shared(e.args), reduce=reduce, **options
        )
        fine &= run.success & np.isfinite(run.y_end).all(axis=1)
        starts = np.where(fine[:, None], run.y_end, 0.0)
        begin = begin + length
        if reduce:
            ranges.append(np.hstack([run.reduced["min"], run.reduced["max"]]))
    return *ranges, starts, fine
