"""``python -m bench.report.table``: tables of a result file, into README, docs/ and beside it."""

import argparse
import json
import pathlib

from .equal_error import LEVELS, equal_error

HERE = pathlib.Path(__file__).parents[1]
RESULTS = HERE / "results" / "full.json"
README = HERE.parent / "README.md"
PAGE = HERE.parent / "docs" / "benchmarks.md"
BEGIN, END = "<!-- bench: begin -->\n", "<!-- bench: end -->"
SAME = {  # the same method by different hands: {title: (level, solvers)}
    "The Dormand-Prince pair of order 5": (
        0, ["fastdyn RK45", "C++ RK45", "CyRK RK45", "diffrax Dopri5", "SciPy RK45, njit"]
    ),
    "The pair of order 8 (diffrax: another one)": (
        1, ["fastdyn DOP853", "C++ DOP853", "CyRK DOP853", "diffrax Dopri8",
            "Hairer's DOP853, njit"],
    ),
}  # fmt: skip
FAMILIES = ("fastdyn", "C++", "SciPy", "Hairer's", "CyRK", "numbalsoda", "heyoka", "diffrax",
            "CVODES", "CVODE", "REBOUND")  # fmt: skip
OF_README = (  # the problems of the README, and its columns: {head: libraries}
    ("satellite, e = 0.3", "projectile with drag", "pendulum, swinging", "building",
     "constrained pendulum", "vehicle"),
    {"fastdyn": ("fastdyn",), "C++ by hand": ("C++",), "CyRK": ("CyRK",), "heyoka": ("heyoka",),
     "diffrax": ("diffrax",), "SciPy": ("SciPy", "Hairer's")},
)  # fmt: skip
MIDDLE = 1  # of LEVELS: what the README shows


def number(value):
    """Three digits, "-" for None."""
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    if value == 0 or 1e-2 <= abs(value) < 1e5:
        digits = 0 if abs(value) >= 100 else 1 if abs(value) >= 10 else 2
        return f"{value:.{digits}f}".replace("inf", "-")
    return f"{value:.1e}"


def markdown(head, rows):
    """Lines of a table."""
    lines = [head, ["---"] * len(head), *([number(value) for value in row] for row in rows)]
    return ["| " + " | ".join(line) + " |" for line in lines]


def family(solver):
    """The library of a solver."""
    return next((name for name in FAMILIES if solver.startswith(name)), solver)


def best(solvers, i):
    """{library: (microseconds, solver)} at level i, of those that reach it."""
    found = {}
    for name, times in solvers.items():
        if times[i] is not None:
            found[family(name)] = min(found.get(family(name), (times[i], name)), (times[i], name))
    return found


def at_equal_error(rows):
    """A table a level: the best method of each library, and fastdyn over the best of the rivals."""
    lines = []
    reached = equal_error(rows)
    shown = [f for f in FAMILIES if any(family(row["solver"]) == f for row in rows)]
    for i, level in enumerate(LEVELS):
        body, first = [], 0
        for problem, solvers in reached.items():
            found = best(solvers, i)
            mine = found.get("fastdyn")
            others = [pair for name, pair in found.items() if name not in ("fastdyn", "C++")]
            first += bool(mine and (not others or mine < min(others)))
            verdict = "-"
            if mine and others:
                verdict = f"{mine[0] / min(others)[0]:.2g} of {min(others)[1]}"
            method = mine[1].removeprefix("fastdyn ") if mine else "-"
            cells = [found[name][0] if name in found else None for name in shown]
            body.append([problem, method, *cells, verdict])
        head = ["problem", "method", *shown, "fastdyn over the fastest library"]
        title = f"Error {level:g}, microseconds; fastdyn is the fastest library in {first} of "
        lines += [f"{title}{len(reached)}:", "", *markdown(head, body), ""]
    return lines


def same_method(rows):
    """A table a method: microseconds by different hands, at an equal error."""
    reached, lines = equal_error(rows), []
    for title, (i, names) in SAME.items():
        names = [name for name in names if any(name in solvers for solvers in reached.values())]
        body = []
        for problem, solvers in reached.items():
            times = [solvers[name][i] if name in solvers else None for name in names]
            if times[0] is not None:
                body.append([problem, *times])
        lines += [f"{title}, error {LEVELS[i]:g}, microseconds:", ""]
        lines += [*markdown(["problem", *names], body), ""]
    return lines


def every_solver(rows):
    """All solvers at all levels, a table a problem."""
    lines = []
    for problem, solvers in equal_error(rows).items():
        head = ["solver", *(f"error {level:g}" for level in LEVELS)]
        body = [[name, *times] for name, times in solvers.items()]
        lines += [f"### {problem}", "", *markdown(head, body), ""]
    return lines


def pivot(rows, key, column, value):
    """A table with a line for each `key` and a column for each value of `column`."""
    columns = list(dict.fromkeys(row[column] for row in rows))
    cells = {}
    for row in rows:
        cells.setdefault(row[key], {})[row[column]] = row[value]
    body = [[name, *(line.get(c) for c in columns)] for name, line in cells.items()]
    return markdown([key, *map(str, columns)], body)


def first_call(record):
    """Median seconds."""
    return [
        "The first answer, seconds from the start of the process, medians; a new machine has no "
        "files of any cache:", "", *pivot(record["first_call"], "solver", "what", "median_s"), "",
        *_of_another_run(record, "first_call"),
    ]  # fmt: skip


def ensemble(record):
    """Trajectories a second."""
    return [
        "Trajectories a second (satellite to t = 100, building to t = 20, rtol 1e-6):", "",
        *pivot(record["ensemble"], "solver", "problem", "a_second"), "",
        *_of_another_run(record, "ensemble"),
    ]  # fmt: skip


def _of_another_run(record, group):
    """Where the numbers of a group are from, if the group is of another run."""
    return [origin(record, group), ""] if group in record.get("replaced", {}) else []


def drift(rows):
    """All rows."""
    names = ("e", "solver", "us_an_orbit", *(f"energy_1e{k}" for k in range(2, 6)), "phase")
    head = ["e", "solver", "µs an orbit", *(f"energy, 10^{k}" for k in range(2, 6)), "phase (s)"]
    return markdown(head, [[row[name] for name in names] for row in rows])


def scaling(rows):
    """A table a family of problems."""
    lines = []
    for against in dict.fromkeys(row["against"] for row in rows):
        mine = [row for row in rows if row["against"] == against]
        lines += [f"Nanoseconds each of {against}:", "", *pivot(mine, "solver", "size", "ns_each")]
        lines.append("")
    return lines


def origin(record, replaced=None):
    """Where the numbers are from, or those of a group that was replaced since."""
    others = record.get("replaced", {})
    own = record if replaced is None else others[replaced]
    m = own["machine"]
    versions = ", ".join(f"{name} {v}" for name, v in m["versions"].items() if v)
    groups = [g for g in record["load"] if g == replaced or (replaced is None and g not in others)]
    loads = ", ".join(f"{name} {record['load'][name]:.1f}" for name in groups)
    return (
        f"{own['date']}, {m['cpu']}, {m['cores']} cores, {m['threads']} thread a solver; "
        f"load at the start of each group: {loads}. Versions: {versions}."
    )


def for_page(record):
    """What the page of the documentation shows."""
    return [
        *same_method(record["work_precision"]),
        *at_equal_error(record["work_precision"]),
        *first_call(record),
        "A solve of thirty steps, and one with a thousand outputs, microseconds:", "",
        *pivot(record["fixed_cost"], "solver", "output", "min_us"), "",
        *ensemble(record),
        origin(record),
    ]  # fmt: skip


def for_readme(record):
    """The table of the README."""
    problems, columns = OF_README
    reached = equal_error(record["work_precision"])
    body = []
    for problem in problems:
        found = best(reached[problem], MIDDLE)
        times = [
            min((found[name][0] for name in names if name in found), default=None)
            for names in columns.values()
        ]
        body.append([problem, *("-" if us is None else f"{us:.0f}" for us in times)])
    level = f"{LEVELS[MIDDLE]:.0e}".replace("e-0", "e-")
    said = f"Time of a solve in microseconds, at an achieved error of {level}, on one thread"
    return [
        f"{said} ({record['machine']['cpu']}, {record['date']}):", "",
        *markdown(["problem", *columns], body),
    ]  # fmt: skip


def whole(record):
    """What lies beside the result file."""
    return [
        "# Tables of the full run", "", origin(record), "",
        "Made by `python -m bench.report.table`; [bench/README.md](../README.md) says what they "
        "mean.",
        "",
        "## Time at equal achieved error, microseconds", "",
        *every_solver(record["work_precision"]),
        "## Scaling", "", *scaling(record["scaling"]),
        "## Trajectories a second, and the median of their errors", "",
        *pivot(record["ensemble"], "solver", "problem", "a_second"), "",
        *pivot(record["ensemble"], "solver", "problem", "median_error"), "",
        "## Long runs", "", *drift(record["drift"]),
    ]  # fmt: skip


def put_in(page, begin, end, lines):
    """Put lines in the place of what is between two marks of a page."""
    before, _, rest = page.read_text().partition(begin)
    part = "\n".join(["", *lines, "", ""])
    page.write_text(before + begin + part + end + rest.partition(end)[2])


def put_group(name, summary, page="benchmarks.md"):
    """Write the table of a group that has a file of results of its own into a page."""
    record = json.loads(RESULTS.with_name(f"{name}.json").read_text())
    lines = ["Microseconds:", "", summary(record[name]), "", origin(record)]
    put_in(PAGE.with_name(page), f"<!-- {name}: begin -->\n", f"<!-- {name}: end -->", lines)


def main():
    """Write all three."""
    parser = argparse.ArgumentParser(prog="python -m bench.report.table", description=__doc__)
    parser.add_argument("json", nargs="?", type=pathlib.Path, default=RESULTS)
    path = parser.parse_args().json
    record = json.loads(path.read_text())
    path.with_name("tables.md").write_text("\n".join(whole(record)) + "\n")
    put_in(PAGE, BEGIN, END, for_page(record))
    put_in(README, BEGIN, END, for_readme(record))


if __name__ == "__main__":
    main()
