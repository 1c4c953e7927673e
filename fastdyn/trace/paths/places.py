"""Finds lines of the user's files, for messages that say why a function is not compiled."""

import contextlib
import sys

from fastdyn.words.user_lines import of_user

from ..graph.refusal import Untraceable
from ..symbols.symbol import NOW
from .runs import trace


def line_of_refusal(error):
    """The (file, line) of the innermost frame of the user in a traceback; None if there is none."""
    found = None
    step = error.__traceback__
    while step is not None:
        if of_user(step.tb_frame.f_code.co_filename):
            found = step.tb_frame.f_code.co_filename, step.tb_lineno
        step = step.tb_next
    return found


def line_of_write(fun, args, n, shape, zeros=0):
    """The (file, line) of the first write to an object from outside; None if there is none."""
    return _line_after_which(lambda g: g.outside.writes(), fun, args, n, shape, zeros)


def line_of_operation(op, fun, args, n, shape):
    """The (file, line) of the first operation of this name; None if there is none."""
    return _line_after_which(
        lambda g: any(node.op == op for node in g.nodes.values()), fun, args, n, shape
    )


def _line_after_which(true, fun, args, n, shape, zeros=0):
    """The (file, line) after which ``true(graph)`` holds, found by another trace."""
    found = []
    last = None

    def watch(frame, event, _):
        nonlocal last
        if found or NOW.g is None or not of_user(frame.f_code.co_filename):
            return None
        if event != "call" and true(NOW.g):
            found.append(last)
        last = frame.f_code.co_filename, frame.f_lineno
        return watch

    before = sys.gettrace()
    sys.settrace(watch)
    try:
        with contextlib.suppress(Untraceable):
            trace(fun, args, n, shape, (), "none", zeros)
    finally:
        sys.settrace(before)
    return found[0] if found else None
