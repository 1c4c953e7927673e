"""Phase portraits: field, trajectories, equilibria, separatrices of two equations."""

import dataclasses
from typing import Any

import numpy as np

from fastdyn.ensemble.solve import solve_ensemble

from .equations import Equations, box_of, count, equations_of, shared
from .equilibria import Equilibria, equilibria

GRID = 25  # field vectors a side
FINE = 200  # points a side, for the nullclines
LENGTH, POINTS = 3.0, 601  # of a trajectory: in sizes of the box, to both sides
SLOW = 1e-3  # of the median speed: slower is near an equilibrium
OFF = 1e-4  # in sizes of the box, from a saddle to the start of its separatrices
CELLS = 45  # a side: a trajectory ends where another passes through its cell
SHORTEST = 0.15  # trajectory that is drawn, in sizes of the box


class Along:
    """``fun`` at about unit speed, in sizes of the box: the same curves, without blow-up."""

    def __init__(self, fun):
        self.fun = fun
        self.__name__ = getattr(fun, "__name__", "fun")

    def __call__(self, s, y, sign, t, slow, width, height, *args):
        u, v = self.fun(t, y, *args)
        speed = np.sqrt((u / width) ** 2 + (v / height) ** 2 + slow**2)
        return [sign * u / speed, sign * v / speed]


@dataclasses.dataclass(frozen=True)
class Portrait:
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
    equilibria : Equilibria or None
        None if the function cannot be differentiated: `message` tells.
    message : str
    """

    equations: Equations
    box: np.ndarray
    x: np.ndarray
    y: np.ndarray
    field: np.ndarray
    trajectories: list
    separatrices: list
    equilibria: Equilibria | None
    message: str

    def plot(self, nullclines=True, **options) -> Any:
        """Draw field, trajectories, separatrices, equilibria, and the nullclines."""
        from fastdyn.plot.analysis.phase_plane import figure

        return figure(self, nullclines, **options)


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
        The time that `fun` is given.
    starts : array_like, shape (m, 2), optional
        States through which trajectories are drawn, all of them; by default a grid, from which
        trajectories are kept that do not crowd others.
    n_starts : int
        Points of this grid.
    **options
        As in `solve_ensemble`; by default DOP853, rtol = atol = 1e-8.

    Returns
    -------
    Portrait

    Raises
    ------
    ValueError
        For equations of another number of components, and for equations that depend on the time:
        `poincare` draws those.

    Notes
    -----
    Trajectories are solved with the length of the curve instead of the time, so that they cross the
    box at the same pace, and neither blow up nor take for ever near an equilibrium.

    Examples
    --------
    >>> swing = lambda t, y: [y[1], -np.sin(y[0]) - 0.2 * y[1]]
    >>> phase_portrait(swing, [(-7, 7), (-3, 3)]).plot()
    """
    equations, region, t = equations_of(fun, args), box_of(box, 2), float(t)
    if equations.system is not None and len(equations.system.states) != 2:
        raise ValueError(
            f"A phase portrait is of two components; {equations.system.name} has "
            f"{len(equations.system.states)}: `poincare` shows more in a plane."
        )
    options = {"method": "DOP853", "rtol": 1e-8, "atol": 1e-8, "max_steps": 20_000, **options}
    x, y = (np.linspace(*pair, FINE) for pair in region)
    field = _field(equations, t, x, y)
    if not np.isfinite(field).any():
        raise ValueError(f"`fun` is finite nowhere in the box {region.tolist()}.")
    later = _field(equations, t + 0.7318, x[::20], y[::20])
    if not np.array_equal(field[:, ::20, ::20], later, equal_nan=True):
        raise ValueError("`fun` depends on the time: draw a stroboscopic section by `poincare`.")
    found, message = None, ""
    try:
        found = equilibria(fun, region, args=args, t=t)
    except ValueError as reason:
        message = f"Equilibria were not searched. {reason}"
    scaled = np.hypot(*(field / np.ptp(region, axis=1)[:, None, None]))
    slow = SLOW * float(np.nanmedian(scaled)) or SLOW
    follow = _follower(equations, region, t, slow, options)
    separatrices = _separatrices(found, region, follow)
    if starts is None:
        n = max(2, round(count(n_starts, "n_starts") ** 0.5))
        u, v = (np.linspace(*pair, n + 2)[1:-1] for pair in region)
        grid = np.stack(np.meshgrid(u, v), -1).reshape(-1, 2)
        grid = grid[np.random.default_rng(0).permutation(len(grid))]
        curves = _spread(grid, follow, region, [curve for _, curve in separatrices])
    else:
        given = np.asarray(starts, float).reshape(-1, 2) if np.size(starts) % 2 == 0 else np.empty(0)
        if not given.size or not np.isfinite(given).all():
            raise ValueError("`starts` must be finite states, of shape (m, 2).")
        curves = [_joined(*_cut(pair, region)) for pair in follow(given)]
    return Portrait(equations, region, x, y, field, curves, separatrices, found, message)


def _field(equations, t, x, y):
    """Rates on a grid, shape (2, len(y), len(x)); NaN where `fun` raises."""
    grid = np.full((2, len(y), len(x)), np.nan)
    with np.errstate(all="ignore"):
        for i, below in enumerate(y):
            for j, left in enumerate(x):
                try:
                    grid[:, i, j] = equations.rates(t, np.array([left, below]))
                except ArithmeticError:
                    continue
    return grid


def _follower(equations, region, t, slow, options):
    """``follow(states)`` gives for each state (the curve before, the curve after), from there."""
    size = np.ptp(region, axis=1)
    s = np.linspace(0.0, LENGTH, POINTS)

    def follow(states):
        both = np.concatenate([states, states])
        sign = np.repeat([-1.0, 1.0], len(states))
        found = solve_ensemble(
            Along(equations.fun), (0.0, LENGTH), both,
            (sign, t, slow, *size, *shared(equations.args)), t_eval=s, **options,
        ).y  # fmt: skip
        return list(zip(found[: len(states)], found[len(states) :], strict=True))

    return follow


def _cut(pair, region):
    """Two curves from one state, each up to where it leaves the box, and one point more."""
    parts = []
    for curve in pair:
        inside = ((curve >= region[:, :1]) & (curve <= region[:, 1:])).all(axis=0)
        end = len(inside) if inside.all() else int(np.argmin(inside))
        more = end < len(inside) and np.isfinite(curve[:, end]).all()
        parts.append(curve[:, : end + more])
    return parts


def _joined(before, after):
    """The curve through a state from its parts."""
    return np.concatenate([before[:, :0:-1], after], axis=1)


def _separatrices(found, region, follow):
    """Curves from and to the saddles, along their eigenvectors."""
    curves, size = [], np.ptp(region, axis=1)
    for each in found or ():
        if each.kind != "saddle":
            continue
        _, vectors = np.linalg.eig(each.matrix)
        values = np.linalg.eigvals(each.matrix).real
        for value, vector in zip(values, vectors.real.T, strict=True):
            step = OFF * vector / np.linalg.norm(vector / size)
            for pair in follow(np.array([each.y + step, each.y - step])):
                before, after = _cut(pair, region)
                curves.append(("from", after) if value > 0 else ("to", before[:, ::-1]))
    return curves


def _spread(states, follow, region, drawn):
    """Curves through states, each up to a cell that another curve has passed."""
    taken = np.zeros((CELLS + 1, CELLS + 1), int)
    size, curves = np.ptp(region, axis=1), []

    def cells(curve):
        share = (curve - region[:, :1]) / size[:, None] * CELLS
        return tuple(np.clip(share, 0, CELLS).astype(int))

    for curve in drawn:
        taken[cells(curve)] = -1
    for state, pair in zip(states, follow(states), strict=True):
        if taken[cells(state[:, None])].any():
            continue
        parts = []
        for part in _cut(pair, region):
            met = np.flatnonzero(taken[cells(part)])
            parts.append(part[:, : met[0]] if len(met) else part)
        curve = _joined(*parts)
        steps = np.diff(curve, axis=1) / size[:, None]
        if curve.shape[1] < 2 or np.hypot(*steps).sum() < SHORTEST:
            continue
        curves.append(curve)
        taken[cells(curve)] = len(curves)
    return curves
