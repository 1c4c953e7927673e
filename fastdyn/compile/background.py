"""The background thread, which makes code that no solve waits for.

The thread ends when its queue is empty.  While functions run in Python, the thread alternates short
work with long rests: compiled code that calls Python gives up the interpreter lock at each call,
and would otherwise wait a switch interval for the lock.  The thread never keeps the interpreter
from exiting.  A fork waits until the thread has stopped.
"""

import atexit
import contextlib
import contextvars
import functools
import gc
import os
import sys
import threading
import time
from collections import deque
from time import perf_counter
from typing import Any

from fastdyn.code_store import quiet
from fastdyn.trace.graph.clock import CLOCK
from fastdyn.trace.graph.refusal import NotYet, OutOfTime

WORK, REST = 0.001, 5.0  # seconds of work before a rest; ratio of a rest to the work before it
EVENTS = 100  # calls in Python between two looks at the clock
LONGEST = 0.5  # most seconds of work that count for the length of a rest
AT_EXIT, AT_FORK = 1.0, 60.0  # seconds to wait for the thread
MOST_IDLE = 8  # most idle tasks in the queue

_lock = threading.Lock()
_jobs: deque = deque()


class _State:
    """The state of the thread.

    `thread` is None if the queue is empty.  `busy` counts the functions that run in Python now.
    """

    thread: threading.Thread | None = None
    busy = 0
    stop = exits = False
    worked, calls = 0.0, 0


_state = _State()


class Job:
    """A task of the thread, queued at its creation; `idle` tasks run after all other tasks."""

    make: Any
    _context: Any

    def __init__(self, make, idle=False):
        self.make, self._context, self.idle = make, contextvars.copy_context(), idle
        self.waiting, self._done = 0, threading.Event()
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
        if seconds <= 0 or self._done.is_set():
            return self._done.is_set()
        self.waiting += 1
        try:
            return self._done.wait(seconds)
        finally:
            self.waiting -= 1


def _n_idle():
    return sum(job.idle for job in _jobs)


def idle_job(make):
    """A Job that no solve will ever wait for; None if MOST_IDLE such jobs are in the queue."""
    with _lock:
        full = _n_idle() >= MOST_IDLE
    return None if full else Job(make, True)


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


def give_way(one):
    """Count a function that begins (1) or ceases (-1) to run in Python, while the thread rests."""
    with _lock:
        _state.busy += one


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
    CLOCK.check, _state.worked = _look, perf_counter()
    while True:
        with _lock:
            if not _jobs or _state.stop:
                _state.thread = None
                return
            job = _jobs[0]
        done = job.run()
        with _lock:
            if done and job in _jobs:
                _jobs.remove(job)


def _look():
    """Rest if a function runs in Python; raise OutOfTime if the thread must stop."""
    if _state.stop:
        raise OutOfTime
    _rest()


def _must_rest():
    waited_for = bool(_jobs) and _jobs[0].waiting
    return _state.busy and not waited_for


def _rest():
    worked = perf_counter() - _state.worked
    if worked < WORK:
        return
    if _must_rest() and not _state.stop:
        time.sleep(REST * min(worked, LONGEST))
    _state.worked = perf_counter()


def watch_numba():
    """Let the thread also rest within a compilation by Numba: checked at passes and at calls."""
    _watch_calls()
    _listen()


@functools.cache
def _listen():
    import numba  # noqa: F401  # waits for another thread's import; importing a submodule does not
    from numba.core import event

    class Listener(event.Listener):
        def on_start(self, event):
            _watch_calls()

        def on_end(self, event):
            pass

    event.register("numba:run_pass", Listener())


def _watch_calls():
    """While the thread must rest, check the clock every EVENTS calls; a call then costs double."""
    if is_here() and _must_rest():
        sys.setprofile(_on_call)


def _on_call(frame, what, argument):
    _state.calls += 1
    if _state.calls % EVENTS == 0:
        if _state.exits:
            raise SystemExit
        _rest()
        if not _must_rest():
            sys.setprofile(None)


def _stopped(seconds):
    """Stop the thread, and wait for its end."""
    _state.stop, thread = True, _state.thread
    if thread is not None and thread is not threading.current_thread():
        thread.join(seconds)


def _at_exit():
    _state.exits = True
    give_way(1)
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
    _state.thread, _state.stop, _state.busy = None, False, 0


atexit.register(_at_exit)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(
        before=lambda: _stopped(AT_FORK), after_in_parent=_after_fork, after_in_child=_in_child
    )
