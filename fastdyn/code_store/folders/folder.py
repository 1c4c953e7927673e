"""A folder of kept code, by its descriptor: the folder that is checked is the folder that is read.

A name may stand for another folder or file the next moment, a descriptor may not.  Windows has no
such descriptors, owners and modes: there, names are used, and the folder must be in the profile of
the user.
"""

import contextlib
import errno
import os
import stat
import time
from typing import Any

from . import trust
from .trust import POSIX, Doubt

HOUR = 3600.0  # seconds; age at which half-written files are deleted
NOTED = 60.0  # seconds between two notes of a use: a note costs 2 us
PLAIN = sum(getattr(os, name, 0) for name in ("O_NOFOLLOW", "O_NONBLOCK", "O_BINARY"))
LINK = (errno.ELOOP, errno.EMLINK, errno.ENOTDIR)  # errors for a link that is not followed


class Folder:
    """An open folder, for ``with``.

    Parameters
    ----------
    path : str
    make : bool
        Make the folder, and missing folders above.

    Raises
    ------
    OSError
        If the folder does not exist.
    Doubt
        If the folder is a symbolic link; with `make`, if others can exchange a folder above.
    """

    def __init__(self, path, make=False):
        path = path.rstrip("/") or "/"
        self.path = path if os.path.isabs(path) else os.path.join(os.getcwd(), path)
        self._fd: Any = None
        if not POSIX:
            if not make:
                os.stat(self.path)  # no folder is no reason for doubt
            trust.check_in_profile(self.path)
            if make:
                os.makedirs(self.path, exist_ok=True)
            return
        if make:
            trust.check_above(self.path, make)
        try:
            self._fd = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
        except OSError as error:
            if error.errno in LINK and os.path.islink(self.path):
                raise Doubt("it is a symbolic link; give the folder that it leads to") from None
            raise

    def __enter__(self):
        return self

    def __exit__(self, *failure):
        if self._fd is not None:
            os.close(self._fd)

    def _name(self, name):
        """The name that the system's calls take beside the descriptor."""
        return name if POSIX else os.path.join(self.path, name)

    def check(self):
        """Raise Doubt if others can write to the folder, or exchange the folder."""
        if not POSIX:
            return
        found = os.fstat(self._fd)
        trust.check(found)
        if not os.path.samestat(found, trust.check_above(self.path)):
            raise Doubt("it is being exchanged")

    def read(self, name):
        """The bytes of a file; OSError without the file, Doubt if others could have written it."""
        try:
            file = os.open(self._name(name), os.O_RDONLY | PLAIN, dir_fd=self._fd)
        except OSError as error:
            if error.errno in LINK:
                raise Doubt("an entry is a symbolic link") from None
            raise
        try:
            found = os.fstat(file)
            if POSIX:
                trust.check(found, "an entry")
                self.check()
            if not stat.S_ISREG(found.st_mode):
                raise Doubt("an entry is no file")
            if POSIX and found.st_uid == os.geteuid() and found.st_mtime < time.time() - NOTED:
                with contextlib.suppress(OSError):  # where nothing can be written
                    os.utime(file)  # `prune` drops the files longest unused
            return os.read(file, found.st_size)
        finally:
            os.close(file)

    def write(self, name, data):
        """Write a file, whole or not at all."""
        beside = self._name(f"{os.urandom(16).hex()}.tmp")
        how = os.O_WRONLY | os.O_CREAT | os.O_EXCL | PLAIN
        descriptor = os.open(beside, how, 0o644, dir_fd=self._fd)
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(data)
            os.replace(beside, self._name(name), src_dir_fd=self._fd, dst_dir_fd=self._fd)
        except BaseException:
            self._drop(beside)
            raise

    def open_lock(self, name):
        """A descriptor of a lock file, which is made if necessary."""
        how = os.O_RDWR | os.O_CREAT | PLAIN
        return os.open(self._name(name), how, 0o600, dir_fd=self._fd)

    def _drop(self, name):
        with contextlib.suppress(OSError):  # another process has dropped the file
            os.unlink(name, dir_fd=self._fd)

    def prune(self, max_files, max_bytes):
        """Drop the entries longest unused beyond the limits, and files left half written."""
        found = []
        old = time.time() - HOUR
        with os.scandir(self.path if self._fd is None else self._fd) as entries:
            for entry in entries:
                with contextlib.suppress(FileNotFoundError):
                    s = entry.stat(follow_symlinks=False)
                    found.append((s.st_mtime, s.st_size, entry.name))
        total = 0
        for i, (at, size, name) in enumerate(sorted(found, reverse=True)):
            total += size
            if i >= max_files or total > max_bytes or (name.endswith(".tmp") and at < old):
                self._drop(self._name(name))
