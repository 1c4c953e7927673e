"""The command ``fastdyn``: ``tour``, ``gallery``, ``list``, ``run``, ``drift``, ``sweep``."""

import argparse
import dataclasses
import sys

import numpy as np


def main(arguments=None):
    """
    Run the command line.

    Parameters
    ----------
    arguments : list of str, optional
        Words after the command, those of the process unless given.

    Returns
    -------
    int
        Exit status: 0 for success, 1 if a check or a run failed, 2 for wrong input.
    """
    import matplotlib

    matplotlib.use("Agg")  # the command writes files and opens no window
    options = _parser().parse_args(arguments)
    try:
        return options.command(options)
    except (TypeError, ValueError, OSError) as error:
        print(f"fastdyn: {error}", file=sys.stderr)
        return 2


def _parser():
    from fastdyn.systems import SYSTEMS

    from . import sweep as sweeping

    parser = argparse.ArgumentParser(
        prog="fastdyn", description="Equations of motion, solved, checked and drawn."
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    tour = commands.add_parser("tour", help="replay the course, with a table and figures")
    tour.add_argument("systems", nargs="*", metavar="SYSTEM", help="only these (default: all)")
    tour.add_argument("--out", default="fastdyn-tour", metavar="DIR", help="folder for figures")
    tour.set_defaults(command=_tour)

    gallery = commands.add_parser("gallery", help="the figures of the tour, as a page")
    gallery.add_argument("--out", default="docs/gallery", metavar="DIR", help="folder of the page")
    gallery.set_defaults(command=_gallery)

    listing = commands.add_parser("list", help="systems and their parameters")
    listing.set_defaults(command=_list)

    drift = commands.add_parser("drift", help="follow the invariants of a system for long")
    systems = drift.add_subparsers(required=True, metavar="SYSTEM")
    for name, system in SYSTEMS.items():
        if system.invariants:
            one = systems.add_parser(name, help=system.title, allow_abbrev=False)
            _add_drift_options(one, system)
            one.set_defaults(command=_drift, system=system)

    sweep = commands.add_parser("sweep", help="solve one system for many parameters")
    systems = sweep.add_subparsers(required=True, metavar="SYSTEM")
    for name, system in SYSTEMS.items():
        one = systems.add_parser(name, help=system.title, allow_abbrev=False)
        sweeping.add_options(one, system, _numbers(system))
        one.set_defaults(command=sweeping.run, system=system)

    run = commands.add_parser("run", help="solve one system")
    systems = run.add_subparsers(required=True, metavar="SYSTEM")
    for name, system in SYSTEMS.items():
        one = systems.add_parser(name, help=system.title, allow_abbrev=False)
        _add_run_options(one, system)
        one.set_defaults(command=_run, system=system)
    return parser


def _add_parameters(parser, system):
    for heading, fields in _numbers(system).items():
        group = parser.add_argument_group(heading)
        for field in fields:
            about = field.metadata
            text = f"{about['meaning']} ({about['unit']}), default {field.default:g}"
            group.add_argument(f"--{field.name}", type=float, metavar="VALUE", help=text)


def _add_drift_options(parser, system):
    _add_parameters(parser, system)
    study = parser.add_argument_group("study and output")
    study.add_argument("--methods", nargs="+", default=["Gauss16"], metavar="METHOD")
    study.add_argument("--step", type=float, help="constant step (s)")
    study.add_argument("--steps-per-period", type=float, metavar="N")
    study.add_argument("--rtol", type=float, help="relative tolerance of adaptive methods")
    study.add_argument("--atol", type=float, help="absolute tolerance of adaptive methods")
    study.add_argument("--evaluations", type=float, help="a period, the same for all methods")
    study.add_argument("--seconds", type=float, help="time of a period, the same for all methods")
    study.add_argument("--periods", type=float, help="length of the run in periods")
    study.add_argument("--t-end", type=float, help="length of the run (s)")
    study.add_argument("--n-steps", type=int, help="length of the run in constant steps")
    study.add_argument("--samples", type=int, default=1000, help="bins that are kept")
    study.add_argument("--checkpoint", metavar="FILE", help="go on from here, and write it")
    study.add_argument("--plot", metavar="FILE", help="write the figure")


def _add_run_options(parser, system):
    _add_parameters(parser, system)
    solver = parser.add_argument_group("solution and output")
    solver.add_argument("--t-end", type=float, default=system.t_end, help="end of the run (s)")
    solver.add_argument("--method", default="RK45", help="RK45, ode45, DOP853, Vern9, RK4 ...")
    solver.add_argument("--rtol", type=float, help="relative tolerance, default 1e-6")
    solver.add_argument("--atol", type=float, help="absolute tolerance, default 1e-9")
    solver.add_argument("--step", type=float, help="step (s) of RK4 and VelocityVerlet")
    if system.constraints:
        text = "hold the constraints by projection after each step"
        solver.add_argument("--project", action="store_true", default=None, help=text)
    solver.add_argument("--points", type=int, help="number of equally spaced points of output")
    solver.add_argument("--plot", metavar="FILE", help="write the figure, .png, .pdf or .svg")
    solver.add_argument("--animate", metavar="FILE", help="write a moving picture, .gif or .html")
    solver.add_argument("--csv", metavar="FILE", help="write t, state and invariants")


def _tour(options):
    from fastdyn.course import tour
    from fastdyn.systems import SYSTEMS

    unknown = [name for name in options.systems if name not in SYSTEMS]
    if unknown:
        raise ValueError(f"No system is called {unknown[0]}; choose from {', '.join(SYSTEMS)}.")
    return 1 if tour.run(options.out, options.systems or None).n_failed else 0


def _gallery(options):
    from fastdyn.course import gallery

    return 1 if gallery.build(options.out).n_failed else 0


def _list(options):
    from fastdyn.systems import SYSTEMS

    for name, system in SYSTEMS.items():
        state = ", ".join(f"{one.name} ({one.unit})" for one in system.states)
        print(f"{name}: {system.title} ({system.source})")
        print(f"  state {state}; t from 0 to {system.t_end:g} s")
        for heading, fields in _numbers(system).items():
            if fields:
                print(f"  {heading}:")
            for field in fields:
                about = field.metadata
                value = f"{field.default:g} {about['unit']}"
                print(f"    {field.name:<7} = {value:<12} {about['meaning']}")
        others = [field for field in system.parameter_fields() if "unit" not in field.metadata]
        if others:
            print("  from Python only:")
        for field in others:
            value = getattr(field.default, "__name__", field.default)
            print(f"    {field.name:<7} = {value}")
        print(f"  invariants: {', '.join(system.invariants) or 'none'}")
        if system.constraints:
            print(f"  constraints: {', '.join(system.constraints)}")
        print(f"  events: {', '.join(system.events) or 'none'}\n")
    return 0


def _system(options):
    """The system with the numbers that the command line gives."""
    fields = dataclasses.fields(options.system)
    given = {field.name: getattr(options, field.name, None) for field in fields}
    return options.system(**{name: value for name, value in given.items() if value is not None})


def _drift(options):
    from fastdyn.drift.compare import Comparison, compare_drift
    from fastdyn.drift.energy import energy_drift

    system = _system(options)
    show = {"samples": options.samples, "progress": sys.stderr.isatty()}
    if options.evaluations or options.seconds:
        work = {name: getattr(options, name) for name in ("evaluations", "seconds", "periods")}
        studies = compare_drift(system, options.methods, **work, **show)
    else:
        names = ("step", "steps_per_period", "rtol", "atol", "periods", "t_end", "n_steps")
        given = {name: getattr(options, name) for name in (*names, "checkpoint")}
        given = {name: value for name, value in given.items() if value is not None}
        if "checkpoint" in given and len(options.methods) > 1:
            raise ValueError("`--checkpoint` is the file of one method; give one.")
        studies = Comparison(
            {name: energy_drift(system, name, **given, **show) for name in options.methods}
        )
    print(f"{system}:")
    print(studies)
    if options.plot:
        from fastdyn import plot

        plot.save(studies.plot(), options.plot)
    return 1 if any(study.message for study in studies.values()) else 0


def _run(options):
    system = _system(options)
    names = ("rtol", "atol", "step", "project")
    choices = {name: getattr(options, name, None) for name in names}
    choices = {name: value for name, value in choices.items() if value is not None}
    if options.points is not None:
        choices["t_eval"] = np.linspace(0.0, options.t_end, options.points)
    if options.plot or options.animate:
        choices["dense_output"] = True
    result = system.solve((0.0, options.t_end), method=options.method, **choices)
    _report(system, result, options.method)
    if options.csv:
        _write_csv(options.csv, system, result)
    if options.plot:
        from fastdyn import plot

        plot.save(result.plot(label=options.method), options.plot)
    if options.animate:
        result.animate(options.animate)
    return 0 if result.success else 1


def _report(system, result, method):
    print(f"{system}, {method}: {result.message}")
    if "n_accepted" in result:  # SciPy does not count steps
        print(f"{result.n_accepted} steps, {result.n_rejected} rejected, ", end="")
    print(f"{result.nfev} evaluations")
    for name, unit in system.derived.items():
        try:
            value = getattr(system, name)
        except ValueError:
            continue  # an orbit that does not close has no period
        text = value if isinstance(value, str) else f"{value:.10g}"
        print(f"  {name.replace('_', ' ')} = {text} {unit}".rstrip())
    if len(result.t) == 0:
        return
    print(f"At t = {result.t[-1]:.10g} s:")
    try:
        errors = [f"  (error {error:.1e})" for error in result.error()[:, -1]]
    except ValueError:
        errors = [""] * len(system.states)
    for state, value, error in zip(system.states, result.y[:, -1], errors, strict=True):
        print(f"  {state.name} = {value:.10g} {state.unit}{error}")
    for name, values in result.invariants().items():
        print(f"  {name.replace('_', ' ')} has changed by {values[-1] - values[0]:.3g}")
    for name, values in result.residuals().items():
        print(f"  {name.replace('_', ' ')} is off by {abs(values).max():.3g} at most")


def _write_csv(path, system, result):
    columns = {"t": result.t}
    columns |= {
        state.name: y for state, y in zip(system.states, system.columns(result.y), strict=True)
    }
    columns |= result.invariants() | result.residuals() | result.quantities()
    header = ",".join(columns)
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, fmt="%.17g", delimiter=",", header=header, comments="")


def _numbers(system):
    """The fields that a command line can set, numbers with a unit, by what they are."""
    kinds = {
        "parameters": system.parameter_fields(), "initial conditions": system.initial_fields()
    }  # fmt: skip
    return {
        heading: [field for field in fields if "unit" in field.metadata]
        for heading, fields in kinds.items()
    }
