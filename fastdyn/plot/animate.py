"""A run as a moving picture: GIF, HTML with controls, or MP4 by ffmpeg."""

import base64
import math
import pathlib
import tempfile
from typing import Any, NamedTuple

import numpy as np

from . import style
from .artists import Artists
from .needed import needed
from .solution import between

FINE = 8  # points of the trail for each picture
FPS = 30
DPI = 100
ENDINGS = (".gif", ".html", ".mp4")
NO_FFMPEG = (
    "An .mp4 is made by ffmpeg, which is not installed: "
    'python -m pip install "fastdyn[video]" brings one; or take .gif or .html.'
)


class Moving(NamedTuple):
    """A moving picture that a notebook shows; `html` is its text."""

    html: str

    def _repr_html_(self):
        return self.html


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
        raise ValueError(f"`{name}`: a moving picture ends in {', '.join(ENDINGS)}.")
    film = _ffmpeg()
    if ending == ".mp4" and not film:
        raise ValueError(NO_FFMPEG)
    if not (fps >= 1 and (seconds is None or 0.0 < seconds < 1e6)):
        raise ValueError(f"`fps` and `seconds` must be positive; got {fps} and {seconds}.")
    if len(result.t) < 2:
        raise ValueError("A run of fewer than two points cannot be animated.")
    if ending == ".gif":
        fps = 100.0 / max(2, round(100.0 / fps))  # a GIF counts hundredths of a second
    elif ending == ".html" and not film:
        fps = max(1, fps // 2)
    t, scenes = _scenes(result, seconds, fps)
    with style.slides():
        figure, moving = _moving(t, scenes, fps, trail)
        try:
            if ending == ".html":
                html = _film(moving, fps) if film else moving.to_jshtml(fps=int(fps))
                if path is None:
                    return Moving(html)
                pathlib.Path(path).write_text(_page(result.system.title, html), encoding="utf-8")
            else:
                _write(moving, path, fps, ending)
        finally:
            pyplot.close(figure)
    return None


def _moving(t, scenes, fps, trail):
    """The animation of the scenes, with its figure."""
    animation = needed("matplotlib.animation")
    artists, n = Artists(scenes, trail), (len(t) - 1) // FINE + 1
    digits = 2 if abs(t[-1] - t[0]) >= 1.0 else 4
    notes = [scenes[0].note, _pace(abs(t[-1] - t[0]) * fps / (n - 1))]
    artists.axes.set_title(", ".join(filter(None, notes)), loc="right", fontsize=12, color="0.3")

    def show(picture):
        artists.show(FINE * picture)
        artists.axes.set_title(f"t = {t[FINE * picture]:.{digits}f} s", loc="left")

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
        moving.save(path, animation.PillowWriter(fps=fps), dpi=80)
        return
    with needed("matplotlib").rc_context({"animation.ffmpeg_path": _ffmpeg()}):
        options = ["-pix_fmt", "yuv420p", "-movflags", "+faststart"]
        writer = animation.FFMpegWriter(fps=fps, codec="libx264", extra_args=options)
        moving.save(path, writer, dpi=DPI)


def _film(moving, fps):
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


def _scenes(result, seconds, fps):
    """Equally spaced times, FINE for each picture, and the scene at each."""
    span = abs(result.t[-1] - result.t[0])
    seconds = min(span, 10.0) if seconds is None else float(seconds)
    n = FINE * (max(2, round(seconds * fps)) - 1) + 1
    t = np.linspace(result.t[0], result.t[-1], n)
    if (sol := between(result)) is not None:
        y = sol(t)
    else:
        order = slice(None) if result.t[-1] > result.t[0] else slice(None, None, -1)
        y = np.array([np.interp(t, result.t[order], row[order]) for row in result.y])
    return t, result.system.scenes(t, y)
