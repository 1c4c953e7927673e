"""Ctrl-C while a kernel calls functions in Python."""

import signal
import threading
from typing import Any

# The module behind `signal`, whose functions make no members of enums: a tenth of the time.
_signals: Any = getattr(signal, "_signal", signal)


class Interruptible:
    """The context of a kernel that calls functions in Python: Ctrl-C is not lost in a callback.

    A signal inside the user's function has its usual effect; any other signal waits for the next
    call, or for the end of the kernel.
    """

    __slots__ = ("_callbacks", "_handler", "_waiting")

    def __init__(self, callbacks):
        self._callbacks = callbacks
        self._handler: Any = None
        self._waiting: Any = None

    def __enter__(self):
        handler = _signals.getsignal(signal.SIGINT)
        main = threading.current_thread() is threading.main_thread()
        if self._callbacks and main and callable(handler):
            self._handler = handler
            _signals.signal(signal.SIGINT, self._signalled)

    def __exit__(self, *raised):
        if self._handler is not None:
            _signals.signal(signal.SIGINT, self._handler)
            if self._waiting is not None:
                self._deliver()

    def _signalled(self, number, frame):
        if any(c.inside for c in self._callbacks):
            self._handler(number, frame)
            return
        self._waiting = number, frame
        for callback in self._callbacks:
            callback.pending = self._deliver

    def _deliver(self):
        for callback in self._callbacks:
            callback.pending = None
        given = self._waiting
        self._waiting = None
        self._handler(*given)
