"""The command ``fastdyn sweep SYSTEM``: one system over ranges of its numbers."""

import dataclasses
import math
import time
from pathlib import Path

import numpy as np

from fastdyn.ensemble.reductions import NAMES
from fastdyn.words.numbers import table

from . import checks, commands

ROWS = 12  # of a table that is printed


def add_options(parser, system):
    """Teach a parser the numbers, each a value, a range or a list, and the options."""
    how = "one value, a range FROM:TO:COUNT with both ends, or a list A,B,C"
    commands.add_fields(parser, system, checks.values_of_unit, "VALUES", how)
    solver = parser.add_argument_group("solution and output")
    solver.add_argument("--reduce", nargs="+", default=["final"], choices=NAMES, metavar="WHAT",
                        help=f"what to gather: {', '.join(NAMES)}")  # fmt: skip
    commands.add_events(solver, system)
    commands.add_method(solver, system)
    solver.add_argument("--threads", type=checks.whole(1), metavar="N",
                        help="all processors unless given")  # fmt: skip
    solver.add_argument("--plot", metavar="FILE", type=checks.file(checks.FIGURES),
                        help="write the figure, .png, .pdf or .svg")  # fmt: skip
    solver.add_argument("--csv", metavar="FILE", type=checks.file(checks.TABLES),
                        help="write parameters, status and values")  # fmt: skip


def run(options):
    """Solve, print the results, and write the files; 1 if a trajectory failed."""
    system = options.system()
    given = commands.field_values(options)
    varied = {name: value for name, value in given.items() if np.ndim(value)}
    if not varied:
        raise ValueError("Give one parameter as a range, such as --g 1:10:100, or as a list.")
    size = np.prod([float(len(value)) for value in varied.values()])
    if size > checks.MOST_POINTS:
        raise ValueError(f"{size:.2g} trajectories are more than {checks.MOST_POINTS:.0e}.")
    axes = np.meshgrid(*varied.values(), indexing="ij")
    given |= {name: axis.ravel() for name, axis in zip(varied, axes, strict=True)}
    chosen = commands.solver_options(options) | commands.options_given(options, ("threads",))
    if events := commands.watched(options, system):
        chosen["events"] = events
    began = time.perf_counter()
    result = system.ensemble(
        (0.0, options.t_end), method=options.method, reduce=options.reduce, **chosen, **given
    )
    seconds = time.perf_counter() - began
    n = len(result)
    print(f"{system.title}: {n} trajectories, {options.method}, in {seconds:.2f} s.")
    columns = {name: given[name] for name in varied}
    for reduced in result.reduced:
        _tell(columns, reduced, _columns_of(system, result, reduced), result)
    _tell_failures(columns, result)
    if options.plot:
        from fastdyn import plot

        plot.save(result.plot(), options.plot)
    if options.csv:
        columns |= {"status": result.status, "t_end": result.t_end}
        for reduced in result.reduced:
            found = _columns_of(system, result, reduced)
            columns |= {f"{reduced} {name}": column for (name, _), column in found.items()}
        Path(options.csv).write_text(table(columns, grid=varied), encoding="utf-8")
    return 0 if result.success.all() else 1


def _columns_of(system, result, reduced):
    """{(name, unit): values} of a reduction."""
    values = result.reduced[reduced]
    if reduced == "first_event":
        names = [(name, "s") for name in result.event_names]
    else:
        time = result.is_time(reduced)
        names = [(state.name, "s" if time else state.unit) for state in system.states]
    return dict(zip(names, values.T, strict=True))


def _tell(varied, reduced, found, result):
    """A table of a reduction, and where its columns are largest and smallest."""
    n = len(result)
    heads = [*varied, *(f"{name} ({unit})" for name, unit in found)]
    print(f"{reduced.replace('_', ' ')}:")
    print("  " + " ".join(f"{head:>14}" for head in heads))
    rows = np.unique(np.linspace(0, n - 1, min(n, ROWS)).astype(int))
    for i in rows:
        cells = [f"{column[i]:>14.6g}" for column in varied.values()]
        if result.success[i]:
            cells += [_cell(column[i]) for column in found.values()]
        else:
            cells.append("  failed")
        print("  " + " ".join(cells))
    if len(rows) < n:
        print(f"  ({len(rows)} of {n} rows; --csv writes all)")
    for (name, unit), column in found.items():
        column = np.where(result.success & np.isfinite(column), column, np.nan)
        if not np.isnan(column).all():
            ends = [("largest", np.nanargmax(column)), ("smallest", np.nanargmin(column))]
            at = [_at(result.system, varied, i) for _, i in ends]
            said = [
                f"{word} {column[i]:.6g} {unit} at {place}"
                for (word, i), place in zip(ends, at, strict=True)
            ]
            print(f"  {name}: {'; '.join(said)}")


def _cell(value):
    return f"{value:>14.6g}" if np.isfinite(value) else f"{'none':>14}"


def _at(system, varied, i):
    """The values of a trajectory, of an angle also in degrees."""
    units = {one.name: one.metadata.get("unit") for one in dataclasses.fields(system)}
    said = []
    for name, column in varied.items():
        beside = f" ({math.degrees(column[i]):.6g}°)" if units[name] == "rad" else ""
        said.append(f"{name} = {column[i]:.6g}{beside}")
    return ", ".join(said)


def _tell_failures(varied, result):
    """Print the number of failed trajectories, and the reason of the first failure."""
    failed = np.flatnonzero(~result.success)
    if len(failed):
        i = failed[0]
        where = _at(result.system, varied, i)
        print(f"{len(failed)} of {len(result)} failed, the first at {where}: {result.message(i)}")
