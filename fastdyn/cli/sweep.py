"""The command ``fastdyn sweep SYSTEM``: one system over ranges of its numbers."""

import dataclasses
import time

import numpy as np

from fastdyn.ensemble.reductions import NAMES


def add_options(parser, system, numbers):
    """Teach a parser the numbers, each a value, a range or a list, and the options."""
    for heading, fields in numbers.items():
        how = "one value, a range FROM:TO:COUNT with both ends, or a list A,B,C"
        group = parser.add_argument_group(heading, how)
        for field in fields:
            about = field.metadata
            text = f"{about['meaning']} ({about['unit']}), default {field.default:g}"
            group.add_argument(f"--{field.name}", metavar="VALUES", help=text)
    solver = parser.add_argument_group("solution and output")
    solver.add_argument("--reduce", nargs="+", default=["final"], choices=NAMES, metavar="WHAT",
                        help=f"what to gather: {', '.join(NAMES)}")  # fmt: skip
    solver.add_argument("--events", nargs="+", metavar="EVENT", help="events of the system")
    solver.add_argument("--t-end", type=float, default=system.t_end, help="end of each run (s)")
    solver.add_argument("--method", default="RK45", help="RK45, DOP853, RK4 ...")
    solver.add_argument("--rtol", type=float, help="relative tolerance, default 1e-6")
    solver.add_argument("--atol", type=float, help="absolute tolerance, default 1e-9")
    solver.add_argument("--step", type=float, help="step (s) of methods with constant steps")
    solver.add_argument("--threads", type=int, help="all processors unless given")
    solver.add_argument("--plot", metavar="FILE", help="write the figure, .png, .pdf or .svg")
    solver.add_argument("--csv", metavar="FILE", help="write parameters, status and values")


def values(text):
    """The numbers that ``8.7``, ``1:30:10000`` or ``1,2,5`` stand for."""
    try:
        if ":" in text:
            first, last, count = text.split(":")
            return np.linspace(float(first), float(last), int(count))
        numbers = np.array([float(word) for word in text.split(",")])
    except ValueError:
        raise ValueError(
            f"{text!r} is neither a number, nor a range FROM:TO:COUNT, nor a list A,B,C."
        ) from None
    return numbers if len(numbers) > 1 else float(numbers[0])


def run(options):
    """Solve, tell what came out, and write the files; 1 if a trajectory failed."""
    system = options.system()
    fields = [field.name for field in dataclasses.fields(system)]
    texts = {name: getattr(options, name, None) for name in fields}
    given = {name: values(text) for name, text in texts.items() if text is not None}
    varied = {name: value for name, value in given.items() if np.ndim(value)}
    if not varied:
        raise ValueError("Give one parameter as a range, such as --omega 1:30:10000.")
    axes = np.meshgrid(*varied.values(), indexing="ij")
    given |= {name: axis.ravel() for name, axis in zip(varied, axes, strict=True)}
    named = ("method", "rtol", "atol", "step", "threads", "events")
    chosen = {name: getattr(options, name) for name in named if getattr(options, name) is not None}
    began = time.perf_counter()
    result = system.ensemble((0.0, options.t_end), reduce=options.reduce, **chosen, **given)
    seconds = time.perf_counter() - began
    print(f"{system.title}: {result!r} in {seconds:.2f} s.")
    if len(varied) == 1:
        _tell(system, *next(iter(varied.items())), result)
    if options.plot:
        result.plot().savefig(options.plot)
    if options.csv:
        _write(options.csv, system, {name: given[name] for name in varied}, result)
    return 0 if result.success.all() else 1


def _tell(system, name, at, result):
    """The highest maxima over one parameter."""
    for reduced, columns in result.reduced.items():
        if reduced not in ("max", "rms"):
            continue
        for state, column in zip(system.states, columns.T, strict=True):
            inside = (column[1:-1] > column[:-2]) & (column[1:-1] >= column[2:])
            peaks = 1 + np.flatnonzero(inside)
            best = np.sort(peaks[np.argsort(column[peaks])[-2:]])
            found = [f"{column[i]:.6g} {state.unit} at {name} = {at[i]:.6g}" for i in best]
            print(f"  {reduced} of {state.name}: highest {'; '.join(found) or 'at an end'}")


def _write(path, system, varied, result):
    columns = {**varied, "status": result.status, "t_end": result.t_end}
    for reduced, table in result.reduced.items():
        names = result.event_names if reduced == "first_event" else [s.name for s in system.states]
        for name, column in zip(names, table.T, strict=True):
            columns[f"{reduced} {name}"] = column
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, fmt="%.17g", delimiter=",", header=",".join(columns), comments="")
