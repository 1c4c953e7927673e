"""A run as a moving picture: GIF, or HTML with controls."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from . import style

FINE = 8  # points of the trail for each picture


class Scene(NamedTuple):
    """What a system looks like in one state, in its plane.

    Parameters
    ----------
    lines : list of (x, y)
        Polylines: cables, walls, wheels.
    points : list of (x, y)
        Masses; the first of them leaves a trail.
    fixed : list of (x, y)
        Points that stay where they are.
    """

    lines: list
    points: list
    fixed: list


def animate(result, path, seconds=None, fps=25, trail=True):
    """
    Write a run of a system as a moving picture.

    Parameters
    ----------
    result : SystemResult
        Of `System.solve`; with ``dense_output=True`` the picture is smooth between the steps.
    path : str or path
        A file that ends in .gif or .html.
    seconds : float, optional
        Length of the picture; that of the run, but 10 at most, unless given.
    fps : int
        Pictures a second.
    trail : bool
        Whether the first mass leaves a trail.

    Raises
    ------
    ValueError
        For another ending, a system that has no view, or a run of fewer than two points.
    """
    from matplotlib import animation, pyplot

    path = Path(path)
    if path.suffix not in (".gif", ".html"):
        raise ValueError(f"`{path.name}`: a moving picture is a .gif or an .html file.")
    if not (fps >= 1 and (seconds is None or 0.0 < seconds < 1e6)):
        raise ValueError(f"`fps` and `seconds` must be positive; got {fps} and {seconds}.")
    if len(result.t) < 2:
        raise ValueError("A run of fewer than two points cannot be animated.")
    t, scenes = _scenes(result, seconds, fps)
    n = (len(t) - 1) // FINE + 1
    with style.slides():
        figure, axes = pyplot.subplots(figsize=(6.4, 6.4), layout="constrained")
        axes.set(**_frame(scenes), aspect="equal", xlabel="x (m)", ylabel="y (m)")
        clock = axes.set_title("")
        draw = _artists(axes, scenes, trail)

        def show(picture):
            draw(FINE * picture)
            clock.set_text(f"t = {t[FINE * picture]:.2f} s")

        show(0)
        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # the layout is found once
        moving = animation.FuncAnimation(figure, show, n, interval=1000.0 / fps)
        try:
            if path.suffix == ".gif":
                moving.save(path, animation.PillowWriter(fps=fps), dpi=60)
            else:
                path.write_text(moving.to_jshtml(fps=fps))
        finally:
            pyplot.close(figure)


def _scenes(result, seconds, fps):
    """Equally spaced times, FINE for each picture, and the scene at each."""
    system, span = result.system, abs(result.t[-1] - result.t[0])
    seconds = min(span, 10.0) if seconds is None else float(seconds)
    n = FINE * (max(2, round(seconds * fps)) - 1) + 1
    t = np.linspace(result.t[0], result.t[-1], n)
    if result.sol is not None:
        y = result.sol(t)
    else:
        order = slice(None) if result.t[-1] > result.t[0] else slice(None, None, -1)
        y = np.array([np.interp(t, result.t[order], row[order]) for row in result.y])
    return t, [system.scene(time, state) for time, state in zip(t, y.T, strict=True)]


def _frame(scenes):
    """Limits of the axes that show all of every scene."""
    xs, ys = [], []
    for scene in scenes:
        for x, y in [*scene.lines, *scene.points, *scene.fixed]:
            xs.append(np.atleast_1d(x))
            ys.append(np.atleast_1d(y))
    xs, ys = np.concatenate(xs), np.concatenate(ys)
    reach = 0.55 * max(np.ptp(xs), np.ptp(ys), 1e-9)
    x, y = 0.5 * (xs.min() + xs.max()), 0.5 * (ys.min() + ys.max())
    return {"xlim": (x - reach, x + reach), "ylim": (y - reach, y + reach)}


def _artists(axes, scenes, trail):
    """Make the artists of the first scene; returns ``draw(i)``, which moves them to scene i."""
    first = scenes[0]
    path = np.array([scene.points[0] for scene in scenes])
    (trace,) = axes.plot([], [], color=style.COLOURS[5], lw=1.2)
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
        if trail:
            trace.set_data(*path[: i + 1].T)

    return draw
