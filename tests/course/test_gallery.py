"""The gallery: its page, and that its pictures are those of the present code."""

import pathlib
import re

import matplotlib
import numpy as np
import pytest
from matplotlib import animation
from PIL import Image

from fastdyn.cli.main import main
from fastdyn.course import gallery, tour
from fastdyn.systems import SYSTEMS

FOLDER = pathlib.Path(__file__).parents[2] / "docs" / "gallery"
DIFFERENT = 64  # levels of grey between two pixels that are not the same
SHARE = 4e-3  # of the pixels that may differ: edges, and lines at the level of rounding
ROUNDING = {"satellite-long.png"}  # mostly such lines


def page(folder=FOLDER):
    return (folder / gallery.PAGE).read_text("utf-8")


def pixels(path, frame=0):
    with Image.open(path) as image:
        image.seek(frame)
        return np.asarray(image.convert("L"), float)


def same(a, b):
    return a.shape == b.shape and np.mean(np.abs(a - b) > DIFFERENT) <= SHARE


@pytest.mark.hunt
def test_the_command_writes_the_page(tmp_path, monkeypatch, capsys):
    few = {name: SYSTEMS[name] for name in ("projectile", "rod")}
    monkeypatch.setattr(tour, "SYSTEMS", few)
    monkeypatch.setattr(gallery, "SYSTEMS", few)
    monkeypatch.setattr(gallery, "SECONDS", 0.3)
    assert main(["gallery", "--out", str(tmp_path)]) == 0
    text = page(tmp_path)
    named = re.findall(r"\]\((.*?)\)", text)
    assert sorted([*named, gallery.PAGE]) == sorted(path.name for path in tmp_path.iterdir())
    assert named == ["projectile.png", "projectile.gif", "rod.png", "rod-friction.png", "rod.gif"]
    assert "## Block on a rotating rod" in text and "rod.gif" in capsys.readouterr().out


@pytest.mark.hunt
def test_the_gallery_is_that_of_the_present_code(told, tmp_path, monkeypatch):
    """The same figures in the same order, and the same pictures where matplotlib is the same."""
    board = told[2]
    expected = []
    for name, (heading, figures) in zip(SYSTEMS, board.sections, strict=True):
        expected += [heading, *(path.name for path in figures), f"{name}.gif"]
    found = re.findall(r"^## (.*)$|\]\((.*?)\)", page(), re.MULTILINE)
    assert [a or b for a, b in found] == expected
    if f"matplotlib {matplotlib.__version__}." not in page():
        pytest.skip("drawn by another matplotlib")
    drawn = [path for path in board.figures if path.name not in ROUNDING]
    stale = [p.name for p in drawn if not same(pixels(p), pixels(FOLDER / p.name))]
    whole = animation.FuncAnimation
    monkeypatch.setattr(animation, "FuncAnimation", lambda f, show, n, **how: whole(f, show, 1))
    for name in SYSTEMS:
        options = {"seconds": gallery.SECONDS, "fps": gallery.FPS}
        gallery.moving_run(name).animate(tmp_path / "first.gif", **options)
        if not same(pixels(tmp_path / "first.gif"), pixels(FOLDER / f"{name}.gif")):
            stale.append(f"{name}.gif")
    assert not stale, "run `fastdyn gallery`"
