"""``python -m bench.report.stiff``: tables and figure of the stiff problems, from their rows."""

import json
import pathlib

from fastdyn.plot.style import COLOURS

from ..groups.stiff import LEVELS, PROBLEMS
from .equal_error import equal_error
from .panels import draw
from .table import PAGE, RESULTS, markdown, origin, put_in

FIGURE = pathlib.Path(__file__).parents[2] / "docs" / "stiff.png"
BEGIN, END = "<!-- stiff: begin -->\n", "<!-- stiff: end -->"
SAME = ("Radau", "BDF", "LSODA")
OURS = ("Radau", "BDF", "Rodas5P", "LSODA", "DOP853")
RIVALS = {"SciPy": "SciPy", "CVODE": "CVODE", "IDA": "CVODE", "diffrax": "Kvaerno5"}
SHORT = tuple(dict.fromkeys(RIVALS.values()))
SIZE = {given.problem.name: len(given.problem.y0) for given in PROBLEMS}
MIDDLE = 1  # of LEVELS: what the page shows
TITLES = {
    "Robertson": "Robertson, n = 3",
    "van der Pol": "van der Pol, n = 2",
    "HIRES": "HIRES, n = 8",
    "pollution": "Pollution, n = 20",
    "four balls": "Balls in contact, n = 8",
    "Brusselator, n = 200": "Brusselator, n = 200",
}
LOOK = {  # label: solvers, colour, width, style
    "Rodas5P": (["fastdyn Rodas5P"], COLOURS[1], 4.5, "-"),
    "Radau": (["fastdyn Radau"], COLOURS[2], 4.5, "-"),
    "BDF": (["fastdyn BDF"], COLOURS[0], 2.5, "-"),
    "LSODA": (["fastdyn LSODA"], COLOURS[4], 2.5, "-"),
    "CVODE": (["CVODE BDF, njit", "CVODE BDF, njit, exact Jacobian"], "0.25", 2.0, ":"),
    "diffrax, Kvaerno5": (["diffrax Kvaerno5"], "0.25", 2.0, "-."),
    "SciPy, Radau": (["SciPy Radau, njit"], "0.6", 2.0, "--"),
    "SciPy, LSODA": (["SciPy LSODA, njit"], "0.6", 2.0, "-"),
}


def _times(solvers, i):
    """({method: microseconds} of ours, {rival: (microseconds, solver)}) at level i."""
    ours, rivals = {}, {}
    for solver, times in solvers.items():
        library, _, method = solver.replace(",", "").partition(" ")
        if times[i] is None:
            continue
        if library == "fastdyn":
            ours[method.partition(" ")[0]] = times[i]
        elif library in RIVALS:
            name, found = RIVALS[library], (times[i], solver)
            rivals[name] = min(rivals.get(name, found), found)
    return ours, rivals


def _whole(microseconds):
    """Three digits, in groups."""
    if microseconds is None:
        return "-"
    return f"{float(f'{microseconds:.3g}'):,.0f}".replace(",", " ")


def at_level(reached, i):
    """The table of a level, and a sentence with what is not the fastest there."""
    body, lost, n_compared = [], [], 0
    for problem, solvers in reached.items():
        ours, rivals = _times(solvers, i)
        best = min(ours, key=ours.get) if ours else None
        fastest = min(rivals.values()) if rivals else None
        verdict = "-"
        if best and fastest:
            ratio = ours[best] / fastest[0]
            verdict = f"{ratio:.{2 if ratio > 0.1 else 3}f} of {fastest[1]}"
            n_compared += 1
            if ratio > 1.0:
                lost.append(f"{problem} ({ratio:.2f} times {fastest[1]})")
        cells = [
            f"**{_whole(ours[name])}**" if name == best else _whole(ours.get(name)) for name in OURS
        ]
        others = [_whole(rivals[name][0]) if name in rivals else "-" for name in SHORT]
        slower = f"{rivals['SciPy'][0] / ours[best]:.0f}" if best and "SciPy" in rivals else "-"
        body.append([problem, str(SIZE[problem]), *cells, *others, slower, verdict])
    head = ["problem", "n", *OURS, *SHORT, "SciPy over fastdyn", "fastdyn over the fastest rival"]
    said = f"Fastest in {n_compared - len(lost)} of the {n_compared} that a rival reaches"
    said += f"; not on {', '.join(lost)}." if lost else "."
    return [*markdown(head, body), "", said]


def same_method(reached, i):
    """SciPy's time over fastdyn's by the same method, at level i."""
    body = []
    for problem, solvers in reached.items():
        ours, _ = _times(solvers, i)
        cells = []
        for name in SAME:
            theirs = solvers.get(f"SciPy {name}, njit", [None] * len(LEVELS))[i]
            known = theirs is not None and name in ours
            cells.append(_whole(theirs / ours[name]) if known else "-")
        if set(cells) != {"-"}:
            body.append([problem, str(SIZE[problem]), *cells])
    return markdown(["problem", "n", *SAME], body)


def for_page(record):
    """What the page of the documentation shows."""
    reached = equal_error(record["stiff"], LEVELS)
    return [
        f"Error {LEVELS[MIDDLE]:g}, microseconds:", "", *at_level(reached, MIDDLE), "",
        "SciPy's time over fastdyn's by the same method, at that error:", "",
        *same_method(reached, MIDDLE), "",
        origin(record),
    ]  # fmt: skip


def whole(record):
    """What lies beside the result file."""
    reached = equal_error(record["stiff"], LEVELS)
    lines = ["# Stiff problems", "", origin(record), ""]
    lines += [
        "Made by `python -m bench.report.stiff`, in microseconds at equal achieved error.",
        "",
    ]
    for i, level in enumerate(LEVELS):
        lines += [f"## Error {level:g}", "", *at_level(reached, i), ""]
    lines += ["## All solvers", ""]
    for problem, solvers in reached.items():
        head = ["solver", *(f"error {level:g}" for level in LEVELS)]
        body = [[name, *map(_whole, times)] for name, times in solvers.items()]
        lines += [f"### {problem}", "", *markdown(head, body), ""]
    return lines


def main():
    """Write the tables, and draw the figure."""
    source = RESULTS.with_name("stiff.json")
    record = json.loads(source.read_text())
    source.with_suffix(".md").write_text("\n".join(whole(record)))
    put_in(PAGE, BEGIN, END, for_page(record))
    draw(record["stiff"], FIGURE, TITLES, LOOK, 3, (1.0, 1e-11))


if __name__ == "__main__":
    main()
