"""One process makes an entry, and the others that want the same wait for that one.

The lock is one of the system on an open file, which ends with its process.  Where there is none,
or the holder takes longer than anything takes, each makes its own: the same bytes.
"""

import contextlib
import os
import time
from typing import Any

from . import folders

fcntl: Any = None
with contextlib.suppress(ImportError):  # where the system is not POSIX
    import fcntl

LONGEST, PAUSE = 120.0, 0.02  # seconds


@contextlib.contextmanager
def alone(name):
    """Hold the lock of an entry."""
    file = None if fcntl is None else _opened(f"{name}.lock")
    if file is None:
        yield
        return
    try:
        _lock(file)
        yield
    finally:
        assert fcntl is not None
        with contextlib.suppress(OSError):
            os.unlink(folders.own() / f"{name}.lock")
            fcntl.flock(file, fcntl.LOCK_UN)  # a forked process may have the file open, too
        os.close(file)


def _opened(name):
    """A descriptor of the lock file in the user's folder; None if there can be none."""
    try:
        folder = folders.own()
        folder.mkdir(parents=True, exist_ok=True, mode=0o755)
        flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
        return os.open(folder / name, flags, 0o600)
    except (OSError, RuntimeError):  # no home
        return None


def _lock(file):
    """Wait for the lock, not for ever."""
    end = time.monotonic() + LONGEST
    while time.monotonic() < end:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            time.sleep(PAUSE)
        except OSError:  # a file system without locks
            return
