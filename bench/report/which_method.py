"""``python -m bench.report.which_method``: the figure of `docs/which_method.md`."""

import json
import pathlib

from fastdyn.plot.style import COLOURS

from .panels import draw
from .table import RESULTS

ROOT = pathlib.Path(__file__).parents[2]
LOOK = {  # label: solvers, colour, width, style
    "Taylor": (["fastdyn Taylor"], COLOURS[1], 4.5, "-"),
    "Vern9": (["fastdyn Vern9"], COLOURS[0], 2.5, "-"),
    "Vern7": (["fastdyn Vern7"], COLOURS[5], 2.5, "-"),
    "Tsit5": (["fastdyn Tsit5"], COLOURS[4], 2.5, "-"),
    "Radau": (["fastdyn Radau"], COLOURS[2], 4.5, "-"),
    "BDF": (["fastdyn BDF"], COLOURS[2], 2.5, "--"),
    "heyoka": (["heyoka"], "0.25", 2.0, ":"),
    "SciPy, DOP853": (["SciPy DOP853"], "0.6", 2.0, "-"),
    "SciPy, Radau": (["SciPy Radau, njit"], "0.6", 2.0, "--"),
}
TITLES = {
    "satellite, e = 0.3": "Satellite",
    "pendulum, swinging": "Pendulum",
    "Lorenz": "Lorenz",
    "van der Pol": "Stiff: van der Pol, µ = 1000",
}


def main():
    """Draw it from the rows that ``python -m bench --only which_method --json ...`` kept."""
    rows = json.loads(RESULTS.with_name("which_method.json").read_text())["which_method"]
    draw(rows, ROOT / "docs" / "which_method.png", TITLES, LOOK, 2, (1e-1, 1e-13))


if __name__ == "__main__":
    main()
