"""The common part of keys: sources, versions, processor, settings.  Needs no Numba.

A key covers the sources that can change the code, and no others: after an edit elsewhere, the kept
code stays.  Kernels depend on the folders that make kernels; the code of users' functions depends
on the compiler, too.
"""

import functools
import hashlib
import importlib.util
import os
import pathlib
import re
import sys

import numpy as np

from .folders import folders
from .numba_settings import changed, settings

PACKAGE = pathlib.Path(__file__).parent.parent
KERNELS = frozenset({"kernels", "specialise", "code_store"})  # the folders that make kernels
# The folders that make no code.  A folder that is not named counts as one that makes the code of
# functions: a new folder is safe.  A test sees that these folders make none.
_WITHOUT = {
    "__pycache__", "analysis", "cli", "course", "dae", "derive", "drift", "ensemble", "explore",
    "fitting", "matlab", "planets", "plot", "problem", "run", "solve", "systems",
    "words",
}  # fmt: skip
FUNCTIONS = KERNELS | {
    folder.name for folder in os.scandir(PACKAGE) if folder.is_dir() and folder.name not in _WITHOUT
}
EXTENSIONS = re.compile(r"^\[numba_extensions\]$(.*?)(?=^\[|\Z)", re.M | re.S)


def environment(made_by):
    """Everything that all code of a kind depends on, as text; a key adds the rest.

    `made_by` is KERNELS or FUNCTIONS.
    """
    from .target import processor

    now = settings()
    return _environment(made_by, processor(now), changed(now))


@functools.cache
def _environment(made_by, processor, changed):
    versions = [_version_of(name) for name in ("numba", "llvmlite", "scipy")]
    return repr(
        (sources(made_by), sys.version, versions, np.__version__, _extensions(), processor, changed)
    )


@functools.cache
def sources(made_by):
    """The hash of the sources that make code of a kind, by name and content.

    The hash is kept under the stamps of the files: no file is read again before a stamp changes.
    The time of the last change of an inode cannot be set back.
    """
    found = sorted(_files(made_by))
    stamp = _stamp(found)
    for data in folders.entries(f"{stamp}.sources"):
        known = data[:64]
        if data == _sealed(known, stamp):
            return known.decode()
    known = _digest(found)
    if _stamp(found) == stamp:  # no file was edited meanwhile
        folders.store(f"{stamp}.sources", _sealed(known.encode(), stamp))
    return known


def _sealed(known, stamp):
    """The kept form of a hash, with a check: a damaged hash would stand for other sources."""
    return known + hashlib.sha256(known + stamp.encode()).hexdigest().encode()


def _stamp(found):
    lines = []
    for _, entry in found:
        s = os.stat(entry.path)
        lines.append((entry.path, s.st_dev, s.st_ino, s.st_size, s.st_mtime_ns, s.st_ctime_ns))
    return hashlib.sha256(repr(lines).encode()).hexdigest()


def _digest(found):
    digest = hashlib.sha256()
    for name, entry in found:
        with open(entry.path, "rb", buffering=0) as file:
            content = file.read()
        digest.update(f"{name} {len(content)} ".encode())
        digest.update(content)
    return digest.hexdigest()


def _files(made_by):
    """(name, entry) of the files *.py in folders of fastdyn; `kernels` may lie beside fastdyn."""
    import fastdyn.kernels

    for folder in made_by:
        path = PACKAGE / folder
        if folder == "kernels":
            path = os.path.dirname(fastdyn.kernels.__file__)
        yield from _python_files(path, f"fastdyn/{folder}")


def _python_files(folder, name):
    """(name, entry) of the files *.py in a folder and below it."""
    for entry in os.scandir(folder):
        if entry.name.endswith(".py"):
            yield f"{name}/{entry.name}", entry
        elif entry.is_dir() and entry.name != "__pycache__":
            yield from _python_files(entry.path, f"{name}/{entry.name}")


def _version_of(package):
    """The identity of a package's version: the hash of the file that states the version."""
    spec = importlib.util.find_spec(package)
    for name in ("_version.py", "version.py"):
        try:
            content = pathlib.Path(spec.origin).with_name(name).read_bytes()  # pyright: ignore
            return hashlib.sha256(content).hexdigest()
        except (OSError, AttributeError, TypeError):
            pass
    return __import__(package).__version__


def _extensions():
    """Packages that extend Numba: (folder with the package's version, entry points) each."""
    found = set()
    for place in sys.path:
        try:
            names = [n for n in os.listdir(place or ".") if n.endswith((".dist-info", ".egg-info"))]
        except OSError:
            continue
        for name in names:
            try:
                with open(os.path.join(place, name, "entry_points.txt"), encoding="utf-8") as file:
                    section = EXTENSIONS.search(file.read())
            except OSError:
                continue
            if section:
                found.add((name, section[1].strip()))
    return sorted(found)
