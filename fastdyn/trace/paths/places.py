"""Finds lines of the user's files, for messages that say why a function is not compiled."""

import functools
import os
import sys
import sysconfig

from ..graph.refusal import Refusal
from ..outside.surroundings import Outside
from ..reads.reads import Reads
from ..symbols.arrays import Array
from ..symbols.real import Symbol
from .runs import Paths, _surroundings

STANDARD = tuple({os.path.realpath(sysconfig.get_path(p)) for p in ("stdlib", "platstdlib")})
PACKAGES = {"fastdyn", "numba", "numpy", "llvmlite", "scipy"}


@functools.lru_cache(4096)
def of_user(filename):
    """Whether a file belongs neither to Python nor to the libraries that compile functions."""
    path = os.path.realpath(filename)
    if filename.startswith("<frozen") or filename in ("<string>", "<__array_function__ internals>"):
        return False
    folders = path.split(os.sep)
    if "site-packages" in folders:
        return folders[folders.index("site-packages") + 1] not in PACKAGES
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
    return not any(path.startswith(folder + os.sep) for folder in (*STANDARD, root))


def line_of_refusal(error):
    """The (file, line) of the innermost frame of the user in a traceback; None if there is none."""
    found, step = None, error.__traceback__
    while step is not None:
        if of_user(step.tb_frame.f_code.co_filename):
            found = step.tb_frame.f_code.co_filename, step.tb_lineno
        step = step.tb_next
    return found


def line_of_write(fun, args, n, shape, zeros=0):
    """The (file, line) of the first write to an object from outside, found by a run on symbols.

    Only the first path is run.  None means that the path has no such write.
    """
    g = Paths()
    g.reads = Reads(g, (fun, *args))
    outside, found, last = Outside(g, g.reads, "none"), [], None

    def watch(frame, event, _):
        nonlocal last
        if found or not of_user(frame.f_code.co_filename):
            return None
        if event != "call" and outside.writes():
            found.append(last)
        last = frame.f_code.co_filename, frame.f_lineno
        return watch

    before = sys.gettrace()
    try:
        copy, given = _surroundings(outside, fun, args)
        states = [Symbol(g, g.make("y", (), i)) for i in range(n)]
        y = Array.of(states + [Symbol(g, g.const(0.0)) for _ in range(zeros)])
        sys.settrace(watch)
        copy(Symbol(g, g.make("t")), y.reshape(shape) if shape and len(shape) > 1 else y, *given)
    except (Refusal, Exception):
        pass
    finally:
        sys.settrace(before)
    return found[0] if found else None
