"""Limits how long a solve waits for compiled code.

The thread of the solve traces the function, against a clock.  Tracing that takes longer goes to the
background thread; so does Numba's compilation, which cannot be interrupted.  The solve waits for
the code until its time is over, and then continues in Python.  A later solve finds the code.
"""

import contextlib
import math
import os
import threading
from time import perf_counter
from typing import Any

from fastdyn.trace.graph.clock import CLOCK, checked_by
from fastdyn.trace.graph.refusal import NotYet, OutOfTime

from . import background, memory

SECONDS = float(os.environ.get("FASTDYN_BUDGET", "0.3"))  # seconds; "inf" waits for all code
SHARE = 0.2  # the limit is at least this share of the time of earlier solves in Python
ROUNDS = 3  # after so many background jobs in a row whose code was not found, solves wait

_accounts = memory.Table()


class _Here(threading.local):
    least: Any = None  # lower bound, s, of the solve's time in Python; None: no limit
    end = math.inf


_here = _Here()


class Account:
    """The seconds that solves have waited for a function's code, and have run it in Python."""

    def __init__(self):
        self.waited, self.in_python, self.rounds = 0.0, 0.0, 0
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
    _here.end = perf_counter() + max(SECONDS, SHARE * least)
    try:
        yield
    finally:
        _here.least, _here.end = before


def within(place, make, known=lambda: None) -> tuple[Any, Any]:
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
    """
    if _here.least is None or SECONDS == math.inf:
        return make(), None
    account = _accounts.get(place)
    if account is None:
        account = _accounts.put(place, Account())
    if account.rounds >= ROUNDS:
        return make(), None
    begin = perf_counter()
    end = min(begin + account.left(), max(_here.end, begin + SHARE * account.in_python))
    try:
        return _made(account, make, known, end), None
    except NotYet:
        return None, account
    finally:
        account.waited += perf_counter() - begin


def _made(account, make, known, end):
    if account.job is None:
        try:
            return _against(end, make)
        except NotYet:
            account.job = background.Job(make)
    if not account.job.wait(end - perf_counter()):
        found = known()
        if found is None:
            raise NotYet("")
        return found
    account.job, account.rounds = None, account.rounds + 1
    found = _against(max(end, perf_counter() + SECONDS), make)
    account.rounds = 0
    return found


def _against(end, make):
    """Call ``make()`` under a clock that raises NotYet after the time `end`."""

    def check():
        if perf_counter() > end:
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
    begin = perf_counter()
    try:
        yield
    finally:
        for account in accounts:
            account.in_python += perf_counter() - begin
