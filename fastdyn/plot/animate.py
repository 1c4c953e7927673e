"""A run as a moving picture: GIF, HTML with controls, or MP4 where ffmpeg is."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from . import style
from .needed import needed
from .solution import between

FINE = 8  # points of the trail for each picture
ENDINGS = (".gif", ".html", ".mp4")


class Scene(NamedTuple):
    """What a system looks like in one state, in its plane.

    Parameters
    ----------
    lines : list of (x, y)
        Polylines: cables, springs, wheels.
    points : list of (x, y)
        Masses; the first of them leaves a trail.
    fixed : list of (x, y)
        Points that stay where they are.
    bodies : list of (x, y)
        Filled polygons.
    ground : float, optional
        The height of the ground, drawn across the picture.
    axes : (str, str)
        Names of both axes.
    note : str
        Said beside the time.
    frame : tuple, optional
        Lower left and upper right corner of a region that the picture shows at least.
    """

    lines: list
    points: list
    fixed: list
    bodies: list | tuple = ()
    ground: float | None = None
    axes: tuple = ("x (m)", "y (m)")
    note: str = ""
    frame: tuple = ()


def animate(result, path, seconds=None, fps=25, trail=True):
    """
    Write a run of a system as a moving picture.

    Parameters
    ----------
    result : SystemResult
        Of `System.solve`; with ``dense_output=True`` the picture is smooth between the steps.
    path : str or path
        A file that ends in .gif, .html, or .mp4, which ffmpeg makes.
    seconds : float, optional
        Length of the picture; that of the run, but 10 at most, unless given.
    fps : int
        Pictures a second.
    trail : bool
        Whether the first mass leaves a trail.

    Raises
    ------
    ValueError
        For another ending, an .mp4 without ffmpeg, a system that has no view, or a run of fewer
        than two points.
    """
    animation, pyplot = needed("matplotlib.animation"), needed("matplotlib.pyplot")

    path = Path(path)
    if path.suffix not in ENDINGS:
        raise ValueError(f"`{path.name}`: a moving picture ends in {', '.join(ENDINGS)}.")
    if path.suffix == ".mp4" and not animation.writers.is_available("ffmpeg"):
        raise ValueError("An .mp4 is made by ffmpeg, which is not installed; take .gif or .html.")
    if not (fps >= 1 and (seconds is None or 0.0 < seconds < 1e6)):
        raise ValueError(f"`fps` and `seconds` must be positive; got {fps} and {seconds}.")
    if len(result.t) < 2:
        raise ValueError("A run of fewer than two points cannot be animated.")
    t, scenes = _scenes(result, seconds, fps)
    n = (len(t) - 1) // FINE + 1
    with style.slides():
        figure, axes = pyplot.subplots(figsize=(6.4, 6.6), layout="constrained")
        draw = _artists(axes, scenes, trail)
        digits = 2 if abs(t[-1] - t[0]) >= 1.0 else 4
        notes = [_pace(abs(t[-1] - t[0]) * fps / (n - 1)), scenes[0].note]
        note = f"   ({', '.join(one for one in notes if one)})" if any(notes) else ""

        def show(picture):
            draw(FINE * picture)
            axes.set_title(f"t = {t[FINE * picture]:.{digits}f} s{note}")

        show(0)
        layout: Any = figure.get_layout_engine()
        layout.set(w_pad=0.12, h_pad=0.12)
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # the layout is found once
        moving = animation.FuncAnimation(figure, show, n, interval=1000.0 / fps)
        try:
            if path.suffix == ".html":
                path.write_text(moving.to_jshtml(fps=fps), encoding="utf-8")
            else:
                gif = path.suffix == ".gif"
                writer: Any = animation.PillowWriter if gif else animation.FFMpegWriter
                moving.save(path, writer(fps=fps), dpi=80 if gif else 120)
        finally:
            pyplot.close(figure)


def _pace(factor):
    """How much faster or slower than the motion a picture runs, in words; none at its speed."""
    if abs(factor - 1.0) < 0.05:
        return ""
    return f"{factor:.2g} × as fast" if factor > 1.0 else f"{1.0 / factor:.2g} × slower"


def spring(start, end, n=12):
    """A spring between two points, as a polyline."""
    (x0, y0), (x1, y1) = start, end
    along = np.concatenate([[0.0, 0.08], np.linspace(0.08, 0.92, n + 2)[1:-1], [0.92, 1.0]])
    side = np.concatenate([[0.0, 0.0], 0.06 * np.tile([1.0, -1.0], n)[:n], [0.0, 0.0]])
    dx, dy = x1 - x0, y1 - y0
    return x0 + along * dx - side * dy, y0 + along * dy + side * dx


def _scenes(result, seconds, fps):
    """Equally spaced times, FINE for each picture, and the scene at each."""
    system, span = result.system, abs(result.t[-1] - result.t[0])
    seconds = min(span, 10.0) if seconds is None else float(seconds)
    n = FINE * (max(2, round(seconds * fps)) - 1) + 1
    t = np.linspace(result.t[0], result.t[-1], n)
    if (sol := between(result)) is not None:
        y = sol(t)
    else:
        order = slice(None) if result.t[-1] > result.t[0] else slice(None, None, -1)
        y = np.array([np.interp(t, result.t[order], row[order]) for row in result.y])
    return t, [system.scene(time, state) for time, state in zip(t, y.T, strict=True)]


def _frame(scenes):
    """Limits of the axes that show all of every scene."""
    xs, ys = [], []
    for scene in scenes:
        for x, y in [*scene.lines, *scene.points, *scene.fixed, *scene.bodies, *scene.frame]:
            xs.append(np.atleast_1d(x))
            ys.append(np.atleast_1d(y))
        if scene.ground is not None:
            ys.append(np.atleast_1d(scene.ground))
    xs, ys = np.concatenate(xs), np.concatenate(ys)
    reach = 0.57 * max(np.ptp(xs), np.ptp(ys), 1e-9)
    x, y = 0.5 * (xs.min() + xs.max()), 0.5 * (ys.min() + ys.max())
    if scenes[0].ground is not None and ys.min() >= scenes[0].ground:
        y = scenes[0].ground + 0.85 * reach  # little of what is below
    return {"xlim": (x - reach, x + reach), "ylim": (y - reach, y + reach)}


def _artists(axes, scenes, trail):
    """Make the artists of the first scene; returns ``draw(i)``, which moves them to scene i."""
    first = scenes[0]
    axes.set(**_frame(scenes), aspect="equal", xlabel=first.axes[0], ylabel=first.axes[1])
    axes.locator_params(nbins=6)
    if first.ground is not None:
        axes.axhspan(axes.get_ylim()[0], first.ground, color=style.GROUND, alpha=0.5, zorder=0)
    path = np.array([scene.points[0] for scene in scenes])
    (trace,) = axes.plot([], [], color=style.COLOURS[5], lw=1.2)
    bodies = [axes.fill(x, y, color=style.COLOURS[4], ec="0.3", lw=1.5)[0] for x, y in first.bodies]
    lines = [axes.plot(x, y, color="0.3", lw=2)[0] for x, y in first.lines]
    for x, y in first.fixed:
        axes.plot(x, y, "o", color="0.5", ms=9)
    points = [axes.plot(x, y, "o", color=style.COLOURS[0], ms=10)[0] for x, y in first.points]

    def draw(i):
        scene = scenes[i]
        for artist, (x, y) in zip(lines, scene.lines, strict=True):
            artist.set_data(x, y)
        for artist, (x, y) in zip(points, scene.points, strict=True):
            artist.set_data([x], [y])
        for artist, (x, y) in zip(bodies, scene.bodies, strict=True):
            artist.set_xy(np.column_stack([x, y]))
        if trail:
            trace.set_data(*path[: i + 1].T)

    return draw
