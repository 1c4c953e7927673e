"""Finds lines of the user's files, for messages that say why a function is not compiled."""

import math
import sys

from ..graph.refusal import Refusal
from ..graph.user_lines import of_user
from ..outside.surroundings import Outside
from ..reads.reads import Reads
from ..symbols.symbol import NOW, Symbol
from .runs import States, Tracing, _surroundings


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
    g = Tracing(n, math.inf)
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
        y = States(g, zeros, False).start()
        NOW.g = g
        sys.settrace(watch)
        time = Symbol(g, g.make("t").key)
        copy(time, y.reshape(shape) if shape and len(shape) > 1 else y, *given)
    except (Refusal, Exception):
        pass
    finally:
        sys.settrace(before)
        NOW.g = None
    return found[0] if found else None
