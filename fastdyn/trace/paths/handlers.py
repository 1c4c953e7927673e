"""Finds out whether the user's code would catch an exception that is raised now."""

import dis
import functools
import os
import sys
from typing import Any

OWN = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__)))) + os.sep
GENERATORS = "CALL_INTRINSIC_1"  # handles a generator's exceptions, from Python 3.12 on
LIBRARIES = tuple(f"{os.sep}{name}{os.sep}" for name in ("numpy", "scipy"))
_entries: Any = vars(dis)["_parse_exception_table"]


def is_handled(until):
    """Whether a frame, from the caller's up to the code `until`, is in a ``try`` or ``with``.

    Frames of NumPy, SciPy and this package do not count.
    """
    frame = sys._getframe(1)
    while frame is not None and frame.f_code is not until:
        code = frame.f_code
        if code.co_exceptiontable and _counts(code.co_filename):
            at = frame.f_lasti
            if any(begin <= at < end for begin, end in _protected(code)):
                return True
        frame = frame.f_back
    return False


@functools.lru_cache(1024)
def _counts(filename):
    return not filename.startswith(OWN) and not any(name in filename for name in LIBRARIES)


@functools.lru_cache(1024)
def _protected(code):
    """The ranges of bytecode that have an exception handler."""
    names = {i.offset: i.opname for i in dis.get_instructions(code)}
    return [(e.start, e.end) for e in _entries(code) if names.get(e.target) != GENERATORS]
