"""Moving pictures."""

import numpy as np
import pytest
from matplotlib import animation
from PIL import Image

from fastdyn.course.gallery import moving_run
from fastdyn.plot import animate
from fastdyn.plot.animate import Artists, _ffmpeg
from fastdyn.plot.scene import frame
from fastdyn.systems import SYSTEMS, cable, satellite


def test_moving_pictures(tmp_path):
    run = cable(V0=5.9).solve((0.0, 2.0))
    for name in ("cable.gif", "cable.html"):
        run.animate(tmp_path / name, seconds=0.3, fps=10)
        assert (tmp_path / name).stat().st_size > 1000
    with pytest.raises(ValueError, match=r"ends in \.gif, \.html, \.mp4"):
        run.animate(tmp_path / "cable.mp3")


@pytest.mark.hunt
def test_a_film_needs_ffmpeg_and_says_where_it_comes_from(tmp_path, monkeypatch):
    run = cable(V0=5.9).solve((0.0, 2.0))
    if _ffmpeg():
        run.animate(tmp_path / "cable.mp4", seconds=0.1, fps=20)
        assert (tmp_path / "cable.mp4").read_bytes()[4:8] == b"ftyp"
    for name in SYSTEMS:
        moving = moving_run(name)
        figure = Artists(moving.system.scenes(moving.t, moving.y)).figure
        assert all(round(100 * side, 6) % 2 == 0 for side in figure.get_size_inches())
        assert "video/mp4" in run.animate(seconds=0.1)._repr_html_()
    monkeypatch.setattr(animate, "_ffmpeg", lambda: None)
    with pytest.raises(ValueError, match=r"fastdyn\[video\]"):
        run.animate(tmp_path / "cable.mp4")
    assert "<script" in run.animate(seconds=0.2, fps=10)._repr_html_()


def test_the_time_factor_is_said_in_a_corner():
    assert animate._pace(1.0) == "real time"
    assert [animate._pace(f) for f in (2.0, 0.25, 1500.0)] == [
        "2 × real time", "4 × slower", "1500 × real time"
    ]  # fmt: skip
    film = animate._film(cable(V0=5.9).solve((0.0, 2.0)), 1.0, 10)
    figure, _ = animate._moving(film, 10, True)
    assert figure.axes[0].get_title(loc="right") == "2.2 × real time"


def test_a_gif_takes_the_time_that_it_says(tmp_path):
    """1000 / (100 / 3) is 29.999...: the writer cut it to 29, and GIFs count hundredths: 20 ms."""
    path = tmp_path / "moving.gif"
    cable(V0=5.9).solve((0.0, 0.5)).animate(path)
    with Image.open(path) as film:
        shown = [film.seek(k) or film.info["duration"] for k in range(film.n_frames)]
    assert sum(shown) == pytest.approx(500, abs=40)


@pytest.mark.few(3)
@pytest.mark.parametrize("name", SYSTEMS)
def test_every_system_moves_inside_its_frame(name, tmp_path):
    run = moving_run(name)
    run.animate(tmp_path / "moving.gif", seconds=0.2, fps=10)
    assert (tmp_path / "moving.gif").read_bytes().startswith(b"GIF8")
    scenes = [run.system.scene(t, state) for t, state in zip(run.t, run.y.T, strict=True)]
    limits = frame(scenes)
    for scene in scenes:
        for x, y in [*scene.lines, *scene.points, *scene.bodies]:
            assert limits["xlim"][0] <= np.min(x) and np.max(x) <= limits["xlim"][1]
            assert limits["ylim"][0] <= np.min(y) and np.max(y) <= limits["ylim"][1]


def test_nothing_of_a_moving_picture_is_clipped(tmp_path, monkeypatch):
    figures = []
    monkeypatch.setattr(animation.FuncAnimation, "save", lambda self, *a, **k: figures.append(
        (self._fig, self._fig.get_tightbbox())))  # fmt: skip
    for name in ("vehicle", "nanoparticle", "suspension", "building"):
        moving_run(name).animate(tmp_path / "moving.gif", seconds=0.2, fps=10)
    for figure, box in figures:
        width, height = figure.get_size_inches()
        assert box.x0 >= 0.0 and box.y0 >= 0.0 and box.x1 <= width and box.y1 <= height
    assert len(figures) == 4


def test_the_trail_of_a_fast_motion_has_no_corners():
    for span in ((0.0, 60.0), (60.0, 0.0)):
        run = satellite().solve(span, rtol=1e-9, atol=1e-9, dense_output=True)
        film = animate._film(run, 1.0, 30)  # 2 pictures a second of the orbit's ten turns
        x, y = np.array([scene.traced for scene in film.scenes]).T
        along = np.diff(np.unwrap(np.arctan2(y, x)))
        assert np.abs(along).max() < 0.2
        assert np.allclose(film.t[film.pictures], np.linspace(*span, 30), rtol=0.0, atol=1e-12)
