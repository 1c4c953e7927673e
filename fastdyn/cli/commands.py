"""What each command does."""

import dataclasses
import sys

import numpy as np


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
