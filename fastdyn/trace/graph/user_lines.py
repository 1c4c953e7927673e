"""Distinguishes the user's files and lines from those of Python and of some libraries."""

import functools
import os
import sys
import sysconfig
from typing import Any

STANDARD = tuple({os.path.realpath(sysconfig.get_path(p)) for p in ("stdlib", "platstdlib")})
PACKAGES = {"fastdyn", "numba", "numpy", "llvmlite", "scipy"}


@functools.lru_cache(4096)
def of_user(filename):
    """Whether a file belongs neither to Python nor to one of the libraries in PACKAGES."""
    path = os.path.realpath(filename)
    if filename.startswith("<frozen") or filename in ("<string>", "<__array_function__ internals>"):
        return False
    folders = path.split(os.sep)
    if "site-packages" in folders:
        return folders[folders.index("site-packages") + 1] not in PACKAGES
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
    return not any(path.startswith(folder + os.sep) for folder in (*STANDARD, root))


def line_of_call():
    """The (file, line) of the innermost frame of the user in the stack; None if there is none."""
    frame: Any = sys._getframe()
    while frame is not None and not of_user(frame.f_code.co_filename):
        frame = frame.f_back
    return frame and (frame.f_code.co_filename, frame.f_lineno)
