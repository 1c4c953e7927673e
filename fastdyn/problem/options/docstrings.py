"""Docstrings of the public functions, whose lists of options come from the table."""

import inspect
import re
import textwrap
from collections.abc import Callable, Iterable
from typing import TypeVar

from .table import ALL_OPTIONS, OPTIONS, TOLERANCES, exact, refused_by, taken_by

Public = TypeVar("Public", bound=Callable)
WIDTH = 96
SHARED = {  # parts of docstrings, by their words in braces
    "figure": """**options
    Options of ``matplotlib.pyplot.figure``, or `ax`: see `fastdyn.plot.plot`.

Returns
-------
matplotlib.figure.Figure""",
    "many": """args : tuple, optional
    Each argument is an array or list of m numbers, one for each solve, or a value common to all
    solves: a number, any object, or an array in `fastdyn.ensemble.Shared`.

Returns
-------
OdeResult
    With the end times `t` (m,) and the end states `y` (m, n); with `t_eval`, `t` has
    these times, and `y` (m, n, n_times) is NaN after the end of a solve.  `nfev`, `status`,
    `success`, `n_accepted` and `n_rejected` have shape (m,).""",
}
ENTRY = re.compile(r"^\*\*options\n(?: .*\n|\n(?= ))*", re.MULTILINE)


def documented(function: Public) -> Public:
    """Replace the entry ``**options`` of a docstring by an entry for each option of the table."""
    if function.__doc__:
        text = inspect.cleandoc(function.__doc__)
        function.__doc__ = ENTRY.sub(lambda _: _entries(), text, count=1)
    return function


def _entries():
    """The entries of all options, in the form of numpydoc."""
    parts: list = []
    for option in ALL_OPTIONS:
        if option.text:
            parts.append(([option.name], option))
        else:
            parts[-1][0].append(option.name)
    return "".join(
        f"{', '.join(names)}{f' : {option.type}' if option.type else ''}\n"
        + textwrap.fill(option.text, WIDTH, initial_indent="    ", subsequent_indent="    ")
        + "\n"
        for names, option in parts
    )


def filled(who: str = "", **words: Iterable[str]) -> Callable[[Public], Public]:
    """Replace the words in braces in a docstring by what the table knows.

    ``{options}`` and ``{refused}`` are the names of the options that a function takes and refuses;
    ``{rtol}`` and ``{rtol of fit}`` are defaults; SHARED has parts that several functions share.
    `words` are lists of other names.
    """
    lists = {"options": taken_by(who), "refused": refused_by(who), **words}
    known = SHARED | {word: _names(names) for word, names in lists.items()}
    for name, default in TOLERANCES.items():
        known[name] = exact(default)
        known |= {f"{name} of {other}": exact(v) for other, v in OPTIONS[name].of.items()}

    def fill(function):
        if function.__doc__:
            text = inspect.cleandoc(function.__doc__)
            for word, said in known.items():
                text = text.replace(f"{{{word}}}", said)
            function.__doc__ = "\n".join(map(_wrapped, text.split("\n")))
        return function

    return fill


def _wrapped(line):
    """A line, which may have grown, as lines of at most WIDTH characters."""
    indent = line[: len(line) - len(line.lstrip())]
    return line if len(line) <= WIDTH else textwrap.fill(line, WIDTH, subsequent_indent=indent)


def _names(names):
    """Names in a sentence."""
    quoted = [f"`{name}`" for name in names]
    return " and ".join([*filter(None, [", ".join(quoted[:-1])]), *quoted[-1:]])
