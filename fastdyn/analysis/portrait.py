"""Phase portraits: field, trajectories, equilibria, separatrices of two equations."""

import dataclasses
from typing import Any

import numpy as np

from fastdyn.ensemble.plan import OWN
from fastdyn.plot.displayed import Displayed
from fastdyn.problem.options.docstrings import filled
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .equations import NotConvergedError, SystemEquations, box_of, count, equations_of
from .flow import METHOD, options_of
from .orbit import PeriodicOrbit, periodic_orbit
from .rest.equilibria import Equilibria, equilibria
from .trajectories import cut, follower, joined, spread

FINE = 121  # points a side of the field
LATER = 0.7318  # a later time, at which the field is compared
SLOW = 1e-3  # a speed below this share of the median counts as near an equilibrium
OFF = 1e-4  # distance from a saddle to the start of its separatrices, in sizes of the box
BESIDE = 0.03  # sizes of the box from an equilibrium, or from a cycle
FAR, LOOKS = 20.0, 5  # distance to a limit cycle, in sizes of the box; starts on each side


@dataclasses.dataclass(frozen=True, repr=False)
class Portrait(Displayed):
    """
    A phase portrait.

    Attributes
    ----------
    box : ndarray, shape (2, 2)
        A pair (low, high) for each component.
    x, y : ndarray, shape (k,), (l,)
        Grid of the field.
    field : ndarray, shape (2, l, k)
        Rates on the grid.
    trajectories : list of ndarray, shape (2, n_points)
        In the direction of time, cut at the box.
    separatrices : list of (str, ndarray)
        "to" or "from" a saddle, and the curve, in the direction of time.
    cycles : list of PeriodicOrbit
        Limit cycles in the box, attracting or repelling; a cycle inside another may be missed.
    equilibria : Equilibria or None
        None if the function cannot be differentiated; `message` gives the reason.
    message : str
    """

    equations: SystemEquations
    box: np.ndarray
    x: np.ndarray
    y: np.ndarray
    field: np.ndarray
    trajectories: list
    separatrices: list
    cycles: list[PeriodicOrbit]
    equilibria: Equilibria | None
    message: str

    def __str__(self):
        counts = (
            (len(self.trajectories), "trajectories"), (len(self.separatrices), "separatrices"),
        )  # fmt: skip
        drawn = ", ".join(f"{n} {what}" for n, what in counts if n)
        head = f"Phase portrait of {drawn}. {self.message}".strip()
        found = [self.equilibria] if self.equilibria is not None else []
        return "\n".join(map(str, [head, *self.cycles, *found]))

    @filled()
    def plot(self, nullclines=True, **options) -> Any:
        """Draw field, trajectories, separatrices, equilibria and nullclines.

        Parameters
        ----------
        nullclines : bool
            Whether to draw the nullclines.
        {figure}
        """
        from fastdyn.plot.analysis.phase_plane import figure

        return figure(self, nullclines, **options)


@filled()
@shown_when_wrong(t=kinds.number, starts=kinds.array, n_starts=kinds.whole)
def phase_portrait(fun, box, args=(), t=0.0, starts=None, n_starts=400, **options):
    """The phase portrait of two equations that do not depend on the time.

    Parameters
    ----------
    fun : callable or System
        ``fun(t, y, *args)`` of two components, or a system of two.
    box : array_like, shape (2, 2)
        A pair (low, high) for each component.
    args : tuple
        Arguments of a function.
    t : float
        The time at which `fun` is evaluated.
    starts : array_like, shape (m, 2), optional
        States through which trajectories are drawn; by default a grid, without the trajectories
        that come too close to others.
    n_starts : int
        Points of the grid.
    **options
        As in `solve_ensemble`; by default DOP853, rtol = {rtol of phase_portrait}, atol =
        {atol of phase_portrait}.

    Returns
    -------
    Portrait

    Raises
    ------
    ValueError
        If the equations have not two components, or depend on the time: see `poincare` for
        equations that depend on the time.

    Notes
    -----
    Trajectories are solved with the arc length as the independent variable instead of the time:
    they cross the box at equal speed, do not blow up, and do not take long near an equilibrium.

    Examples
    --------
    >>> swing = lambda t, y: [y[1], -np.sin(y[0]) - 0.2 * y[1]]
    >>> phase_portrait(swing, [(-7, 7), (-3, 3)]).plot()
    """
    equations = equations_of(fun, args)
    region = box_of(box, 2)
    t = float(t)
    if equations.system is not None and len(equations.system.states) != 2:
        raise ValueError(
            f"A phase portrait is of two components; {equations.system.name} has "
            f"{len(equations.system.states)}: `poincare` shows more in a plane."
        )
    options = options_of(phase_portrait, options.pop("method", METHOD), options, OWN)
    x, y = (np.linspace(low, high, FINE) for low, high in region)
    equations.rates(t, region.mean(axis=1))  # mistakes of the user are raised here
    field = _field(equations, t, x, y)
    if not np.isfinite(field).all(axis=0).any():
        raise ValueError(f"`fun` is finite nowhere in the box {region.tolist()}.")
    few = slice(None, None, FINE // 6)
    later = _field(equations, t + LATER, x[few], y[few])
    if not np.array_equal(field[:, few, few], later, equal_nan=True):
        raise ValueError("`fun` depends on the time: draw a stroboscopic section by `poincare`.")
    found = None
    message = ""
    try:
        found = equilibria(fun, region, args=args, t=t)
    except ValueError as reason:
        message = f"Equilibria were not searched. {reason}"
    scaled = np.hypot(*(field / np.ptp(region, axis=1)[:, None, None]))
    slow = SLOW * float(np.nanmedian(scaled)) or SLOW
    follow = follower(equations, region, t, slow, options)
    separatrices = _separatrices(found, region, follow)
    cycles = [] if found is None else _cycles(fun, args, found, region, follow)
    if starts is None:
        grid = _grid(region, max(2, round(count(n_starts, "n_starts") ** 0.5)))
        grid = grid[np.random.default_rng(0).permutation(len(grid))]
        drawn = [curve for _, curve in separatrices] + [cycle.y for cycle in cycles]
        curves = spread(grid, follow, region, drawn)
    else:
        given = (
            np.asarray(starts, float).reshape(-1, 2) if np.size(starts) % 2 == 0 else np.empty(0)
        )
        if not given.size or not np.isfinite(given).all():
            raise ValueError("`starts` must be finite states, of shape (m, 2).")
        curves = [joined(*cut(pair, region)) for pair in follow(given)]
    return Portrait(equations, region, x, y, field, curves, separatrices, cycles, found, message)


def _grid(region, n):
    """n by n states inside a box, shape (n², 2)."""
    u, v = (np.linspace(low, high, n + 2)[1:-1] for low, high in region)
    return np.stack(np.meshgrid(u, v), -1).reshape(-1, 2)


def _cycles(fun, args, equilibria, region, follow):
    """Limit cycles to which trajectories from the box come, forwards or backwards."""
    found = []
    size = np.ptp(region, axis=1).max()
    pairs = follow(_grid(region, LOOKS), FAR)
    for end in (part[:, -1] for pair in pairs for part in pair):
        if not ((end >= region[:, 0]) & (end <= region[:, 1])).all():
            continue
        if any(np.abs(each.y - end).max() < BESIDE * size for each in equilibria):
            continue
        if any(_on(end, cycle, size) for cycle in found):
            continue
        try:
            cycle = periodic_orbit(fun, end, args=args)
        except (NotConvergedError, ValueError):
            continue
        near = np.abs(cycle.y.T - end).max(axis=1).min() < BESIDE * size
        if cycle.stable is not None and near and not any(_on(cycle.y0, c, size) for c in found):
            found.append(cycle)
    return found


def _on(state, cycle, size):
    """Whether a state lies on a cycle, but for the distance of its points."""
    steps = np.abs(np.diff(cycle.y, axis=1)).max()
    return bool(np.abs(cycle.y.T - state).max(axis=1).min() <= steps + 1e-3 * size)


def _field(equations, t, x, y):
    """Rates on a grid, shape (2, len(y), len(x)); NaN where `fun` raises."""
    grid = np.full((2, len(y), len(x)), np.nan)
    with np.errstate(all="ignore"):
        for i, below in enumerate(y):
            for j, left in enumerate(x):
                try:
                    grid[:, i, j] = equations.rates(t, np.array([left, below]))
                except (ArithmeticError, ValueError):  # outside the domain of `fun`
                    continue
    return grid


def _separatrices(found, region, follow):
    """Curves from and to the saddles, along their eigenvectors."""
    curves = []
    size = np.ptp(region, axis=1)
    for each in found or ():
        if each.kind != "saddle":
            continue
        values, vectors = map(np.real, np.linalg.eig(each.matrix))
        for value, vector in zip(values, vectors.T, strict=True):
            step = OFF * vector / np.linalg.norm(vector / size)
            for pair in follow(np.array([each.y + step, each.y - step])):
                before, after = cut(pair, region)
                curves.append(("from", after) if value > 0 else ("to", before[:, ::-1]))
    return curves
