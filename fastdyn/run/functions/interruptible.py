"""Signals while a kernel calls functions in Python: Ctrl-C, and what a timeout raises."""

import signal
import threading
from typing import Any

# The module behind `signal`, whose functions make no members of enums: a tenth of the time.
_signals: Any = getattr(signal, "_signal", signal)
# All whose handlers raise, in what people write; some systems lack most of them.
NAMES = "SIGINT", "SIGALRM", "SIGTERM", "SIGUSR1", "SIGUSR2", "SIGHUP", "SIGVTALRM", "SIGPROF"
NUMBERS = [int(getattr(signal, name)) for name in NAMES if hasattr(signal, name)]


class Interruptible:
    """The context of a kernel that calls functions in Python: no signal is lost in a callback.

    A signal inside the user's function has its usual effect; any other signal waits for the next
    call, or for the end of the kernel.  An exception of its handler where `Callback._call` begins
    would be dropped, and the kernel would go on with an old number.
    """

    __slots__ = ("_callbacks", "_handlers", "_waiting")

    def __init__(self, callbacks):
        self._callbacks = callbacks
        self._handlers: Any = {}
        self._waiting: Any = []

    def __enter__(self):
        if not self._callbacks or threading.current_thread() is not threading.main_thread():
            return
        for number in NUMBERS:
            handler = _signals.getsignal(number)
            if callable(handler):
                self._handlers[number] = handler
                _signals.signal(number, self._signalled)

    def __exit__(self, *raised):
        for number, handler in self._handlers.items():
            if _signals.getsignal(number) == self._signalled:  # the function may have set another
                _signals.signal(number, handler)
        self._deliver()

    def _signalled(self, number, frame):
        if any(c.inside for c in self._callbacks):
            self._handlers[number](number, frame)
            return
        self._waiting.append((number, frame))
        for callback in self._callbacks:
            callback.pending = self._deliver

    def _deliver(self):
        for callback in self._callbacks:
            callback.pending = None
        while self._waiting:
            number, frame = self._waiting.pop(0)
            self._handlers[number](number, frame)
