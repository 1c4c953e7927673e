"""Compiled code on disk: one file a function, named by everything its machine code depends on.

Numba's own cache is keyed by file and function name and does not notice an edit in another file.
Here the name of a file is the hash of its key, so an entry is never out of date: it is either
the right one or not there.  Entries are written whole and renamed, and verified when read.
"""

import functools
import hashlib
import os
import pathlib
import pickle
import sys
import tempfile
from typing import Any, NamedTuple

import llvmlite
import numba
import numpy as np
from numba.core import compiler, serialize
from numba.core.registry import cpu_target
from numba.core.runtime.nrt import rtsys
from numba.misc.appdirs import AppDirs

MAGIC = b"fastdyn1"
MAX_FILES, MAX_BYTES = 2000, 512 * 2**20  # beyond either, the entries longest unused go
HERE = pathlib.Path(__file__).parent
COUNTS = {"loaded": 0, "compiled": 0, "stored": 0}


class Compiled(NamedTuple):
    """Machine code: its address, its Python entry point, and what keeps both alive."""

    address: int
    call: Any
    owner: Any


def directory():
    """Where entries are kept: under NUMBA_CACHE_DIR if that is set, else the user's cache."""
    base = os.environ.get("NUMBA_CACHE_DIR")
    return pathlib.Path(base or AppDirs(appname="numba", appauthor=False).user_cache_dir, "fastdyn")


def _target() -> Any:
    return cpu_target.target_context


@functools.cache
def environment():
    """What every entry depends on: versions, processor, compiler settings, our own sources."""
    import fastdyn.kernels

    sources = [
        *sorted(pathlib.Path(fastdyn.kernels.__file__).parent.glob("*.py")),
        *sorted(HERE.glob("*.py")),
    ]
    digest = hashlib.sha256()
    for source in sources:
        digest.update(source.read_bytes())
    switches = ("OPT", "BOUNDSCHECK", "DEBUG_TYPEINFER", "LOOP_VECTORIZE", "SLP_VECTORIZE")
    return repr(
        (
            digest.hexdigest(),
            sys.version,
            numba.__version__,
            llvmlite.__version__,
            np.__version__,
            _target().codegen().magic_tuple(),
            [str(getattr(numba.config, name, None)) for name in switches],
        )
    )


def compiled(key, build):
    """The machine code for `key`, from disk or by `build()`.

    Parameters
    ----------
    key : str or None
        Everything, besides `environment`, that the code depends on.  None: never on disk.
    build : callable
        Returns a Numba dispatcher and the signature to compile it for.
    """
    found = key and stored(key)
    if found:
        return found
    dispatcher, signature = build()
    dispatcher.compile(signature)
    result = dispatcher.get_compile_result(signature)
    COUNTS["compiled"] += 1
    if key is not None and not result.library.has_dynamic_globals:
        _store(_path(key), result)
    return _finish(result, dispatcher)


def _path(key):
    return directory() / f"{hashlib.sha256((environment() + key).encode()).hexdigest()}.nbc"


def stored(key):
    """The machine code for `key` if it is on disk, else None."""
    result = _load(_path(key))
    if result is None:
        return None
    COUNTS["loaded"] += 1
    return _finish(result)


def _finish(result, dispatcher=None):
    address = result.library.get_pointer_to_function(result.fndesc.llvm_func_name)
    return Compiled(address, result.entry_point, (result, dispatcher))


def _load(path):
    """The compile result in a file; None if there is none or it is not whole."""
    try:
        data = path.read_bytes()
        size = len(MAGIC) + 32
        head, payload = data[:size], data[size:]
        if head != MAGIC + hashlib.sha256(payload).digest():
            return None
        parts = pickle.loads(payload)
        os.utime(path)
    except OSError:
        return None
    rtsys.initialize(_target())  # loaded code may allocate
    return compiler.CompileResult._rebuild(_target(), *parts)


def _store(path, result):
    """Write an entry; a directory that cannot be written is no error, only no cache."""
    payload = serialize.dumps(result._reduce())
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".tmp", delete=False) as file:
            file.write(MAGIC + hashlib.sha256(payload).digest() + payload)
        os.replace(file.name, path)
        COUNTS["stored"] += 1
        _prune(path.parent)
    except OSError:
        pass


def _prune(folder):
    """Drop the entries longest unused once there are too many."""
    entries = sorted(
        ((entry.stat().st_mtime, entry.stat().st_size, entry.path) for entry in os.scandir(folder)),
        reverse=True,
    )
    total = 0
    for i, (_, size, path) in enumerate(entries):
        total += size
        if i >= MAX_FILES or total > MAX_BYTES:
            pathlib.Path(path).unlink(missing_ok=True)
