"""Finds out whether the user's code would catch an exception that is raised now."""

import dis
import functools
import os
import sys
from typing import Any

OWN = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__)))) + os.sep
CATCHES = "PUSH_EXC_INFO"  # the first instruction of a handler of ``try`` or ``with``
LIBRARIES = tuple(f"{os.sep}{name}{os.sep}" for name in ("numpy", "scipy"))
_entries: Any = vars(dis)["_parse_exception_table"]


def is_handled(until):
    """Whether a frame on the stack is in a ``try`` or ``with``.

    The search goes from the caller's frame to the frame of the code `until`, and leaves out frames
    of NumPy, of SciPy and of this package.
    """
    frame = sys._getframe(1)
    while frame is not None and frame.f_code is not until:
        code = frame.f_code
        if code.co_exceptiontable and _counts(code.co_filename):
            if _is_caught(code, frame.f_lasti):
                return True
        frame = frame.f_back
    return False


@functools.lru_cache(1024)
def _counts(filename):
    return not filename.startswith(OWN) and not any(name in filename for name in LIBRARIES)


@functools.lru_cache(4096)
def _is_caught(code, at):
    """Whether a ``try`` or ``with`` handles an exception that is raised at a bytecode offset.

    Generators and, from Python 3.12 on, comprehensions have handlers that restore variables and
    raise again.  Such a handler does not count.
    """
    names = {i.offset: i.opname for i in dis.get_instructions(code)}
    for entry in _entries(code):
        if entry.start <= at < entry.end:
            if names.get(entry.target) == CATCHES:
                return True
            again = [i for i, name in names.items() if i > entry.target and name == "RERAISE"]
            return not again or _is_caught(code, again[0])
    return False
