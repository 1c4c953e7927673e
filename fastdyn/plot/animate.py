"""A run as a moving picture: GIF, HTML with controls, or MP4 by ffmpeg."""

import base64
import math
import pathlib
import tempfile
from typing import Any, NamedTuple

import numpy as np

from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from . import style
from .chords import times
from .needed import needed
from .scene import frame
from .solution import between

FPS = 30
LONGEST = 10.0  # seconds of a film, unless asked otherwise
DPI = 100
ENDINGS = (".gif", ".html", ".mp4")
NO_FFMPEG = (
    "An .mp4 is made by ffmpeg, which is not installed: "
    'python -m pip install "fastdyn[video]" brings one; or take .gif or .html.'
)
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
        self.scenes = scenes
        self.trail = trail
        first = scenes[0]
        self.space = len(first.traced) == 3
        self.limits = frame(scenes)
        size = (WIDE, self._height()) if self.space else self._size()
        self.figure = pyplot.figure(figsize=size, layout="constrained")
        projection: Any = {"projection": "3d"} if self.space else {}
        self.axes: Any = self.figure.add_subplot(**projection)
        self.axes.set(**self.limits)
        if self.space:
            in_space(self.axes, self.limits, first)
        else:
            self._in_plane(first)
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

    def _height(self):
        """The height of a picture in space: less for what is flat."""
        sides = [abs(b - a) for a, b in self.limits.values()]
        return EVEN * round(WIDE * (0.6 + 0.3 * sides[-1] / max(sides)) / EVEN)

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


def in_space(axes, limits, scene, zoom=1.0):
    """Set the axes of a scene in space, with the ground below everything else."""
    ticker = needed("matplotlib.ticker")
    sides = [abs(b - a) for a, b in limits.values()]
    flat = sides[-1] / max(sides)
    axes.set_box_aspect(sides, zoom=zoom * (1.15 - 0.25 * flat))
    axes.view_init(elev=20, azim=-60)
    axes.set(xlabel=scene.axes[0], ylabel=scene.axes[1], zlabel=scene.axes[2])
    axes.tick_params(labelsize=11)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.labelpad = 12
        axis.set_major_locator(ticker.MaxNLocator(4))
    axes.zaxis.set_major_locator(ticker.MaxNLocator(max(2, round(4 * flat))))
    axes.zaxis.labelpad = 8
    if scene.ground is not None:
        axes.computed_zorder = False  # by distance, the middle of the ground may be before a body
        style.ground(axes, limits["xlim"], limits["ylim"], scene.ground).set_zorder(-1.0)


class Moving(NamedTuple):
    """A moving picture that a notebook shows; `html` is its text."""

    html: str

    def _repr_html_(self):
        return self.html


@shown_when_wrong(result=kinds.result, path=kinds.path, seconds=kinds.number, fps=kinds.number)
def animate(result, path=None, seconds=None, fps=FPS, trail=True):
    """
    Write a run of a system as a moving picture.

    Parameters
    ----------
    result : SystemResult
        A result of `System.solve`; with ``dense_output=True`` the motion is smooth between steps.
    path : str or path, optional
        A file that ends in .gif, .html or .mp4. An .mp4 needs ffmpeg, for example from the extra
        `video`. With ffmpeg, an .html contains a film, without ffmpeg half as many single pictures.
    seconds : float, optional
        Length of the film; by default the time span of the run, at most 10.
    fps : int
        Pictures per second; a GIF rounds the time of a picture to hundredths of a second.
    trail : bool
        Whether one of the masses leaves a trail.

    Returns
    -------
    Moving or None
        Without `path`, a Moving, which a notebook shows.

    Raises
    ------
    ValueError
        For another ending, an .mp4 without ffmpeg, a system that has no view, or a run of fewer
        than two points.
    """
    pyplot = needed("matplotlib.pyplot")

    ending = ".html" if path is None else pathlib.Path(path).suffix
    if ending not in ENDINGS:
        name = pathlib.Path(path or "").name
        raise ValueError(f"`path={name!r}`: a moving picture ends in {', '.join(ENDINGS)}.")
    ffmpeg = _ffmpeg()
    if ending == ".mp4" and not ffmpeg:
        raise ValueError(NO_FFMPEG)
    if not (fps >= 1 and (seconds is None or 0.0 < seconds < 1e6)):
        raise ValueError(f"`fps` and `seconds` must be positive; got {fps} and {seconds}.")
    if len(result.t) < 2:
        raise ValueError("A run of fewer than two points cannot be animated.")
    if ending == ".gif":
        fps = 100.0 / max(2, round(100.0 / fps))  # a GIF counts hundredths of a second
    elif ending == ".html" and not ffmpeg:
        fps = max(1, fps // 2)
    with style.slides():
        figure, moving = _moving(_film(result, seconds, fps), fps, trail)
        try:
            if ending == ".html":
                html = _video(moving, fps) if ffmpeg else moving.to_jshtml(fps=int(fps))
                if path is None:
                    return Moving(html)
                pathlib.Path(path).write_text(_page(result.system.title, html), encoding="utf-8")
            else:
                _write(moving, path, fps, ending)
        finally:
            pyplot.close(figure)
    return None


def _moving(film, fps, trail):
    """The animation of a film, with its figure."""
    animation = needed("matplotlib.animation")
    t, scenes, pictures = film
    artists, n = Artists(scenes, trail), len(pictures)
    digits = 2 if abs(t[-1] - t[0]) >= 1.0 else 4
    notes = [scenes[0].note, _pace(abs(t[-1] - t[0]) * fps / (n - 1))]
    artists.axes.set_title(", ".join(filter(None, notes)), loc="right", fontsize=12, color="0.3")

    def show(picture):
        artists.show(pictures[picture])
        artists.axes.set_title(f"t = {t[pictures[picture]]:.{digits}f} s", loc="left")

    show(0)
    layout: Any = artists.figure.get_layout_engine()
    layout.set(w_pad=0.12, h_pad=0.12)
    artists.figure.draw_without_rendering()
    artists.figure.set_layout_engine("none")  # the layout is found once
    moving = animation.FuncAnimation(artists.figure, show, n, interval=1000.0 / fps)
    return artists.figure, moving


def _write(moving, path, fps, ending=".mp4"):
    """Write a film or a GIF."""
    animation = needed("matplotlib.animation")
    if ending == ".gif":
        cut_off = 1.0 + 1e-9  # the writer cuts off 1000 / (100 / 3) milliseconds to 29
        moving.save(path, animation.PillowWriter(fps=fps / cut_off), dpi=80)
        return
    with needed("matplotlib").rc_context({"animation.ffmpeg_path": _ffmpeg()}):
        options = ["-pix_fmt", "yuv420p", "-movflags", "+faststart"]
        writer = animation.FFMpegWriter(fps=fps, codec="libx264", extra_args=options)
        moving.save(path, writer, dpi=DPI)


def _video(moving, fps):
    """A film as the text of a page."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "film.mp4")
        _write(moving, path, fps)
        film = base64.b64encode(path.read_bytes()).decode()
    return f'<video controls loop autoplay muted src="data:video/mp4;base64,{film}"></video>'


def _page(title, html):
    return f'<!DOCTYPE html>\n<meta charset="utf-8">\n<title>{title}</title>\n{html}\n'


def _ffmpeg():
    """The path of ffmpeg, from PATH or from imageio-ffmpeg; None without ffmpeg."""
    import shutil

    if found := shutil.which("ffmpeg"):
        return found
    try:
        import imageio_ffmpeg

        return imageio_ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        return None


def _pace(factor):
    """The speed of a film relative to the motion, in words."""
    if abs(factor - 1.0) < 0.05:
        return "real time"
    digits = max(2, 1 + math.floor(math.log10(max(factor, 1.0 / factor))))
    return f"{factor:.{digits}g} × real time" if factor > 1.0 else f"{1 / factor:.2g} × slower"


class Film(NamedTuple):
    """Times, the scene at each, and which of these are pictures; the trail has all times."""

    t: np.ndarray
    scenes: list
    pictures: np.ndarray


def _film(result, seconds, fps):
    """Equally spaced pictures, and between them the points without which the trail has corners."""
    span = abs(result.t[-1] - result.t[0])
    seconds = min(span, LONGEST) if seconds is None else float(seconds)
    even = np.linspace(result.t[0], result.t[-1], max(2, round(seconds * fps)))
    steps = np.sort(result.t)
    sol = between(result)
    t = np.union1d(even, steps if sol is None else times(sol, steps))
    if sol is not None:
        y = sol(t)
    else:
        order = np.argsort(result.t)
        y = np.array([np.interp(t, steps, row[order]) for row in result.y])
    if result.t[-1] < result.t[0]:
        t = t[::-1]
        y = y[:, ::-1]
        pictures = len(t) - 1 - np.searchsorted(t[::-1], even)
    else:
        pictures = np.searchsorted(t, even)
    return Film(t, result.system.scenes(t, y), pictures)
