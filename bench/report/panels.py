"""Diagrams of time against achieved error, a panel a problem, of one scale."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from fastdyn.plot.style import slides

TIMES = ["10 µs", "0.1 ms", "1 ms", "10 ms", "0.1 s", "1 s"]


def front(points):
    """Those that no other beats in both error and time, the coarsest first."""
    best, found = float("inf"), []
    for error, cost in sorted(points, key=lambda point: point[1]):
        if error < best:
            best = error
            found.append((error, cost))
    return found


def draw(rows, path, titles, look, n_columns, errors):
    """Draw a file.

    Parameters
    ----------
    rows : list of dict
        As `report.work_precision` has them.
    path : path-like
    titles : dict of str to str
        Of the panels, by problem.
    look : dict
        {label: (solvers, colour, width, style)} of the lines; that of several solvers is the best
        of them.
    n_columns : int
    errors : (float, float)
        The largest and the least that are shown.
    """
    n_rows = len(titles) // n_columns
    with slides():
        figure, panels = plt.subplots(
            n_rows, n_columns, figsize=(5 * n_columns + 2, 5 * n_rows), sharex=True, sharey=True,
            layout="constrained",
        )  # fmt: skip
        for axes, problem in zip(panels.flat, titles, strict=True):
            axes.set_title(titles[problem])
            _panel(axes, [row for row in rows if row["problem"] == problem], look, errors)
        for axes in panels[:, 0]:
            axes.set_ylabel("time of a solve, lower is faster")
        for axes in panels[-1]:
            axes.set_xlabel("achieved error, better to the right")
        entries = {}
        for axes in panels.flat:
            handles, labels = axes.get_legend_handles_labels()
            entries |= dict(zip(labels, handles, strict=True))
        named = [label for label in look if label in entries]
        lines = [entries[label] for label in named]
        figure.legend(lines, named, loc="outside upper center", ncols=5)
        figure.savefig(path)
        plt.close(figure)


def _panel(axes, rows, look, errors):
    most, least = errors
    for label, (solvers, colour, width, style) in look.items():
        points = front(
            (row["error"], row["min_us"] * 1e-6)
            for row in rows
            if row["solver"] in solvers and least < (row["error"] or 0.0) < most
        )
        if points:
            axes.loglog(
                *zip(*points, strict=True), color=colour, lw=width, ls=style, label=label,
                zorder=width, marker="o" if len(points) == 1 else None,
            )  # fmt: skip
    axes.set_xlim(most, least)
    axes.set_ylim(3e-6, 1.0)
    axes.set_yticks([1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1], TIMES)
