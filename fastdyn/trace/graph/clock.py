"""A callback that long work on a graph calls now and then, so that a time limit can stop the work.

The code that builds, compares or emits a graph calls `look`.  The callback may raise OutOfTime.
Each thread has its own callback, or none.
"""

import contextlib
import threading
from typing import Any

EVERY = 256  # nodes between two calls of `look`


class _Clock(threading.local):
    check: Any = None


CLOCK = _Clock()


def look():
    """Call this thread's callback, if there is one."""
    if CLOCK.check is not None:
        CLOCK.check()


@contextlib.contextmanager
def checked_by(check):
    """Within the context, `check` is this thread's callback."""
    before = CLOCK.check
    CLOCK.check = check
    try:
        yield
    finally:
        CLOCK.check = before
