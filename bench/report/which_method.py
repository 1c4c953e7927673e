"""``python -m bench.report.which_method``: the figure of `docs/which_method.md`."""

import json
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from fastdyn.plot.style import COLOURS, slides

from .table import RESULTS

ROOT = pathlib.Path(__file__).parents[2]
# Solver: colour, width, style, label.
LOOK = {
    "fastdyn Taylor": (COLOURS[1], 4.5, "-", "Taylor"),
    "fastdyn Vern9": (COLOURS[0], 2.5, "-", "Vern9"),
    "fastdyn Vern7": (COLOURS[5], 2.5, "-", "Vern7"),
    "fastdyn Tsit5": (COLOURS[4], 2.5, "-", "Tsit5"),
    "fastdyn Radau": (COLOURS[2], 4.5, "-", "Radau"),
    "fastdyn BDF": (COLOURS[2], 2.5, "--", "BDF"),
    "heyoka": ("0.25", 2.0, ":", "heyoka"),
    "SciPy DOP853": ("0.6", 2.0, "-", "SciPy, DOP853"),
    "SciPy Radau, njit": ("0.6", 2.0, "--", "SciPy, Radau"),
}
TITLES = {
    "satellite, e = 0.3": "Satellite",
    "pendulum, swinging": "Pendulum",
    "Lorenz": "Lorenz",
    "van der Pol": "Stiff: van der Pol, µ = 1000",
}
LEAST, MOST = 1e-13, 1e-1  # errors that are shown


def front(points):
    """Those that no other beats in both error and time, the coarsest first."""
    best, found = float("inf"), []
    for error, cost in sorted(points, key=lambda point: point[1]):
        if error < best:
            best = error
            found.append((error, cost))
    return found


def draw(rows, path):
    """A panel a problem, of one scale of time."""
    with slides():
        figure, panels = plt.subplots(
            2, 2, figsize=(12, 10), sharex=True, sharey=True, layout="constrained"
        )
        for axes, problem in zip(panels.flat, TITLES, strict=True):
            _panel(axes, problem, [row for row in rows if row["problem"] == problem])
        for axes in panels[:, 0]:
            axes.set_ylabel("time of a solve, lower is faster")
        for axes in panels[1]:
            axes.set_xlabel("achieved error, better to the right")
        entries = {}
        for axes in panels.flat:
            handles, labels = axes.get_legend_handles_labels()
            entries |= dict(zip(labels, handles, strict=True))
        named = [look[3] for look in LOOK.values() if look[3] in entries]
        figure.legend([entries[x] for x in named], named, loc="outside upper center", ncols=5)
        figure.savefig(path)
        plt.close(figure)


def _panel(axes, problem, rows):
    axes.set_title(TITLES[problem])
    for solver, (colour, width, line, label) in LOOK.items():
        points = front(
            (row["error"], row["min_us"] * 1e-6)
            for row in rows
            if row["solver"] == solver and LEAST < (row["error"] or 0.0) < MOST
        )
        if points:
            axes.loglog(
                *zip(*points, strict=True), color=colour, lw=width, ls=line, label=label,
                zorder=width, marker="o" if len(points) == 1 else None,
            )  # fmt: skip
    axes.set_xlim(MOST, LEAST)
    axes.set_ylim(1e-5, 1.0)
    axes.set_yticks([1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1], _TIMES)


_TIMES = ["10 µs", "0.1 ms", "1 ms", "10 ms", "0.1 s", "1 s"]


def main():
    """Draw it from the rows that ``python -m bench --only which_method --json ...`` kept."""
    source = RESULTS.with_name("which_method.json")
    draw(json.loads(source.read_text())["which_method"], ROOT / "docs" / "which_method.png")


if __name__ == "__main__":
    main()
