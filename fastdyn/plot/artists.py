"""The artists of a moving picture, in the plane and in space."""

from typing import Any

import numpy as np

from . import style
from .needed import needed
from .scene import frame

WIDE = 7.2  # inches of a picture, and its greatest height
EVEN = 0.02  # inches: films have even numbers of pixels, at 100 an inch
MARGIN = (0.85, 0.75)  # inches beside the axes


class Artists:
    """
    The figure of a moving picture.

    Parameters
    ----------
    scenes : list of Scene
    trail : bool
        Whether the traced point leaves a trail.

    Attributes
    ----------
    figure : Figure
    axes : Axes
    """

    def __init__(self, scenes, trail=True):
        pyplot = needed("matplotlib.pyplot")
        self.scenes, self.trail, first = scenes, trail, scenes[0]
        self.space = len(first.traced) == 3
        self.limits = frame(scenes)
        size = (WIDE, 0.9 * WIDE) if self.space else self._size()
        self.figure = pyplot.figure(figsize=size, layout="constrained")
        projection: Any = {"projection": "3d"} if self.space else {}
        self.axes: Any = self.figure.add_subplot(**projection)
        self.axes.set(**self.limits)
        (self._in_space if self.space else self._in_plane)(first)
        self.path = np.array([scene.traced for scene in scenes], float)
        still = [[] for _ in first.traced]
        (self.trace,) = self.axes.plot(*still, color=style.COLOURS[5], lw=1.4)
        self.bodies = [self._body(part) for part in first.bodies]
        self.lines = [self.axes.plot(*part, color="0.3", lw=2)[0] for part in first.lines]
        for part in first.fixed:
            self.axes.plot(*([x] for x in part), "o", color="0.5", ms=9)
        self.points = [
            self.axes.plot(*([x] for x in part), "o", color=style.COLOURS[0], ms=10)[0]
            for part in first.points
        ]

    def _size(self):
        """A figure whose axes have the sides of the frame."""
        x, y = (abs(b - a) for a, b in (self.limits["xlim"], self.limits["ylim"]))
        scale = (WIDE - max(MARGIN)) / max(x, y)
        sides = (scale * x + MARGIN[0], scale * y + MARGIN[1])
        return tuple(EVEN * round(side / EVEN) for side in sides)

    def _in_plane(self, first):
        self.axes.set(aspect="equal", xlabel=first.axes[0], ylabel=first.axes[1])
        self.axes.locator_params(nbins=6)
        if first.ground is not None:
            low = self.limits["ylim"][0]
            self.axes.axhspan(low, first.ground, color=style.GROUND, alpha=0.5, zorder=0)

    def _in_space(self, first):
        ticker = needed("matplotlib.ticker")

        sides = [abs(b - a) for a, b in self.limits.values()]
        self.axes.set_box_aspect(sides, zoom=0.95)
        self.axes.view_init(elev=20, azim=-60)
        self.axes.set(xlabel=first.axes[0], ylabel=first.axes[1], zlabel=first.axes[2])
        for axis in (self.axes.xaxis, self.axes.yaxis, self.axes.zaxis):
            axis.labelpad = 10
            axis.set_major_locator(ticker.MaxNLocator(4))

    def _body(self, part) -> Any:
        about = {"facecolor": style.COLOURS[4], "edgecolor": "0.3", "lw": 1.5}
        if not self.space:
            patches = needed("matplotlib.patches")

            return self.axes.add_patch(patches.Polygon(np.column_stack(part), closed=True, **about))
        art3d = needed("mpl_toolkits.mplot3d.art3d")
        made = art3d.Poly3DCollection([np.column_stack(part)], alpha=0.75, **about)
        self.axes.add_collection3d(made, autolim=False)
        return made

    def show(self, n):
        """Move everything to a scene."""
        scene = self.scenes[n]
        for artist, part in zip(self.lines, scene.lines, strict=True):
            self._move(artist, part)
        for artist, part in zip(self.points, scene.points, strict=True):
            self._move(artist, [[x] for x in part])
        for artist, part in zip(self.bodies, scene.bodies, strict=True):
            corners = np.column_stack(part)
            artist.set_verts([corners]) if self.space else artist.set_xy(corners)
        if self.trail:
            self._move(self.trace, self.path[: n + 1].T)

    def _move(self, artist, part):
        artist.set_data_3d(*part) if self.space else artist.set_data(*part)
