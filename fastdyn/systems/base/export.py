"""The functions of a system in C or in JavaScript."""

from pathlib import Path

from fastdyn.trace.emit.source.files import Code, Named
from fastdyn.trace.emit.source.functions import Exported, NotExported
from fastdyn.trace.emit.source.language import LANGUAGES


def of_arguments(system, function, shape, numbers, name):
    """
    A function of ``(t, y, *parameters)``, written with the numbers of a system as parameters.

    Parameters
    ----------
    system : System
    function : callable
    shape : tuple or None
        The shape of the result; None for a number.
    numbers : list of str
        Names of the fields that are the parameters p[0], p[1] ...
    name : str
        In messages.
    """
    fields = enumerate(system.parameter_fields(), 1)
    places = {i: numbers.index(one.name) for i, one in fields if one.name in numbers}
    return Exported(function, system.args, len(system.states), shape, places, name)


def of_instance(system, function, shape, numbers, name):
    """A function of ``(t, y, system)``, as `of_arguments`."""
    places = {(1, field): k for k, field in enumerate(numbers)}
    return Exported(function, (system,), len(system.states), shape, places, name)


def code(system, jacobian=False, mass=False):
    """The `Code` of the right-hand side, the events, and what is asked for."""
    fields = [one for one in system.parameter_fields() if "unit" in one.metadata]
    numbers = [one.name for one in fields]
    n = len(system.states)
    rhs = of_arguments(system, system.rhs, (n,), numbers, "rhs")
    functions = {"rhs": (rhs, "The derivative of the state.")}
    phases = system.phases()
    for name, phase in phases.items():
        about = f"The derivative of the state in the phase {name}."
        functions[f"{name}_rhs"] = of_arguments(system, phase.fun, (n,), numbers, name), about
        ends = of_arguments(system, phase.event, None, numbers, name)
        functions[f"{name}_ends"] = ends, f"The event that ends the phase {name}, at its zero."
    for name, event in system.events.items():
        found = of_arguments(system, event, None, numbers, name)
        functions[f"event_{name}"] = found, f"The event {name}, at its zero."
    if mass:
        function = system.mass_matrix()
        if function is None:
            raise NotExported(
                f"The {system.name} has no mass matrix: systems that `derive` makes have one."
            )
        m = n // 2
        found = of_arguments(system, function, (m * m,), numbers, "mass matrix")
        about = "The mass matrix of the coordinates, row by row."
        functions["mass"] = found, about
    states = [Named(*one) for one in system.states]
    parameters = [
        Named(one.name, one.metadata["unit"], one.metadata["meaning"], getattr(system, one.name))
        for one in fields
    ]
    return Code(system.name, system.title, states, parameters, functions, jacobian)


def write(found, file, language):
    """
    Write the files of a `Code`.

    Parameters
    ----------
    found : Code
    file : path, optional
        Of the source; by default the name of the code. A header has the same name.
    language : {"c", "js"}

    Returns
    -------
    list of Path
    """
    if language not in LANGUAGES:
        raise ValueError(f"`language={language!r}` is unknown; choose from c, js.")
    file = Path(f"{found.name}.{language}" if file is None else file)
    written = []
    for end, text in found.texts(language, file.stem).items():
        path = file if end == f".{language}" else file.with_suffix(end)
        path.write_text(text, encoding="utf-8")
        written.append(path)
    return written
