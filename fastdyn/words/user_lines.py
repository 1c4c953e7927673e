"""Distinguishes the user's files and lines from those of Python and of some libraries."""

import functools
import os
import sysconfig

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
    root = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
    return not any(path.startswith(folder + os.sep) for folder in (*STANDARD, root))
