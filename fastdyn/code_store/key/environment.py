"""The common part of keys: sources, versions, processor, settings.  Needs no Numba.

A key covers the sources that can change the code, and no others (`sources.py`): after an edit
elsewhere, the kept code stays.
"""

import functools
import hashlib
import importlib.util
import os
import pathlib
import re
import sys

import numpy as np

from ..numba_settings import changed, settings
from .sources import sources

EXTENSIONS = re.compile(r"^\[numba_extensions\]$(.*?)(?=^\[|\Z)", re.M | re.S)


def environment(made_by):
    """Everything that all code of a kind depends on, as text; a key adds the rest.

    `made_by` are the sources that make the code, as in `cache.compiled`.
    """
    from ..target import processor

    now = settings()
    return _environment(made_by, processor(now), changed(now))


@functools.cache
def _environment(made_by, processor, changed):
    return repr((sources(made_by), *_versions(), processor, changed))


@functools.cache
def _versions():
    """The versions of Python and of the packages that make code."""
    versions = [_version_of(name) for name in ("numba", "llvmlite", "scipy")]
    return sys.version, versions, np.__version__, _extensions()


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
