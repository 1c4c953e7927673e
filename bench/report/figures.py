"""``python -m bench.report.figures``: a work-precision diagram a problem, from a result file."""

import argparse
import json
import pathlib
import re

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from .table import RESULTS

# Colour by library, marker by method; what is not named here is drawn in grey.
COLOURS = {
    "fastdyn": "C3", "C++": "black", "SciPy": "C0", "Hairer's": "C9", "CyRK": "C1",
    "numbalsoda": "C8", "heyoka": "C2", "diffrax": "C4", "CVODE": "C5", "REBOUND": "C6",
}  # fmt: skip
MARKERS = {
    "RK45": "o", "Dopri5": "o", "DOP853": "s", "Dopri8": "s", "Tsit5": "^", "Vern7": "D",
    "Vern8": "P", "Vern9": "X", "LSODA": "v", "odeint": "<", "Adams": "v", "IAS15": "*", "BS": "h",
    "Taylor": "p", "fast_math": "d",
}  # fmt: skip
PLAIN = ("SciPy RK45", "SciPy DOP853", "SciPy LSODA", "fastdyn RK45 by solve_ivp")  # dotted


def style(solver):
    """Colour, marker and line of a solver."""
    library, _, method = solver.replace(",", "").partition(" ")
    first = (method or "-").split()[0]
    ours = library == "fastdyn"
    return {
        "color": COLOURS.get(library, "0.6"),
        "marker": MARKERS.get(first, "x"),
        "lw": 2.0 if ours else 1.2,
        "ms": 6 if ours else 4.5,
        "ls": ":" if solver in PLAIN else "-",
        "zorder": 3 if ours else 2,
    }


def draw(problem, rows, path):
    """Error to the right is less: the lower and the further right, the better."""
    figure, axes = plt.subplots(figsize=(11, 6.5))
    solvers = dict.fromkeys(row["solver"] for row in rows)
    for solver in solvers:
        points = [
            (row["error"], row["min_us"] * 1e-6)
            for row in rows
            if row["solver"] == solver and row["error"] and row["error"] < 1.0
        ]
        if points:
            axes.loglog(*zip(*points, strict=True), label=solver, **style(solver))
    axes.invert_xaxis()
    axes.set_xlabel("achieved error, relative to the state (better to the right)")
    axes.set_ylabel("time of a solve (s)")
    axes.set_title(f"{problem[0].upper()}{problem[1:]}: time against error; lower is faster")
    axes.grid(which="major", alpha=0.4)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=9, frameon=False)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def file_name(problem):
    """The figure's file name."""
    plain = problem.lower().replace("é", "e")
    return re.sub(r"[^a-z0-9]+", "_", plain).strip("_") + ".png"


def main():
    """Draw them all beside the result file."""
    parser = argparse.ArgumentParser(prog="python -m bench.report.figures", description=__doc__)
    parser.add_argument("json", nargs="?", type=pathlib.Path, default=RESULTS)
    path = parser.parse_args().json
    draw_all(json.loads(path.read_text())["work_precision"], path.parent)


def draw_all(rows, folder):
    """One file a problem."""
    for problem in dict.fromkeys(row["problem"] for row in rows):
        mine = [row for row in rows if row["problem"] == problem]
        draw(problem, mine, folder / file_name(problem))


if __name__ == "__main__":
    main()
