"""One process makes an entry; other processes that need the entry wait.

The lock is a lock of the system on an open file, which ends with its process.  Without such a lock,
or if the holder takes too long, each process makes the entry, with equal bytes.
"""

import contextlib
import os
import time
from typing import Any

from .folders import folders
from .folders.folder import Folder
from .folders.trust import Doubt

fcntl: Any = None
msvcrt: Any = None
try:
    import fcntl
except ImportError:  # where the system is not POSIX
    with contextlib.suppress(ImportError):
        import msvcrt

LONGEST, PAUSE = 120.0, 0.02  # seconds


@contextlib.contextmanager
def alone(name):
    """Hold the lock of the entry `name`."""
    file = None if fcntl is None and msvcrt is None else _opened(f"{name}.lock")
    if file is None:
        yield
        return
    try:
        _lock(file)
        yield
    finally:
        with contextlib.suppress(OSError):  # Windows drops no open file: the next prune does
            os.unlink(os.path.join(str(folders.own()), f"{name}.lock"))
        with contextlib.suppress(OSError):
            _release(file)
        os.close(file)


def _opened(name):
    """A descriptor of the lock file in the user's folder; None if no file can be made."""
    path = folders.own()
    if path is None:
        return None
    try:
        with Folder(path, make=True) as folder:
            folder.check()
            return folder.open_lock(name)
    except (OSError, Doubt):  # the folder keeps no entries either
        return None


def _take(file):
    """Take the lock, or raise BlockingIOError if it is held."""
    if fcntl is not None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return
    os.lseek(file, 0, os.SEEK_SET)
    try:
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
    except PermissionError as error:
        raise BlockingIOError(*error.args) from None


def _release(file):
    """Give the lock back: a forked process may have the file open, too."""
    if fcntl is not None:
        fcntl.flock(file, fcntl.LOCK_UN)
        return
    os.lseek(file, 0, os.SEEK_SET)
    msvcrt.locking(file, msvcrt.LK_UNLCK, 1)


def _lock(file):
    """Wait for the lock, at most LONGEST seconds."""
    end = time.monotonic() + LONGEST
    while time.monotonic() < end:
        try:
            _take(file)
            return
        except BlockingIOError:
            time.sleep(PAUSE)
        except OSError:  # a file system without locks
            return
