"""The shorter commands, and functions that several commands share."""

import dataclasses
import sys

from fastdyn.kernels.methods import METHODS
from fastdyn.problem.options.table import OPTIONS, exact

from . import checks, find

GROUND = "ground"  # the event at which a run ends without being asked to


def tour(options):
    from fastdyn.course import tour

    return 1 if tour.run(options.out, _known(options.systems) or None).n_failed else 0


def gallery(options):
    from fastdyn.course import gallery

    return 1 if gallery.build(options.out).n_failed else 0


def worksheet(options):
    from fastdyn.course.worksheets.sheet import sheet

    lines, hold = sheet(_known(options.systems), options.answers)
    print("\n".join(lines))
    return 0 if hold else 1


def _known(names):
    """Names of systems, refused if there is none of a name."""
    from fastdyn.systems import SYSTEMS
    from fastdyn.words.near import did_you_mean

    unknown = [name for name in names if name not in SYSTEMS]
    if unknown:
        advice = did_you_mean(unknown[0], SYSTEMS, form="{}")
        advice = advice or f"choose from {', '.join(SYSTEMS)}."
        raise ValueError(f"No system is called {unknown[0]}; {advice}")
    return names


def list_systems(options):
    from fastdyn.systems import SYSTEMS

    for name, system in SYSTEMS.items():
        state = ", ".join(f"{one.name} ({one.unit})" for one in system.states)
        print(f"{name}: {system.title} ({system.source})")
        print(f"  state {state}; t from 0 to {system.t_end:g} s")
        for heading, fields in _settable(system).items():
            if fields:
                print(f"  {heading}:")
            for field in fields:
                about = field.metadata
                value = f"{field.default:g} {about['unit']}"
                print(f"    {field.name:<7} = {value:<12} {about['meaning']}")
        others = [one for one in system.parameter_fields() if "unit" not in one.metadata]
        if others:
            print("  functions and arrays:")
        for field in others:
            known = ", ".join(system.choices.get(field.name, ())) or "from Python only"
            print(f"    {field.name:<7} : {known}")
        print(f"  invariants: {', '.join(system.invariants) or 'none'}")
        if system.constraints:
            print(f"  constraints: {', '.join(system.constraints)}")
        print(f"  events: {', '.join(system.events) or 'none'}\n")
    others = [name for name in find.PAGES if name not in SYSTEMS]
    print(f"Derived from a page of fastdyn.derive, by run, drift and sweep: {', '.join(others)}")
    return 0


def options_given(options, names):
    """The options among `names` that the command line gives, by name."""
    values = {name: getattr(options, name, None) for name in names}
    return {name: value for name, value in values.items() if value is not None}


def field_values(options):
    """The numbers that the command line gives for the fields of a system, by name."""
    return options_given(options, [field.name for field in dataclasses.fields(options.system)])


def solver_options(options):
    """The tolerances or the step that the command line gives, refused if the method takes none."""
    chosen = options_given(options, ("rtol", "atol", "step"))
    method = METHODS.get(options.method)
    fixed = method is not None and not method.error_order
    if fixed and "step" not in chosen:
        raise ValueError(f"{options.method} takes constant steps: give their size, `--step`.")
    for name in chosen:
        if (name == "step") != fixed:
            kind = "adapts its steps" if name == "step" else "takes constant steps"
            other = "`--rtol` and `--atol`" if name == "step" else "`--step`"
            raise ValueError(f"{options.method} {kind}: give {other}, not `--{name}`.")
    return chosen


def drift(options):
    from fastdyn.drift.compare import compare_drift

    system = options.system(**field_values(options))
    names = (
        "step", "steps_per_period", "rtol", "atol", "periods", "t_end", "n_steps", "evaluations",
        "seconds", "checkpoint",
    )  # fmt: skip
    chosen = options_given(options, names)
    show = {"samples": options.samples, "progress": sys.stderr.isatty()}
    studies = compare_drift(system, options.methods, **chosen, **show)
    print(f"{system}:")
    print(studies)
    if options.plot:
        from fastdyn import plot

        plot.save(studies.plot(), options.plot)
    return 1 if any(study.message for study in studies.values()) else 0


def _settable(system):
    """The fields that a command line can set, numbers with a unit, by kind."""
    kinds = {
        "parameters": system.parameter_fields(), "initial conditions": system.initial_fields()
    }  # fmt: skip
    return {
        heading: [field for field in fields if "unit" in field.metadata]
        for heading, fields in kinds.items()
    }


def add_fields(parser, system, kind, metavar, how=None):
    """
    Teach a parser the fields that a command line can set, in groups that `how` describes.

    `kind` makes the type of an option from the unit of its field.
    """
    for heading, fields in _settable(system).items():
        group = parser.add_argument_group(heading, how)
        for field in fields:
            about = field.metadata
            text = f"{about['meaning']} ({about['unit']}), default {field.default:g}"
            text += "; 45deg is in degrees" * (about["unit"] == "rad")
            group.add_argument(
                f"--{field.name}", help=text, metavar=metavar, type=kind(about["unit"])
            )


def add_method(group, system):
    """Teach a group of a parser the end of the run, the method, its tolerances and its step."""
    group.add_argument("--t-end", type=checks.end_of_run, default=system.t_end, metavar="T",
                       help=f"end of the run (s), default {system.t_end:g}")  # fmt: skip
    group.add_argument("--method", default="RK45", type=checks.method, metavar="METHOD",
                       help="RK45 (default), ode45, DOP853, Vern9, RK4 ...")  # fmt: skip
    for name, kind in (("rtol", "relative"), ("atol", "absolute")):
        known = OPTIONS[name]
        text = f"default {exact(known.of['systems'])} (of ode45 {exact(known.default)})"
        group.add_argument(f"--{name}", type=checks.positive, metavar="TOL",
                           help=f"{kind} tolerance of adaptive methods, {text}")  # fmt: skip
    group.add_argument("--step", type=checks.positive, metavar="H",
                       help="step (s) of methods with constant steps")  # fmt: skip


def add_events(group, system):
    """Teach a group of a parser the events of a system."""
    if system.events:
        text = f"watch for {', '.join(system.events)}"
        group.add_argument("--events", nargs="+", choices=system.events, metavar="EVENT",
                           default=[], help=text)  # fmt: skip
    if GROUND in system.events:
        text = "go on below the ground, where a run ends otherwise"
        group.add_argument("--through-ground", action="store_true", help=text)


def watched(options, system):
    """Names of the events to watch: the requested events, and the ground."""
    names = list(dict.fromkeys(getattr(options, "events", [])))
    if GROUND in system.events and options.through_ground:
        if GROUND in names:
            raise ValueError("`--events ground` ends the run there; `--through-ground` does not.")
    elif GROUND in system.events and GROUND not in names and options.t_end > 0.0:
        names.append(GROUND)
    return names
