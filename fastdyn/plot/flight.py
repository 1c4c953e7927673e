"""The figures and the scene of a flight in space: the trajectory, height and speed."""

import math
from typing import Any

import numpy as np

from . import solution, style
from .needed import needed
from .scene import Scene

FAR = 3.0  # a flight with so many times the shortest range leaves the picture


def figure(results, speed, **options):
    """
    Trajectories in space over the ground, beside height and speed against time.

    Parameters
    ----------
    results : dict of str to OdeResult
        Results by label; the states begin with x, y, z. The shortest flights determine the size of
        the picture, which cuts much longer flights.
    speed : callable
        The quantity for the speed, for the first system; other systems have their own.
    """

    with style.slides():
        size = {"figsize": (14, 7)}
        drawing = style.new_figure(**size | options)
        grid = drawing.add_gridspec(2, 2, width_ratios=(5, 3))
        space: Any = drawing.add_subplot(grid[:, 0], projection="3d")
        height = drawing.add_subplot(grid[0, 1])
        fast = drawing.add_subplot(grid[1, 1], sharex=height)
        curves = {label: solution.curve(result) for label, result in results.items()}
        low, high, left_out = _frame([y[:3] for _, y in curves.values()])
        _ground(space, low, high)
        for (label, (t, y)), cut in zip(curves.items(), left_out, strict=True):
            result = results[label]
            shown = np.where(cut, np.nan, y[:3])
            label = f"{label} (leaves the picture)" if cut.any() else label
            (line,) = space.plot(*shown, lw=2.5, label=label)
            colour = line.get_color()
            space.plot(shown[0], shown[1], 0.0 * shown[2], color=colour, lw=1.2, ls=":")
            _wind(space, result.system, low, high, colour)
            height.plot(t, y[2], label=label)
            fast.plot(t, result.system.along(result.system.quantities.get("speed", speed), t, y))
        height.axhline(0.0, color="0.4", lw=2)
        height.set_ylabel("height z (m)")
        fast.set(xlabel="t (s)", ylabel="speed (m/s)")
        fast.set_ylim(bottom=0.0)
        style.legend(drawing, height)
    return drawing


def _frame(paths):
    """The corners of the visible box, and for each path whether its points lie outside."""
    reach = [max(np.ptp(path, axis=1).max(), 1e-9) for path in paths]
    shown = [p for p, r in zip(paths, reach, strict=True) if r <= FAR * min(reach)]
    together = np.concatenate(shown, axis=1)
    low = together.min(axis=1)
    high = together.max(axis=1)
    margin = 0.15 * (high - low).max()
    low[:2] = low[:2] - margin
    high = high + margin
    if (low[2], high[2]) != (0.0, 0.0):
        low[2] = min(low[2], 0.0)
    outside = [((p < low[:, None]) | (p > high[:, None])).any(axis=0) for p in paths]
    return low, high, outside


def _ground(space, low, high):
    """The axes of the picture, with the ground in it."""
    ticker = needed("matplotlib.ticker")

    style.ground(space, (low[0], high[0]), (low[1], high[1]), 0.0)
    space.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")
    space.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    for axis in (space.xaxis, space.yaxis, space.zaxis):
        axis.labelpad = 12
        axis.set_major_locator(ticker.MaxNLocator(4))
    space.zaxis.labelpad = 0
    space.view_init(elev=18, azim=-62)
    space.set_box_aspect(high - low, zoom=1.18)


def _wind(space, system, low, high, colour):
    """Draw the direction of the wind, if any, as an arrow on the ground."""
    wind = np.array([getattr(system, name, 0.0) for name in ("wx", "wy", "wz")])
    size = math.hypot(*wind)
    if size == 0.0:
        return
    arrow = 0.25 * (high - low)[:2].max() * wind / size
    middle = np.array([*(low[:2] + (0.3, 0.1) * (high - low)[:2]), 0.0])
    tail = middle - 0.5 * arrow
    space.quiver(*tail, *arrow, color=colour, lw=2.5, arrow_length_ratio=0.3)
    space.text(*middle, f"wind {size:g} m/s\n", color=colour, ha="center", va="bottom")


def scene(w, start):
    """The ball seen from the side: distance from the place of the launch, and height."""
    far = math.hypot(w[0] - start[0], w[1] - start[1])
    names = ("horizontal distance (m)", "z (m)")
    return Scene([], [(far, w[2])], [], axes=names, ground=0.0)
