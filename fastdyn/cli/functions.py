"""The functions of a user's file that a command names, with their state and arguments."""

import argparse
import ast
import contextlib
import inspect
import os
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from . import checks

LONGEST = 32  # components of a state that are tried where `--y0` is not given


class FunctionOfFile(NamedTuple):
    """A function with its state, its arguments and its events by name."""

    function: Any
    name: str
    y0: np.ndarray
    args: tuple
    events: dict


def add_options(parser):
    """Teach a parser the state, the arguments and the events of a function."""
    add_state(parser)
    parser.add_argument("--events", nargs="+", default=[], metavar="FUNCTION",
                        help="event(t, y, *args) in the same file")  # fmt: skip


def add_state(parser):
    """Teach a parser the state and the arguments of a function."""
    parser.add_argument("--t", type=checks.number, default=0.0, metavar="T", help="default 0")
    state = parser.add_mutually_exclusive_group()
    state.add_argument("--y0", type=numbers, metavar="Y0",
                       help="the state, 1,0; if absent, lengths are tried")  # fmt: skip
    state.add_argument("--n", type=checks.whole(1, checks.MOST_POINTS), metavar="N",
                       help="a state of N components, from 1 to 2")  # fmt: skip
    parser.add_argument("--args", type=literals, default=(), metavar="ARGS",
                        help="the arguments after t and y, 0.2 or 0.2,[1,2]")  # fmt: skip


def refuse_words_of_functions(options):
    """Refuse options that a system has of its own."""
    for name in ("y0", "n", "args", "events"):
        value: Any = getattr(options, name, None)
        if value is not None and len(np.atleast_1d(value)):
            raise ValueError(f"`--{name}` belongs to FILE:FUNCTION; a system has its own.")


def given(options):
    """What the words of a command say about a function."""
    function, name = named(options.what)
    y0 = state(function, options)
    events = {one: beside(options.what, one) for one in options.events}
    return FunctionOfFile(function, name, y0, options.args, events)


def beside(word, name):
    """Another function of the file of FILE:FUNCTION."""
    return in_a_sentence(checks.function_in_file, Path(word.rpartition(":")[0]), name)


def numbers(text):
    """The numbers of ``1,0``."""
    return np.array([checks.number(word) for word in text.split(",")])


def literals(text):
    """The tuple that Python reads in ``0.2,[1,2]``."""
    try:
        return ast.literal_eval(f"({text},)")
    except (ValueError, SyntaxError):
        raise argparse.ArgumentTypeError(
            f"{text!r} is no list of numbers and other literals of Python, such as 0.2,[1,2]."
        ) from None


def named(text):
    """The function that FILE:FUNCTION names, and its name."""
    path, colon, name = text.rpartition(":")
    if not colon:
        raise ValueError(f"give FILE:FUNCTION, such as {_example(text)}; got {text!r}.")
    sys.path.insert(0, os.path.dirname(os.path.abspath(path)))  # as `python FILE` does
    return in_a_sentence(checks.function_in_file, Path(path), name), name


def _example(text):
    """FILE:FUNCTION of a file, which is read and not run."""
    path = Path(text)
    if path.is_file():
        with contextlib.suppress(SyntaxError, ValueError):
            for one in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(one, ast.FunctionDef):
                    return f"{text}:{one.name}"
    return "orbit.py:satellite"


def in_a_sentence(check, *given):
    """The result of a check; argparse words a refusal only while it parses."""
    try:
        return check(*given)
    except argparse.ArgumentTypeError as error:
        raise ValueError(str(error)) from None


def state(function, options):
    """The state that is given, or one of a length for which the function returns as many numbers.

    Raises ValueError where the function does not take the arguments or gives no derivative.
    """
    try:
        inspect.signature(function).bind(options.t, None, *options.args)
    except TypeError as error:
        raise ValueError(f"{error}: `--args` gives the arguments after t and y.") from None
    given = options.y0 if options.n is None else np.linspace(1.0, 2.0, options.n)
    sizes = [len(given)] if given is not None else range(1, LONGEST + 1)
    reasons = []
    for n in sizes:
        y = 1.0 + 0.1 * np.arange(n) if given is None else given
        try:
            size = np.size(function(options.t, y.copy(), *options.args))
        except Exception as error:
            reasons.append(f"it raises {error!r}")
            continue
        if size == n:
            return y
        reasons.append(f"it returns {size} numbers for {n} components")
    advice = "" if given is not None else "; give a state, `--y0`"
    raise ValueError(f"the function gives no derivative: {reasons[0]}{advice}.")
