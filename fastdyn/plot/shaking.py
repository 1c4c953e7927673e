"""The figure and the scene of a building that the ground shakes."""

import numpy as np

from . import solution, style
from .animate import Scene


def figure(results, **options):
    """Movement of both floors and of the ground, a panel for each result."""
    with style.slides():
        drawing, panels = style.column(len(results), **options)
        for axes, (label, result) in zip(panels, results.items(), strict=True):
            system = result.system
            t, y = solution.curve(result)
            rest = system.initial_state()
            axes.plot(t, y[1] - rest[1], label="upper floor")
            axes.plot(t, y[0] - rest[0], label="lower floor")
            axes.plot(t, system.ground(t), color="0.5", lw=1.2, label="ground")
            exact = solution.exact_curve(system, t)
            if not np.isnan(exact).any():
                axes.plot(t, exact[1] - rest[1], "k--", lw=1.0, label="exact")
            axes.set(ylabel="displacement (m)", title=label)
        panels[-1].set_xlabel("t (s)")
        style.legend(drawing, *panels)
    return drawing


def scene(ground, w, half):
    """Ground, floors of twice the width `half`, and walls; w begins with both heights."""
    floors = [([-half, half], [height, height]) for height in (ground, w[0], w[1])]
    storeys = ((ground, w[0]), (w[0], w[1]))
    walls = [_zigzag(x, low, high) for low, high in storeys for x in (-half, half)]
    return Scene([*floors, *walls], [(0.0, w[1]), (0.0, w[0])], [])


def _zigzag(x, low, high, n=12):
    """A spring between two heights, as a polyline."""
    side = 0.04 * (high - low) * np.tile([1.0, -1.0], n)[:n]
    return x + np.concatenate([[0.0], side, [0.0]]), np.linspace(low, high, n + 2)
