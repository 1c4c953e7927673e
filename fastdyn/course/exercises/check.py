"""A worksheet that was handed in, judged in a process that may hang, end or crash."""

import json
import os
import queue
import subprocess
import sys
import threading
from typing import NamedTuple

from .sheet import exercises_of

LIMIT = 30.0  # seconds for reading a worksheet, and for each exercise
START = 120.0  # seconds in which a process begins


class Judged(NamedTuple):
    """
    The verdict on a worksheet.

    Parameters
    ----------
    found : dict of str to list of str
        Errors of each answer, by exercise; an empty list for a right answer.
    notes : dict of str to list of str
        Deviations that are no errors, by exercise.
    left : list of str
        Answers that were not judged.
    """

    found: dict
    notes: dict
    left: list


def check(path, own=None, limit=LIMIT):
    """
    Compare each function and model of a worksheet with the exercise of the same name.

    Parameters
    ----------
    path : str
        A Python file.
    own : str, optional
        A file of exercises; by default the exercises of the course.
    limit : float
        Seconds for reading the worksheet, and for each exercise.

    Returns
    -------
    Judged

    Raises
    ------
    ValueError
        If no exercise is answered, or the worksheet cannot be read.
    """
    path = str(path)
    own = str(own or "")
    exercises = exercises_of(own)
    found: dict = {}
    notes: dict = {}
    left = None
    while left is None:
        left = _session(path, own, limit, found, notes)
    if not found:
        said = " ".join([*left, f"{path} answers no exercise: "])
        raise ValueError(f"{said}it has no function or model {', '.join(exercises)}.")
    return Judged({name: found[name] for name in exercises if name in found}, notes, left)


def _session(path, own, limit, found, notes):
    """Judge the remaining answers; return final remarks, or None if the process ended early."""
    words = [sys.executable, "-P", "-m", f"{__package__}.reading", path, own, *found]
    child = subprocess.Popen(
        words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        env=os.environ | {"MPLBACKEND": "Agg"},
    )  # fmt: skip
    lines: queue.Queue = queue.Queue()
    threading.Thread(target=_forward, args=(child.stdout, lines), daemon=True).start()
    begun = ""
    wait = START
    try:
        while True:
            said = lines.get(timeout=wait)
            wait = limit
            if "left" in said:
                return said["left"]
            if "unread" in said:
                raise ValueError(said["unread"])
            if "ended" in said:
                return _cut(path, begun, found, "It ends Python.")
            if name := said.get("judged"):
                found[name], notes[name] = said["wrong"], said["notes"]
            begun = said.get("begun", "")
    except queue.Empty:
        return _cut(path, begun, found, f"It took longer than {limit:g} s.")
    finally:
        child.kill()
        child.wait()


def _cut(path, begun, found, sentence):
    """Report which exercise the process was judging when it ended, or that it was reading."""
    if not begun:
        raise ValueError(f"{path} could not be read. {sentence}")
    found[begun] = [sentence]


def _forward(stream, lines):
    with stream:
        for line in stream:
            lines.put(json.loads(line))
    lines.put({"ended": True})
