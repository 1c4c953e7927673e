"""The command ``fastdyn run SYSTEM``: one run, and its report."""

import math
import sys
from pathlib import Path

import numpy as np

from fastdyn.systems.base.units import with_degrees
from fastdyn.words.numbers import table

from . import checks, commands

SHOWN = 5  # times of an event that are printed


def add_options(parser, system):
    """Teach a parser the numbers of a system and the options of a run."""
    commands.add_fields(parser, system, checks.of_unit, "VALUE")
    start = ["--start"] if hasattr(system, "y0") else ["--y0", "--start"]
    names = ",".join(state.name for state in system.states)
    group = parser.add_argument_group("start and functions")
    group.add_argument(*start, dest="start", metavar=names.upper(), type=checks.state(system),
                       help="initial state, instead of the initial conditions")  # fmt: skip
    for name, known in system.choices.items():
        text = f"{', '.join(known)}, or FILE.py:FUNCTION"
        kind = checks.chosen_function(name, known)
        group.add_argument(f"--{name}", type=kind, metavar="NAME", help=text)
    solver = parser.add_argument_group("solution and output")
    commands.add_method(solver, system)
    if system.constraints:
        text = "hold the constraints by projection after each step"
        solver.add_argument("--project", action="store_true", default=None, help=text)
    commands.add_events(solver, system)
    solver.add_argument("--points", type=checks.whole(checks.FEWEST_POINTS, checks.MOST_POINTS),
                        metavar="N", help="number of equally spaced points of output")  # fmt: skip
    solver.add_argument("--plot", metavar="FILE", type=checks.file(checks.FIGURES),
                        help="write the figure, .png, .pdf or .svg")  # fmt: skip
    solver.add_argument("--animate", metavar="FILE", type=checks.moving_picture,
                        help="write a moving picture, .gif, .html or .mp4")  # fmt: skip
    solver.add_argument("--csv", metavar="FILE", type=checks.file(checks.TABLES),
                        help="write t, state, invariants and reactions")  # fmt: skip


def run(options):
    """Solve, print the results, and write the files; 1 if the run failed."""
    system = options.system(**commands.field_values(options))
    set_twice = commands.options_given(options, [field.name for field in system.initial_fields()])
    if options.start and set_twice:
        raise ValueError(f"`--start` and `--{next(iter(set_twice))}` both set the start; give one.")
    choices = commands.solver_options(options) | {"progress": sys.stderr.isatty()}
    choices |= commands.options_given(options, ("project",))
    if options.points is not None:
        choices["t_eval"] = np.linspace(0.0, options.t_end, options.points)
    if options.plot or options.animate:
        choices["dense_output"] = True
    names = commands.watched(options, system)
    if names:
        choices["events"] = names
    t_span = (0.0, options.t_end)
    result = system.solve(t_span, options.start, method=options.method, **choices)
    if options.points is not None:
        _add_end(result)
    _report(system, options.start, result, options.method, names)
    if options.csv:
        states = [state.name for state in system.states]
        columns = dict(zip(states, system.columns(result.y), strict=True))
        along = result.invariants() | result.residuals() | result.quantities()
        text = table({"t": result.t} | columns | along, grid=["t"])
        Path(options.csv).write_text(text, encoding="utf-8")
    if options.plot:
        from fastdyn import plot

        plot.save(result.plot(label=options.method), options.plot)
    if options.animate:
        result.animate(options.animate)
    return 0 if result.success else 1


def _add_end(result):
    """Let the points of output end where an event has ended the run."""
    if result.status == 1:
        i = np.argmax([times[-1] if len(times) else -math.inf for times in result.t_events])
        t = result.t_events[i][-1]
        y = result.y_events[i][-1]
        if len(result.t) and result.t[-1] != t:
            result.t, result.y = np.append(result.t, t), np.column_stack([result.y, y])


def _report(system, start, result, method, names):
    print(f"{system}, {method}: {result.message}")
    if "n_accepted" in result:  # SciPy does not count steps
        print(f"{result.n_accepted} steps, {result.n_rejected} rejected, ", end="")
    print(f"{result.nfev} evaluations")
    for name, unit in system.derived.items() if start is None else ():
        try:
            value = getattr(system, name)
        except ValueError:
            continue  # an orbit that does not close has no period
        print(f"  {name.replace('_', ' ')}{told(value, unit)}")
    for name, times in zip(names, result.t_events or (), strict=False):
        _tell_event(system, name, times, result)
    for name, begin, end in result.get("phases", ()):
        print(f"  {name} from {begin:.10g} s to {end:.10g} s")
    if len(result.t) == 0:
        return
    print(f"At t = {result.t[-1]:.10g} s:")
    try:
        errors = [f"  (error {error:.1e})" for error in result.error()[:, -1]]
    except ValueError:
        errors = [""] * len(system.states)
    for state, value, error in zip(system.states, result.y[:, -1], errors, strict=True):
        print(f"  {state.name}{told(value, state.unit)}{error if math.isfinite(value) else ''}")
    for name, values in result.quantities().items():
        _tell_quantity(name, values, result.system.quantities[name].unit)
    for name, values in result.invariants().items():
        change = f"{values[-1] - values[0]:.3g} {system.invariants[name].unit}"
        print(f"  {name.replace('_', ' ')} has changed by {change.rstrip()}")
    for name, values in result.residuals().items():
        off = f"{abs(values).max():.3g} {system.constraints[name].unit}"
        print(f"  {name.replace('_', ' ')} is off by {off.rstrip()} at most")


def _tell_quantity(name, values, unit):
    """Print a quantity at the end, and between which values it was."""
    known = values[np.isfinite(values)]
    if len(known):
        between = f"  (from {known.min():.4g} to {known.max():.4g})"
        print(f"  {name.replace('_', ' ')}{told(values[-1], unit)}{between}")


def told(value, unit):
    """A value with its unit; words for NaN and infinity."""
    if isinstance(value, str):
        return f" = {value}"
    if math.isnan(value):
        return ": there is none"
    if math.isinf(value):
        return ": infinite"
    return f" = {with_degrees(value, unit)}"


def _tell_event(system, name, times, result):
    """Print the times of an event, and if the event ended the run."""
    if not len(times):
        print(f"  {name}: not reached")
        return
    shown = ", ".join(f"{time:.10g}" for time in times[:SHOWN])
    more = f" and {len(times) - SHOWN} more" if len(times) > SHOWN else ""
    terminal = getattr(system.events[name], "terminal", False)
    ended = ", which ends the run" if result.status == 1 and terminal else ""
    print(f"  {name} at t = {shown} s{more}{ended}")
