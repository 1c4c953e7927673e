"""Checkpoints: the state of a run in a file, whole or not at all.

A file is an .npz without pickles: arrays, and a JSON header that identifies the run.  The file is
written under another name, flushed to disk and renamed, so that a kill at any moment leaves the
last whole file.  A digest over the whole content detects a damaged file.
"""

import errno
import hashlib
import io
import json
import os
import pathlib
import time

import numpy as np

from fastdyn import __version__
from fastdyn.compile.fingerprint import Unknown, frozen
from fastdyn.compile.sentences import warn

SECONDS = 5.0  # between two writes, at least
FULL = {getattr(errno, name, None) for name in ("ENOSPC", "EDQUOT")}  # errors that may be temporary


def fingerprint(bounds):
    """A digest of functions and of all values that the functions use.

    Raises ValueError for a function that another process cannot identify.
    """
    parts = []
    for bound in bounds:
        try:
            if bound.function is None:
                raise Unknown(bound.python)
            parts.append((bound.function.key, tuple([frozen(value) for _, value in bound.values])))
        except Unknown:
            raise ValueError(
                "`checkpoint` needs functions that compile, and that use no object which exists in "
                "this process alone: a file must tell its run from other runs."
            ) from None
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def refuse_other(path, header, ours, name):
    """Raise ValueError if the header in a file belongs to another run."""
    wrong = [entry for entry in ours if header.get(entry) != ours[entry]]
    if wrong:
        raise ValueError(
            f"`{path}` belongs to another run; what differs: {', '.join(wrong)}. "
            f"Give another `{name}`, or remove this one."
        )


def fill(own, arrays):
    """Copy the arrays of a file over those of a run; ValueError if they are not of this run."""
    for name, mine in own.items():
        array = arrays.get(name)
        if array is None or (array.shape, array.dtype) != (mine.shape, mine.dtype):
            raise ValueError(f"the checkpoint is not of this run: its `{name}` is another.")
        mine[...] = array


class Checkpoint:
    """The file of one run.

    Parameters
    ----------
    path : str or path
    header : dict
        The identity of the run, in JSON's types: method, fingerprint, spans.  A file with another
        header is refused.
    """

    def __init__(self, path, header):
        self.path = pathlib.Path(path)
        self._header = {"fastdyn": __version__, **header}
        self._written = time.monotonic()
        self._fails = False
        self._try_the_place()

    def _try_the_place(self):
        """Raise OSError before a long run if its file could not be written."""
        folder = self.path.parent
        if self.path.is_dir():
            raise IsADirectoryError(f"`checkpoint`: `{self.path}` is a folder; give a file.")
        if not folder.is_dir():
            raise FileNotFoundError(f"`checkpoint`: there is no folder `{folder}`; make it first.")
        import tempfile

        try:
            tempfile.NamedTemporaryFile(dir=folder, suffix=".tmp").close()
        except OSError as error:
            if error.errno not in FULL:
                reason = f"`checkpoint`: nothing can be written to `{folder}`: {error.strerror}."
                raise type(error)(reason) from None
            self._warn(error)

    def load(self):
        """The arrays of the file, None without a file; ValueError for the file of another run."""
        try:
            data = self.path.read_bytes()
        except FileNotFoundError:
            return None
        header, arrays, digest = self._parts(data)
        if digest != _digest(header, arrays):
            raise ValueError(f"`{self.path}` has been altered or damaged since it was written.")
        refuse_other(self.path, header, self._header, "checkpoint")
        return arrays

    def _parts(self, data):
        """(header, arrays, digest) from the bytes of a file."""
        import zipfile

        try:
            with zipfile.ZipFile(io.BytesIO(data)) as file:
                arrays = {name.removesuffix(".npy"): _array(file, name) for name in file.namelist()}
            header = json.loads(str(arrays.pop("header")))
            digest = str(arrays.pop("digest"))
            if isinstance(header, dict):
                return header, arrays, digest
        except Exception:  # damaged bytes raise any exception in three parsers
            pass
        raise ValueError(
            f"`{self.path}` is not a whole checkpoint. Give another `checkpoint`, or remove this "
            "one to begin anew."
        )

    def due(self):
        """True if the last attempt to write is long enough ago."""
        return time.monotonic() - self._written > SECONDS

    def save(self, arrays):
        """Write the file; True on success.  A full disk gives a warning, and the run goes on."""
        digest = _digest(self._header, arrays)
        buffer = io.BytesIO()
        np.savez(buffer, header=json.dumps(self._header), digest=digest, **arrays)
        try:
            self._write(buffer.getbuffer())
        except OSError as error:
            self._warn(error)
            return False
        finally:
            self._written = time.monotonic()
        self._fails = False
        return True

    def _write(self, data):
        """Write under another name, flush, rename; remove the new file if that fails."""
        import tempfile

        file = tempfile.NamedTemporaryFile(dir=self.path.parent, suffix=".tmp", delete=False)
        try:
            with file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            os.replace(file.name, self.path)
        except BaseException:
            pathlib.Path(file.name).unlink(missing_ok=True)
            raise

    def _warn(self, error):
        """Warn, at the first of several failures, that the run goes on without a new checkpoint."""
        if not self._fails:
            warn(
                f"the checkpoint `{self.path}` was not written: {error.strerror or error}. The run "
                "goes on; what was written before stays."
            )
        self._fails = True


def _array(file, name):
    with file.open(name) as member:
        return np.lib.format.read_array(member, allow_pickle=False)


def _digest(header, arrays):
    digest = hashlib.sha256(json.dumps(header, sort_keys=True).encode())
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        digest.update(f"{name} {array.dtype.descr} {array.shape}".encode() + array.tobytes())
    return digest.hexdigest()
