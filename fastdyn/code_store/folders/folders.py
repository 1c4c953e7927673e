"""The folders of kept code: first the system's folders, which are only read, then the user's own.

Whoever can write to a folder decides which code runs in processes that read the folder.  A
folder that anybody but the user or the system's owner can write or exchange is refused.
"""

import functools
import os
import warnings

from .folder import Folder
from .trust import POSIX, Doubt

# Beyond either, the entries longest unused go.  All tests write 11 000 within half an hour; a look
# at 16 000 takes 50 ms, once in PRUNE_ONCE_IN entries.
MAX_FILES, MAX_BYTES = 16_000, 512 * 2**20
PRUNE_ONCE_IN = 64  # entries that are written
SYSTEM = "/var/cache/fastdyn"


def own():
    """The user's folder: under NUMBA_CACHE_DIR if set, else in the user's cache.

    None for a user without a home.
    """
    base = os.environ.get("NUMBA_CACHE_DIR")
    if base:
        return os.path.join(base, "fastdyn")
    given = os.environ.get("XDG_CACHE_HOME" if POSIX else "LOCALAPPDATA")
    cache = given or os.path.expanduser("~/.cache")
    return None if cache.startswith("~") else os.path.join(cache, "numba", "fastdyn")


def of_the_system():
    """The folders that are only read: those of FASTDYN_SHARED_CODE, else SYSTEM."""
    given = os.environ.get("FASTDYN_SHARED_CODE")
    return [SYSTEM] if given is None else [f for f in given.split(os.pathsep) if f]


def entries(name):
    """The bytes of the entries of a name, from the system's folders first."""
    for path in filter(None, (*of_the_system(), own())):
        try:
            with Folder(path) as folder:
                data = folder.read(name)
        except OSError:
            continue
        except Doubt as reason:
            _say(path, str(reason))
            continue
        yield data


@functools.lru_cache(64)
def _say(folder, reason):
    """Warn, once, why a folder is not used."""
    warnings.warn(f"compiled code in {folder} is not used: {reason}.", stacklevel=2)


def store(name, data):
    """Write an entry to the user's folder; True on success.

    A folder that cannot be written is no error: the entry is not kept.
    """
    path = own()
    if path is None:
        return False
    try:
        with Folder(path, make=True) as folder:
            folder.check()
            folder.write(name, data)
            if os.urandom(1)[0] % PRUNE_ONCE_IN == 0:
                folder.prune(MAX_FILES, MAX_BYTES)
        return True
    except OSError:
        return False
    except Doubt as reason:
        _say(path, str(reason))
        return False
