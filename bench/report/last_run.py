"""The last run of each group on this machine, and the ratios of a new run to it.

A change that makes something slower shows in the run of whoever makes the change.
"""

import collections
import json
import math
import pathlib
import re
import statistics

from .equal_error import LEVELS, equal_error

LAST = pathlib.Path(__file__).parents[2] / ".benchmarks" / "last_run.json"
TIME = re.compile(r"(^|_)(us|ms|ns|s|seconds)(_|$)")
RATE = "a_second"
OURS = "fastdyn"
# Two quick runs of one tree on a busy machine of two cores: all 16 times of `fixed_cost` and 11 of
# the 14 of `linear_systems` were within this factor.
NOTED = 1.2
SHOWN = 8  # rows
NOT_WORDS = {"met", "target", "verdict", "nfev", "scipy_nfev", "accepted", "scipy_accepted",
             "steps", "compiled", "equal", "runs"}  # fmt: skip


def compared(group, record, path=LAST):
    """Lines that compare the rows of a group with those of its last run, which they replace.

    The times of other libraries say how the machine differs from then; fastdyn's times are judged
    beside these.
    """
    kept = json.loads(path.read_text()) if path.exists() else {}
    place = f"{record['machine']['cpu']}, {group}{', quick' * record['quick']}"
    before = kept.get(place)
    rows = record[group]
    kept[place] = {"date": record["date"], "rows": rows}
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(kept) + "\n")
    if before is None:
        return "no run of this group before, on this processor"
    return "\n".join(_ratios(before, rows))


def _ratios(before, rows):
    old = seconds_of(before["rows"])
    ratios = {True: {}, False: {}}
    for place, now in seconds_of(rows).items():
        if place in old:
            ratios[is_ours(place)][place] = now / old[place]
    ours, others = ratios[True], ratios[False]
    if not ours:
        return [f"nothing to compare with the run of {before['date']}"]
    machine = statistics.median(others.values()) if others else 1.0
    known = f", others {machine:.2f} ({len(others)})" if others else ""
    median = f"{statistics.median(ours.values()):.2f} of its time (median of {len(ours)})"
    yield f"beside the run of {before['date']}: fastdyn {median}{known}"
    judged = {place: ratio / machine for place, ratio in ours.items()}
    for word, sign in (("slower", 1), ("faster", -1)):
        found = [p for p, ratio in judged.items() if sign * math.log(ratio) > math.log(NOTED)]
        found.sort(key=judged.get, reverse=sign > 0)
        for *place, _ in found[:SHOWN]:
            yield f"  {word}: {judged[*place, _]:.2f}  {', '.join(filter(None, place))}"
        if len(found) > SHOWN:
            yield f"  and {len(found) - SHOWN} more are {word}"


def is_ours(place):
    """Whether a time is fastdyn's: so says its solver, or its column."""
    solver, _, column, _ = place
    library = column.rpartition("_")[0]
    return solver.startswith(OURS) if solver else library.startswith(OURS) or not library


def seconds_of(rows):
    """{(solver, other words of the row, column, how many alike came before): time in any unit}.

    Rows at several tolerances give the times at equal errors, of which tables consist.
    """
    if rows and {"tol", "min_us", "error", "solver"} <= rows[0].keys():
        return {
            (solver, f"{problem}, error {level:g}", "min_us", 0): us
            for problem, solvers in equal_error(rows).items()
            for solver, times in solvers.items()
            for level, us in zip(LEVELS, times, strict=True)
            if us
        }
    found = {}
    alike = collections.Counter()
    for row in rows:
        solver = str(row.get("solver") or row.get("tool") or "")
        words = [str(v) for k, v in row.items() if isinstance(v, str | int) and k not in NOT_WORDS]
        for column in _times(row):
            place = solver, ", ".join(w for w in words if w != solver), column
            value = row[column]
            found[*place, alike[place]] = 1.0 / value if column == RATE else value
            alike[place] += 1
    return found


def _times(row):
    """The columns with times that are judged: of a minimum and its like, the minimum alone."""
    found = [k for k, v in row.items() if (TIME.search(k) or k == RATE) and isinstance(v, float)]
    found = [k for k in found if row[k] > 0.0]
    least = [k for k in found if k.startswith("min_")]
    return least or [k for k in found if "median" not in k]
