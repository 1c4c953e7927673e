"""The origin of a system, and the lines of Python that make the system."""

import dataclasses
import sys
from typing import Any, NamedTuple

from fastdyn.systems import SYSTEMS
from fastdyn.words.near import did_you_mean

from .page_names import PAGES


class Source(NamedTuple):
    """
    A system that is explored.

    Parameters
    ----------
    make : type
        The class of the system.
    lines : list of str
        Lines of Python after which `name` is the class.
    name : str
    values : dict of str to float
        The first values of sliders that do not begin with the defaults.
    """

    make: Any
    lines: list
    name: str
    values: dict


def known():
    """Names of the systems of the course, and of the pages that are derived."""
    return [*SYSTEMS, *(name for name in PAGES if name not in SYSTEMS)]


def named(name):
    """
    The source of a system by its name.

    Raises
    ------
    ValueError
        For a name that is not known, and for a page without SymPy.
    """
    if name in SYSTEMS:
        make = SYSTEMS[name]
        return Source(make, [f"from fastdyn.systems import {name}"], name, dict(make.explored))
    if name not in PAGES:
        said = did_you_mean(name, known(), form="{}") or f"choose from {', '.join(known())}."
        raise ValueError(f"No system is called {name}; {said}")
    try:
        from fastdyn.derive.pages import page
    except ImportError as error:
        raise ValueError(str(error)) from None
    made = f'{name} = page("{name}").derive().system'
    lines = ["from fastdyn.derive.pages import page", "", made]
    return Source(page(name).derive().system, lines, name, {})


def of_file(word, make):
    """The source of the system of a file; `word` is the word of the command line."""
    lines = ["from fastdyn.cli.find import in_file", "", f"{make.name} = in_file({word!r})"]
    return Source(make, lines, make.name, {})


def of_system(system):
    """The source of an existing system, with its values."""
    make = type(system)
    values = {field.name: getattr(system, field.name) for field in dataclasses.fields(system)}
    if SYSTEMS.get(make.name) is make:
        return named(make.name)._replace(values=values)
    module = sys.modules.get(make.__module__)
    known_there = getattr(module, make.__name__, None) is make and make.__module__ != "__main__"
    lines = [f"from {make.__module__} import {make.__name__} as {make.name}"]
    if not known_there:  # made in a notebook, or by a derivation
        lines = [f"# {make.name} is the class of your system, as derivation.system"]
    return Source(make, lines, make.name, values)
