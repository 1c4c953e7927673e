"""A line in the log of fastdyn while Numba compiles, so that whoever waits knows what for.

The line comes after AFTER seconds of compiling, once for each method, as a warning of the logger
"fastdyn": Python writes it to stderr unless the program treats the logger otherwise, as by
``logging.getLogger("fastdyn").setLevel(logging.ERROR)``.
"""

import contextlib
import logging
import threading
from time import perf_counter

from . import quiet

AFTER = 2.0  # seconds; Numba's import and the first kernel of a cheap method take less
LOG = logging.getLogger("fastdyn")

_lock = threading.Lock()
_told: set = set()  # what lines were about


class _Compiled:
    """The seconds of compiling since the last line, and the method of the solve that waits."""

    seconds = 0.0
    method = ""


def meant_for(method):
    """Name the method of the solve that needs the kernels that come."""
    _Compiled.method = method


@contextlib.contextmanager
def announced(of_kernel):
    """The context in which Numba makes a kernel, or else a function of the user.

    Code that the background thread makes keeps nobody waiting.
    """
    if quiet.is_behind():
        yield
        return
    about = _Compiled.method if of_kernel else None
    began = perf_counter()
    told = []
    timer = threading.Timer(max(AFTER - _Compiled.seconds, 0.0), _tell, (about, told))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        _Compiled.seconds = 0.0 if told else _Compiled.seconds + perf_counter() - began


def _tell(about, told):
    with _lock:
        if about in _told:
            return
        _told.add(about)
        told.append(about)
    if about is None:
        LOG.warning("fastdyn compiles a function by Numba ...")
    else:
        what = f"the kernel of {about}" if about else "its kernels"
        LOG.warning("fastdyn compiles %s, once on this machine ...", what)
