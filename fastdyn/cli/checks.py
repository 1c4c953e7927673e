"""Words of the command line as values, refused in a sentence before anything runs.

Each function is a `type` of argparse, or makes one.
"""

import argparse
import importlib.util
import math
import os
import re
from pathlib import Path
from typing import Any

import numpy as np

from fastdyn.plot.needed import needed
from fastdyn.systems.base.units import in_unit
from fastdyn.words.near import did_you_mean

FIGURES = (".png", ".pdf", ".svg")
MOVING = (".gif", ".html", ".mp4")
TABLES = (".csv", ".txt")
FEWEST_POINTS, MOST_POINTS = 2, 10**7  # ends of a run; 80 MB for each column of a table


def number(text):
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        comma = re.fullmatch(r"\s*[-+]?\d+,\d+\s*", text)
        said = f": a decimal number has a point, {text.replace(',', '.')}." if comma else "."
        raise argparse.ArgumentTypeError(f"{text!r} is not a number{said}") from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"must be a finite number; got {text}.")
    return value


def of_unit(unit):
    """The type of a finite number that may name its unit, ``45deg`` for an angle."""

    def check(text):
        try:
            value = in_unit(text, unit)
        except ValueError as error:
            return number(text) if _is_number(text) else _refuse(str(error))
        return number(repr(value))

    return check


def _is_number(text):
    try:
        return math.isnan(float(text)) or True
    except ValueError:
        return False


def _refuse(sentence):
    raise argparse.ArgumentTypeError(sentence)


def positive(text):
    """A number greater than zero."""
    value = number(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"must be greater than zero; got {text}.")
    return value


def end_of_run(text):
    """A time to which a run goes from 0, before or after it."""
    value = number(text)
    if value == 0.0:
        raise argparse.ArgumentTypeError("the run would end where it starts, at t = 0.")
    return value


def whole(least, most=None):
    """The type of whole numbers from `least` to `most`."""

    def check(text):
        try:
            value = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number.") from None
        if value < least or (most is not None and value > most):
            upper = "" if most is None else f" and at most {most}"
            raise argparse.ArgumentTypeError(f"must be at least {least}{upper}; got {text}.")
        return value

    return check


def file(endings):
    """The type of files to write that end so, in folders that are there."""

    def check(text):
        path = Path(text)
        if path.suffix.lower() not in endings:
            raise argparse.ArgumentTypeError(
                f"{text!r} must end in {', '.join(endings[:-1])} or {endings[-1]}."
            )
        folder = path.parent
        if not folder.is_dir():
            raise argparse.ArgumentTypeError(f"there is no folder {str(folder)!r} for {text!r}.")
        if path.is_dir() or not os.access(path if path.exists() else folder, os.W_OK):
            raise argparse.ArgumentTypeError(f"{text!r} cannot be written.")
        return path

    return check


def moving_picture(text):
    """A file for a moving picture, which this machine can make."""
    path = file(MOVING)(text)
    if path.suffix.lower() == ".mp4":
        if not needed("matplotlib.animation").writers.is_available("ffmpeg"):
            raise argparse.ArgumentTypeError(
                "an .mp4 is made by ffmpeg, which is not installed; .gif and .html need nothing."
            )
    return path


def method(text):
    """The name of a method."""
    from fastdyn.kernels.methods import METHODS
    from fastdyn.problem.validate import OTHER_METHODS

    return chosen("method", text, METHODS, OTHER_METHODS)


def chosen(what, text, known, others=None):
    """A word that is known; for another one, the sentence names those that are near, or all."""
    if text in known:
        return text
    advice = did_you_mean(text, known, others, form="{}", alike=0.5)
    advice = advice or f"choose from {', '.join(known)}."
    raise argparse.ArgumentTypeError(f"there is no {what} {text!r}; {advice}")


def state(system):
    """The type of an initial state of a system, numbers separated by commas."""

    def check(text):
        values = [number(word) for word in text.split(",")]
        names = ",".join(one.name for one in system.states)
        if len(values) != len(system.states):
            commas = "; decimal numbers have points" * (len(values) == 2 * len(system.states))
            raise argparse.ArgumentTypeError(
                f"the {system.name} starts from {len(system.states)} numbers, {names}; got "
                f"{len(values)}{commas}."
            )
        return values

    return check


def values_of_unit(unit):
    """The type of numbers: ``8.7``, ``1:30:10000`` or ``1,2,5`` give a float or an array."""
    number = of_unit(unit)

    def check(text):
        if ":" in text:
            first, last, count = [*text.split(":"), "", ""][:3]
            if text.count(":") != 2:
                raise argparse.ArgumentTypeError(f"a range is FROM:TO:COUNT; got {text!r}.")
            return np.linspace(number(first), number(last), whole(2, MOST_POINTS)(count))
        numbers = [number(word) for word in text.split(",")]
        return np.array(numbers) if len(numbers) > 1 else numbers[0]

    return check


def chosen_function(name, known):
    """The type of a function: one of those known by name, or FILE.py:FUNCTION."""

    def check(text):
        if text in known:
            return known[text]
        path, colon, function = text.rpartition(":")
        if not colon:
            raise argparse.ArgumentTypeError(
                f"there is no {name} {text!r}; choose from {', '.join(known)}, or give "
                "FILE.py:FUNCTION."
            )
        return function_in_file(Path(path), function)

    return check


def no_file(path):
    """The sentence about a file that is not there, with one of its folder that may be meant."""
    folder = Path(path).parent
    others = [each.name for each in folder.iterdir()] if folder.is_dir() else []
    said = did_you_mean(Path(path).name, others, form="{}")
    return f"there is no file {str(path)!r}{f'; {said}' if said else '.'}"


def function_in_file(path, name):
    """The function that a Python file defines by a name, which may have dots in it."""
    if not path.is_file():
        raise argparse.ArgumentTypeError(no_file(path))
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise argparse.ArgumentTypeError(f"{str(path)!r} is no Python file.")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise argparse.ArgumentTypeError(f"{str(path)!r} does not run: {error!r}.") from None
    function: Any = module
    for word in name.split("."):
        function = getattr(function, word, None)
    if not callable(function):
        there = [each for each, value in vars(module).items() if callable(value)]
        said = did_you_mean(name, there, form="{}")
        raise argparse.ArgumentTypeError(
            f"{str(path)!r} defines no function {name!r}{f'; {said}' if said else '.'}"
        )
    return function


def joined(words):
    """Words in which a negative number after an option, ``--V -1e-3``, is told from an option."""
    together = []
    for word in words:
        negative = len(word) > 1 and word[0] == "-" and (word[1].isdigit() or word[1] == ".")
        if negative and together and together[-1].startswith("--") and "=" not in together[-1]:
            together[-1] += f"={word}"
        else:
            together.append(word)
    return together
