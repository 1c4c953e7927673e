"""The background thread, which makes code that no solve waits for.

The thread ends when its queue is empty.  Compiled code that calls Python gives up the interpreter
lock at each call, and then waits a switch interval for the lock: the interval is short while the
thread runs.  The thread never keeps the interpreter from exiting.  A fork waits until the thread
has stopped.
"""

import atexit
import contextlib
import contextvars
import ctypes
import gc
import os
import sys
import threading
import time
from collections import deque
from typing import Any

from fastdyn.code_store import quiet
from fastdyn.trace.graph.clock import CLOCK
from fastdyn.trace.graph.refusal import NotYet, OutOfTime

# Seconds for which a function in Python waits for the thread.  6000 calls while Numba compiled took
# 0.7 s with 1e-4 and 0.8 s with 1e-5, of which 0.3 s in the function.
SWITCH = 1e-4
AT_EXIT, AT_FORK = 1.0, 60.0  # seconds to wait for the thread
MOST_IDLE = 8  # most idle tasks in the queue

_lock = threading.Lock()
_jobs: deque = deque()


class _State:
    """The state of the thread, and its clock; `thread` is None if the queue is empty."""

    thread: threading.Thread | None = None
    clock: int | None = None
    stop = False


_state = _State()


class Job:
    """A task of the thread, queued at its creation; `idle` tasks run after all other tasks."""

    make: Any
    _context: Any

    def __init__(self, make, idle=False):
        self.make, self._context, self.idle = make, contextvars.copy_context(), idle
        self._done = threading.Event()
        with _lock:
            _jobs.insert(len(_jobs) - (0 if idle else _n_idle()), self)
            _start()

    @property
    def done(self):
        """Whether the task was carried out, or given up."""
        return self._done.is_set()

    def run(self):
        try:
            self._context.run(self.make)
        except NotYet:
            if _state.stop:
                return False
        except BaseException:
            pass  # a solve that needs the code makes the code again, and raises
        self.end()
        return True

    def end(self):
        """Mark the task as done."""
        self.make = self._context = None
        self._done.set()

    def wait(self, seconds):
        """Wait at most `seconds`; return whether the task is done."""
        return self._done.wait(max(seconds, 0.0))


def _n_idle():
    return sum(job.idle for job in _jobs)


def idle_job(make):
    """A Job that no solve will ever wait for; None if MOST_IDLE such jobs are in the queue."""
    with _lock:
        full = _n_idle() >= MOST_IDLE
    return None if full else Job(make, True)


def seconds():
    """The processor time of the background thread; None where the system does not tell it."""
    clock = _state.clock
    if clock is not None:
        with contextlib.suppress(OSError):  # the thread has just ended
            return time.clock_gettime(clock)
    return None


def is_here():
    """Whether the current thread is the background thread."""
    return threading.current_thread() is _state.thread


@contextlib.contextmanager
def without_collecting():
    """Switch off garbage collection: a graph has many objects, and no reference cycles."""
    on = gc.isenabled() and not is_here()
    if on:
        gc.disable()
    try:
        yield
    finally:
        if on:
            gc.enable()


def finish(seconds=120.0):
    """Wait until the queue is empty."""
    thread = _state.thread
    if thread is not None:
        thread.join(seconds)


def _start():
    if _state.thread is None and _jobs and not _state.stop:
        _state.thread = threading.Thread(target=_work, name="fastdyn compiles", daemon=True)
        _state.thread.start()


def _work():
    quiet.behind()
    CLOCK.check = _look
    if hasattr(time, "pthread_getcpuclockid"):
        _state.clock = time.pthread_getcpuclockid(threading.get_ident())
    interval = sys.getswitchinterval()
    sys.setswitchinterval(min(SWITCH, interval))
    while True:
        with _lock:
            if not _jobs or _state.stop:
                _state.thread = _state.clock = None
                sys.setswitchinterval(interval)
                return
            job = _jobs[0]
        done = job.run()
        with _lock:
            if done and job in _jobs:
                _jobs.remove(job)


def _look():
    """Raise OutOfTime if the thread must stop."""
    if _state.stop:
        raise OutOfTime


def _stopped(seconds):
    """Stop the thread, and wait for its end."""
    _state.stop, thread = True, _state.thread
    if thread is not None and thread is not threading.current_thread():
        thread.join(seconds)


def _at_exit():
    thread = _state.thread
    _state.stop = True
    if thread is not None:  # Numba looks at no clock
        raised = ctypes.c_ulong(thread.ident or 0), ctypes.py_object(SystemExit)
        ctypes.pythonapi.PyThreadState_SetAsyncExc(*raised)
    _stopped(AT_EXIT)


def _after_fork():
    """Continue the work in the parent."""
    with _lock:
        _state.stop = False
        _start()


def _in_child():
    global _lock
    _lock = threading.Lock()
    for job in _jobs:
        job.end()
    _jobs.clear()
    _state.thread = None
    _state.clock = None
    _state.stop = False


atexit.register(_at_exit)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(
        before=lambda: _stopped(AT_FORK), after_in_parent=_after_fork, after_in_child=_in_child
    )
