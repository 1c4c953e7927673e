"""The figure and the scene of a building that the ground shakes."""

import numpy as np

from . import solution, style
from .scene import Scene, spring

DOTS = 160  # dots of the exact solution, far enough apart to show the computed line


def figure(results, **options):
    """
    Movement of both floors and of the ground, a panel for each result.

    The acceleration of a ground that is given by samples has a panel of its own, above.
    """
    panels_of = [row for label, result in results.items() for row in _rows(label, result)]
    with style.slides():
        size = {"figsize": (12, 1.4 + 2.6 * len(panels_of))}
        drawing, panels = style.column(len(panels_of), **size | options)
        for axes, (draw, label, result) in zip(panels, panels_of, strict=True):
            draw(axes, label, result)
        panels[-1].set_xlabel("t (s)")
        style.legend(drawing, *panels)
    return drawing


def _rows(label, result):
    """The panels that show a result: (function that draws, label, result)."""
    shown = [(_floors, label, result)]
    return shown if result.system.times is None else [(_accelerogram, label, result), *shown]


def _floors(axes, label, result):
    """Displacements from rest."""
    system = result.system
    t, y = solution.curve(result)
    rest = system.initial_state()
    dots = np.linspace(t[0], t[-1], DOTS)
    exact = solution.exact_curve(system, dots)
    axes.plot(t, y[1] - rest[1], color=style.COLOURS[0], lw=2.0, label="upper floor")
    axes.plot(t, y[0] - rest[0], color=style.COLOURS[1], lw=1.6, label="lower floor")
    axes.plot(t, system.ground(t), color="0.5", lw=1.2, label="ground")
    if not np.isnan(exact).any():
        for floor in (0, 1):
            axes.plot(dots, exact[floor] - rest[floor], "k.", ms=3, label="exact")
    axes.set(title=label, ylabel="displacement (m)")


def _accelerogram(axes, label, result):
    """The acceleration of the ground, above the floors."""
    t, _ = solution.curve(result)
    acceleration = result.system.ground_acceleration(t)
    axes.plot(t, acceleration, color=style.COLOURS[3], lw=1.2)
    axes.set(ylabel="acceleration\nof the ground (m/s²)")


def scene(ground, w, half):
    """Ground, floors of twice the width `half`, and walls; w begins with both heights."""
    thick = 0.12 * half
    across = np.array([-half, half, half, -half])
    floors = [(across, height + thick * np.array([-1, -1, 1, 1])) for height in (w[0], w[1])]
    storeys = ((ground, w[0] - thick), (w[0] + thick, w[1] - thick))
    walls = [
        spring((x, low), (x, high)) for low, high in storeys for x in (-0.8 * half, 0.8 * half)
    ]
    base = ([-1.6 * half, 1.6 * half], [ground, ground])
    return Scene([base, *walls], [(0.0, w[1])], [], bodies=floors)
