"""Reads and judges a worksheet in a separate process, which reports each step."""

import json
import os
import pathlib
import sys
import traceback
import types
from typing import Any

from . import sheet


def read(path):
    """
    The names that a worksheet defines, and a sentence about an early end, or "".

    Raises
    ------
    ValueError
        If the worksheet is no Python text.
    """
    module = types.ModuleType("worksheet")
    module.__file__ = path
    sys.modules["worksheet"] = module
    try:
        code = compile(pathlib.Path(path).read_bytes(), path, "exec")
    except SyntaxError as error:
        place = f", line {error.lineno}" if error.lineno else ""
        raise ValueError(f"{path}{place}: {error.msg}.") from None
    except ValueError as error:
        raise ValueError(f"{path} is no Python text: {error}.") from None
    except (RecursionError, MemoryError):
        raise ValueError(f"{path} is nested too deeply for Python.") from None
    try:
        exec(code, module.__dict__)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        return vars(module), _ended(path, error)
    return vars(module), ""


def _ended(path, error):
    """A sentence about the exception that ended a worksheet, with the line."""
    lines = [
        one.lineno for one in traceback.extract_tb(error.__traceback__) if one.filename == path
    ]
    where = f"{path}, line {lines[-1]}" if lines else path
    if isinstance(error, SystemExit):
        return f"{where}: exit ends Python here; what follows is not read."
    return f"{where}: {type(error).__name__}: {error}; what follows is not read."


def main(path, own, done, say):
    """
    Judge the answers of a worksheet one after the other.

    Parameters
    ----------
    path, own : str
        The worksheet, and a lecturer's exercises or "".
    done : list of str
        Exercises that are judged already.
    say : callable
        Called with a dict at each step: an exercise begins, an exercise is judged, final remarks.
    """
    exercises = sheet.exercises_of(own)
    say({"ready": True})
    sys.path.append(str(pathlib.Path(path).parent))  # other files of the student
    try:
        made, ended = read(path)
    except (ValueError, OSError) as error:
        say({"unread": str(error)})
        return
    found = sheet.answers(made, exercises)
    solutions = [one.solution for one in exercises.values()]
    for name, answer in found.items():
        if name not in done:
            say({"begun": name})
            wrong, notes = sheet.judged(exercises[name], answer, solutions)
            say({"judged": name, "wrong": wrong, "notes": notes})
    say({"left": [ended] * bool(ended) + sheet.strays(made, found, exercises)})


def _say_to(stream):
    def say(what):
        stream.write(json.dumps(what) + "\n")
        stream.flush()

    return say


if __name__ == "__main__":
    answers_to: Any = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # keeps output of the worksheet out of the report
    main(sys.argv[1], sys.argv[2], sys.argv[3:], _say_to(answers_to))
