"""``python -m bench``: tables on the screen, everything in a JSON file."""

import argparse
import datetime
import itertools
import json
import pathlib
import time

import bench.one_thread  # noqa: F401  before all that follow

from .groups import (
    corpus,
    course,
    dae,
    delays,
    derive,
    drift,
    ensemble,
    first_call,
    fixed_cost,
    gradients,
    hard_cases,
    hybrid,
    linear_systems,
    long_run,
    long_states,
    many_daes,
    memory,
    noise,
    pages,
    planets,
    same_steps,
    scaling,
    speed,
    stiff,
    switches,
    tolerance,
    which_method,
    work_precision,
)
from .report import figures, last_run
from .report.environment import load, machine
from .report.table import RESULTS

GROUPS = {
    "same_steps": same_steps,
    "work_precision": work_precision,
    "speed": speed,
    "course": course,
    "fixed_cost": fixed_cost,
    "first_call": first_call,
    "scaling": scaling,
    "ensemble": ensemble,
    "drift": drift,
    "long_run": long_run,
    "planets": planets,
    "linear_systems": linear_systems,
    "hard_cases": hard_cases,
    "memory": memory,
    "long_states": long_states,
    "stiff": stiff,
    "switches": switches,
    "tolerance": tolerance,
    "dae": dae,
    "many_daes": many_daes,
    "delays": delays,
    "noise": noise,
    "gradients": gradients,
    "hybrid": hybrid,
    "which_method": which_method,
    "corpus": corpus,
    "derive": derive,
    "pages": pages,
}


WIDEST = 120  # characters of a cell
DIGITS = 6  # of a number in a file


def _text(value):
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "NO"
    return f"{value:.3g}" if isinstance(value, float) else str(value)[:WIDEST]


def show(rows):
    """Print rows as tables, one for each run of rows with the same names."""
    for names, alike in itertools.groupby(rows, list):
        table = [names, *([_text(v) for v in row.values()] for row in alike)]
        widths = [max(map(len, column)) for column in zip(*table, strict=True)]
        for line in table:
            print("  ".join(cell.ljust(w) for cell, w in zip(line, widths, strict=True)).rstrip())


def rounded(found):
    """A record whose numbers have no more digits than a measurement."""
    if isinstance(found, dict):
        return {name: rounded(value) for name, value in found.items()}
    if isinstance(found, list | tuple):
        return [rounded(value) for value in found]
    return float(f"{found:.{DIGITS}g}") if isinstance(found, float) else found


def keep(record, path):
    """Write what there is to the file, if there is one."""
    if path is not None:
        path.write_text(json.dumps(rounded(record), indent=1) + "\n")


def main():
    """Run the groups that are asked for; keep a full run, and draw its figures."""
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a smoke run")
    parser.add_argument("--only", nargs="+", choices=GROUPS, default=list(GROUPS))
    parser.add_argument("--json", type=pathlib.Path, help="where the figures of a part go")
    parser.add_argument("--into", type=pathlib.Path, help="a file in which groups are replaced")
    options = parser.parse_args()
    full = not options.quick and options.only == list(GROUPS)
    record = {
        "date": datetime.date.today().isoformat(),
        "quick": options.quick,
        "machine": machine(),
        "load": {},
        "seconds": {},
    }
    print(json.dumps(record["machine"], indent=1))
    path = options.into or options.json or (RESULTS if full else None)
    if options.into is not None:
        now, record = record, json.loads(path.read_text())
        elsewhere = record.setdefault("replaced", {})
        elsewhere |= {name: {k: now[k] for k in ("date", "machine")} for name in options.only}
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
    for name in options.only:
        record["load"][name] = load()
        begun = time.perf_counter()
        record[name] = []
        for row in GROUPS[name].rows(options.quick):
            if record[name] and row.get("problem") != record[name][-1].get("problem"):
                keep(record, path)  # also what is not complete
            record[name].append(row)
        record["seconds"][name] = time.perf_counter() - begun
        doc = GROUPS[name].__doc__.splitlines()[0]
        print(f"\n{name}: {doc} ({record['seconds'][name]:.0f} s)")
        if record[name]:
            show(record[name])
            if hasattr(GROUPS[name], "summary"):
                print(GROUPS[name].summary(record[name]))
            print(last_run.compared(name, record))
        keep(record, path)
    if full:
        figures.draw_all(record["work_precision"], path.parent)


if __name__ == "__main__":
    main()
