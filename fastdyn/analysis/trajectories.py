"""Trajectories of two equations, as curves in a box."""

import numpy as np

from fastdyn.ensemble.solve import solve_ensemble

from .equations import shared

LENGTH, POINTS = 4.2, 841  # length of a trajectory to each side, in sizes of the box; its points
CLOSED = 5e-4  # a curve that returns to its start within this distance, in sizes, is closed
CROWDED = 0.2  # a closed curve with a larger share in the cells of other curves is left out
CELLS = 45  # cells on each side of the box; a trajectory ends in a cell of another trajectory
SHORTEST = 0.15  # shortest trajectory that is drawn, in sizes of the box


class Along:
    """``fun`` scaled to about unit speed, in sizes of the box, with the curves of ``fun``."""

    def __init__(self, fun):
        self.fun = fun
        self.__name__ = getattr(fun, "__name__", "fun")

    def __call__(self, s, y, sign, t, slow, width, height, *args):
        u, v = self.fun(t, y, *args)
        speed = np.sqrt((u / width) ** 2 + (v / height) ** 2 + slow**2)
        return [sign * u / speed, sign * v / speed]


def follower(equations, region, t, slow, options):
    """``follow(states)`` returns, for each state, the curves backwards and forwards from it."""
    size = np.ptp(region, axis=1)

    def follow(states, length=LENGTH):
        s = np.linspace(0.0, length, POINTS)
        both = np.concatenate([states, states])
        sign = np.repeat([-1.0, 1.0], len(states))
        found = solve_ensemble(
            Along(equations.fun), (0.0, length), both,
            (sign, t, slow, *size, *shared(equations.args)), t_eval=s, **options,
        ).y  # fmt: skip
        return list(zip(found[: len(states)], found[len(states) :], strict=True))

    return follow


def cut(pair, region):
    """Two curves from one state, each cut one point after it leaves the box."""
    parts = []
    for curve in pair:
        inside = ((curve >= region[:, :1]) & (curve <= region[:, 1:])).all(axis=0)
        end = len(inside) if inside.all() else int(np.argmin(inside))
        more = end < len(inside) and np.isfinite(curve[:, end]).all()
        parts.append(curve[:, : end + more])
    return parts


def closed(curve, region):
    """The closed curve, up to the return to its start; None if the curve does not return."""
    size = np.ptp(region, axis=1)[:, None]
    away = np.hypot(*((curve - curve[:, :1]) / size))
    far = away > 10.0 * LENGTH / POINTS
    if not far.any():
        return None
    at = int(np.argmax(far))
    if not (~far[at:]).any():
        return None
    at += int(np.argmax(~far[at:]))
    at += int(np.argmin(away[at : at + 20]))
    one = curve[:, max(at - 1, 0)]
    other = curve[:, min(at + 1, curve.shape[1] - 1)]
    way = (other - one) / size[:, 0]
    off = (curve[:, 0] - one) / size[:, 0]
    aside = abs(way[0] * off[1] - way[1] * off[0]) / max(np.hypot(*way), 1e-300)
    whole = np.concatenate([curve[:, :at], curve[:, :1]], axis=1)
    inside = ((whole >= region[:, :1]) & (whole <= region[:, 1:])).all()
    return whole if aside < CLOSED and inside else None


def joined(before, after):
    """The curve through a state from its parts."""
    return np.concatenate([before[:, :0:-1], after], axis=1)


def spread(states, follow, region, drawn):
    """Curves through states, each up to a cell that another curve has passed."""
    taken = np.zeros((CELLS + 1, CELLS + 1), int)
    size = np.ptp(region, axis=1)
    curves = []

    def cells(curve):
        share = (curve - region[:, :1]) / size[:, None] * CELLS
        return tuple(np.clip(share, 0, CELLS).astype(int))

    for curve in drawn:
        taken[cells(curve)] = -1
    for state, pair in zip(states, follow(states), strict=True):
        if taken[cells(state[:, None])].any():
            continue
        curve = closed(pair[1], region)
        if curve is not None:
            if (taken[cells(curve)] != 0).mean() > CROWDED:
                continue
        else:
            parts = []
            for part in cut(pair, region):
                met = np.flatnonzero(taken[cells(part)])
                parts.append(part[:, : met[0]] if len(met) else part)
            curve = joined(*parts)
        steps = np.diff(curve, axis=1) / size[:, None]
        if curve.shape[1] < 2 or np.hypot(*steps).sum() < SHORTEST:
            continue
        curves.append(curve)
        taken[cells(curve)] = len(curves)
    return curves
