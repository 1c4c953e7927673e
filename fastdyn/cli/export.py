"""The command ``fastdyn export``: a function or a system in C or in JavaScript."""

import inspect
from typing import Any

import numpy as np

from fastdyn.trace.emit.source.files import Code, Named
from fastdyn.trace.emit.source.functions import Exported
from fastdyn.trace.emit.source.language import LANGUAGES

from . import find, functions


def add_options(parser):
    """Teach the parser of the command its words."""
    parser.add_argument("what", metavar="FILE:FUNCTION",
                        help="fun(t, y, *args) in a file; or a system: of the course, derived, "
                        "FILE.py or FILE.py:NAME")  # fmt: skip
    parser.add_argument("--language", choices=tuple(LANGUAGES), default="c", help="default c")
    functions.add_options(parser)
    parser.add_argument("--jacobian", action="store_true", help="write the Jacobian, too")
    parser.add_argument("--mass", nargs="?", const=True, metavar="FUNCTION",
                        help="write the mass matrix, too: M(t, y, *args) in the file, or that of "
                        "a derived system")  # fmt: skip
    parser.add_argument("--out", metavar="FILE", help="default: the name, .c and .h, or .js")


def run(options):
    """Write the files, and print their names."""
    from fastdyn.systems.base import export

    system = find.any_system(options.what)
    if system is not None:
        functions.refuse_words_of_functions(options)
        found = export.code(system(), options.jacobian, bool(options.mass))
    else:
        found = _of_function(options)
    for path in export.write(found, options.out, options.language):
        print(path)
    return 0


def _of_function(options):
    """The `Code` of a function of the user, its events and its mass matrix."""
    given = functions.given(options)
    n = len(given.y0)
    args = given.args
    numbers = [isinstance(one, float | int) and not isinstance(one, bool) for one in args]
    places = {i: sum(numbers[: i - 1]) for i, known in enumerate(numbers, 1) if known}
    names = list(inspect.signature(given.function).parameters)[2:] + [""] * len(args)
    parameters = [
        Named(name or f"args[{k}]", value=float(one))
        for k, (name, one, known) in enumerate(zip(names, args, numbers, strict=False))
        if known
    ]

    def exported(function, name, shape):
        return Exported(function, args, n, shape, places, name)

    parts = {"rhs": (exported(given.function, given.name, (n,)), "The derivative of the state.")}
    for name, event in given.events.items():
        parts[f"event_{name}"] = exported(event, name, None), f"The event {name}, at its zero."
    if options.mass:
        if options.mass is True:
            raise ValueError("give the mass matrix of a function by its name, `--mass NAME`.")
        mass: Any = functions.beside(options.what, options.mass)
        value = np.asarray(mass(0.0, np.array(given.y0), *args))
        if value.shape != (n, n):
            raise ValueError(f"`{options.mass}` must return {n} x {n} numbers; got {value.shape}.")
        found = exported(lambda t, y, *rest: np.ravel(mass(t, y, *rest)), options.mass, (n * n,))
        parts["mass"] = found, "The mass matrix, row by row."
    states = [Named(f"y[{i}]") for i in range(n)]
    return Code(given.name, given.name, states, parameters, parts, options.jacobian)
