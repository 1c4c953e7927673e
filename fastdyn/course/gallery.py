"""The figures of the tour as a page, with a moving picture of every system."""

import math
from pathlib import Path
from typing import Any

from fastdyn.plot.needed import needed
from fastdyn.systems import SYSTEMS

from . import tour

PAGE = "README.md"
SECONDS, FPS = 4.0, 10  # of a moving picture
MOVING: dict[str, Any] = {  # what to show of a system, where that is not its default run
    "building": ({}, {"t_span": (0.0, 8.0)}),
    "cable": ({"V0": math.sqrt(3.5 * 9.81)}, {}),
    "pendulum": ({"V0": 5.0}, {"t_span": (0.0, 4.0)}),
    "pendulum_xy": ({"V0": 4.0}, {"t_span": (0.0, 4.0)}),
    "satellite": ({"V": 1.2}, {"t_span": (0.0, 30.0)}),
    "vehicle": ({}, {"t_span": (0.0, 60.0)}),
}


def build(folder="docs/gallery", write=print):
    """
    Run the tour into a folder and write the page `PAGE` beside the figures.

    Returns
    -------
    tour.Board
    """
    matplotlib = needed("matplotlib")

    board = tour.run(folder, write=write)
    lines = [
        "# Gallery",
        "",
        "Every figure of `fastdyn tour`, in the order of the course, and a moving picture of every",
        "system. The page and its pictures are written by `fastdyn gallery`; a test compares them",
        "with pictures of the current code.",
    ]
    for (name, system), (heading, figures) in zip(SYSTEMS.items(), board.sections, strict=True):
        lines += ["", f"## {heading}", "", f"`fastdyn.systems.{name}`, {system.source}."]
        for path in figures:
            _shrink(path)
            lines += ["", f"![{path.stem}]({path.name})"]
        path = Path(folder, f"{name}.gif")
        moving_run(name).animate(path, seconds=SECONDS, fps=FPS)
        write(f"  {path.name}")
        lines += ["", f"![{name}, moving]({path.name})"]
    lines += ["", f"Drawn by matplotlib {matplotlib.__version__}."]
    Path(folder, PAGE).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return board


def moving_run(name):
    """The run of a system that its moving picture shows."""
    fields, options = MOVING.get(name, ({}, {}))
    system = SYSTEMS[name]
    if "ground" in system.events:
        options = options | {"events": "ground"}
    return system(**fields).solve(**{"dense_output": True} | options)


def _shrink(path):
    """A figure with few colours, a third of its size."""
    from PIL import Image

    with Image.open(path) as image:
        small = image.convert("RGB").quantize(96)
    small.save(path, optimize=True)
