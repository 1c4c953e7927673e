"""Limits how long a solve waits for compiled code.

The thread of the solve traces the function, against a clock.  Tracing that takes longer goes to the
background thread; so does Numba's compilation, which cannot be interrupted.  The solve waits for
the code until its time is over, and then continues in Python.  A later solve finds the code.

Times are processor times, of the thread of the solve and of the background thread for which it
waits: where other processes take most of the machine, functions are compiled as on an idle one.
"""

import contextlib
import math
import os
import threading
from time import perf_counter, thread_time
from typing import Any

from fastdyn.code_store.announced import LOG
from fastdyn.trace.graph.clock import CLOCK, checked_by
from fastdyn.trace.graph.refusal import NotYet, OutOfTime

from . import background, memory

SECONDS = float(os.environ.get("FASTDYN_BUDGET", "0.3"))  # seconds; "inf" waits for all code
SHARE = 0.2  # the limit is at least this share of the time of earlier solves in Python
SLOWEST = 10.0  # a solve waits at most for so many seconds of the wall for one of a processor
PAUSE = 0.01  # seconds between two looks at the processor time of the background thread
LASTS = 2.0  # seconds in Python, after which the user is told that a function is not compiled yet
ROUNDS = 3  # after so many background jobs in a row whose code was not found, solves wait

NOT_YET = (
    "%s has run in Python for %.0f s, because its compiled code is not ready yet; a later solve "
    "finds the code, and `fastdyn.prepare` waits for it"
)

_accounts = memory.Table()


class _Here(threading.local):
    least: Any = None  # lower bound, s, of the solve's time in Python; None: no limit
    end = math.inf
    waited = 0.0  # seconds that the background thread has worked while this thread waited


_here = _Here()


def _now():
    """The seconds of work for this thread."""
    return thread_time() + _here.waited


class Account:
    """The seconds that solves have waited for the code of a function, and have run it in Python."""

    def __init__(self, name):
        self.waited = 0.0
        self.in_python = 0.0
        self.rounds = 0
        self.name = name
        self.told = False
        self.untraced = False  # whether somebody was told that its switching times are not known
        self.job: Any = None

    def left(self):
        """The seconds that a solve may still wait."""
        return max(SECONDS, SHARE * self.in_python, SHARE * _here.least) - self.waited


@contextlib.contextmanager
def limited(least=0.0):
    """Within the context, functions that are not compiled in time run in Python.

    `least` is a lower bound, in seconds, for the time of the solve in Python.
    """
    before = _here.least, _here.end
    _here.least = least
    _here.end = _now() + max(SECONDS, SHARE * least)
    try:
        yield
    finally:
        _here.least, _here.end = before


def within(place, make, known=lambda: None, name="a function") -> tuple[Any, Any]:
    """``(make(), None)``, or ``(None, account)`` if `make` takes longer than the solve may wait.

    Parameters
    ----------
    place : tuple
        The identity of the function.
    make : callable
        Makes the code; a later call must find the code that an earlier call has made.
    known : callable, optional
        Returns code that was made for other values, or None.  Values may be again what they were
        while the background thread makes the code for values in between.
    name : str, optional
        The name of the function in sentences.
    """
    if _here.least is None or SECONDS == math.inf:
        return make(), None
    account = _accounts.get(place)
    if account is None:
        account = _accounts.put(place, Account(name))
    if account.rounds >= ROUNDS:
        return make(), None
    begin = _now()
    end = min(begin + account.left(), max(_here.end, begin + SHARE * account.in_python))
    try:
        return _made(account, make, known, end), None
    except NotYet:
        return None, account
    finally:
        account.waited += _now() - begin


def _made(account, make, known, end):
    if account.job is None:
        try:
            return _against(end, make)
        except NotYet:
            account.job = background.Job(make)
    if not _waited_for(account.job, end - _now()):
        found = known()
        if found is None:
            raise NotYet("")
        return found
    account.job, account.rounds = None, account.rounds + 1
    found = _against(max(end, _now() + SECONDS), make)
    account.rounds = 0
    return found


def _waited_for(job, left):
    """Wait until a job is done, or the background thread has worked `left` s; whether it is done.

    `_now` counts the work as this thread's.
    """
    began = perf_counter()
    at = background.seconds()
    spent = 0.0
    while not (done := job.wait(min(PAUSE, left - spent))):
        now = background.seconds()
        wall = perf_counter() - began
        spent = wall if at is None or now is None else max(now - at, wall / SLOWEST)
        if spent >= left:
            break
    _here.waited += spent
    return done


def _against(end, make):
    """Call ``make()`` under a clock that raises NotYet after the time `end`."""

    wall = perf_counter() + SLOWEST * (end - _now())

    def check():
        if _now() > end or perf_counter() > wall:
            raise OutOfTime

    with checked_by(check):
        return make()


def not_here():
    """Raise NotYet if a clock runs: Numba, which is called next, does not look at clocks."""
    if CLOCK.check is not None and not background.is_here():
        raise NotYet("Numba compiles it in another thread")


@contextlib.contextmanager
def in_python(accounts):
    """The context of a kernel that calls functions in Python."""
    begin = thread_time()
    try:
        yield
    finally:
        for account in accounts:
            account.in_python += thread_time() - begin
            if account.in_python > LASTS and not account.told:
                account.told = True
                LOG.warning(NOT_YET, account.name, account.in_python)
