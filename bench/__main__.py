"""``python -m bench``: tables on the screen, everything in a JSON file."""

import argparse
import datetime
import json
import pathlib

from . import course, drift, first_call, fixed_cost, memory, same_steps, scaling, speed
from .timing import machine

GROUPS = {
    "same_steps": same_steps,
    "speed": speed,
    "course": course,
    "drift": drift,
    "fixed_cost": fixed_cost,
    "first_call": first_call,
    "scaling": scaling,
    "memory": memory,
}


def _text(value):
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "NO"
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def show(rows):
    """Print rows of one kind as a table."""
    table = [list(rows[0]), *([_text(v) for v in row.values()] for row in rows)]
    widths = [max(len(line[i]) for line in table) for i in range(len(table[0]))]
    for line in table:
        print("  ".join(cell.ljust(w) for cell, w in zip(line, widths, strict=True)).rstrip())


def main():
    """Run the groups that are asked for."""
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a smoke run")
    parser.add_argument("--only", nargs="+", choices=GROUPS, default=list(GROUPS))
    parser.add_argument("--json", type=pathlib.Path, help="where the figures go")
    options = parser.parse_args()
    today = datetime.date.today().isoformat()
    path = options.json or pathlib.Path(__file__).with_name("results") / f"{today}.json"
    record = {"date": today, "machine": machine(), "quick": options.quick}
    print(record["machine"])
    for name in options.only:
        record[name] = list(GROUPS[name].rows(options.quick))
        print(f"\n{name}: {GROUPS[name].__doc__.splitlines()[0]}")
        if record[name]:
            show(record[name])
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(record, indent=1))
    print(f"\nwritten to {path}")


if __name__ == "__main__":
    main()
