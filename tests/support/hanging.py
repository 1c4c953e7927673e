"""End a process whose test hangs, by time that a busy machine does not shorten.

A wall clock ended the suite on a machine with ten jobs on two cores, in tests of 7 s of a
processor.  Here a second counts for as much as one process gets of the processors in that second.
"""

import faulthandler
import os
import threading

MOST = 300.0  # seconds of one test with a core of its own; the longest takes 40
WAIT = 1.0  # seconds between two looks


class Patience:
    """How long a test has run, and whether that is too long.

    Attributes
    ----------
    test : str or None
        The test that runs.
    """

    def __init__(self, n_cores, most=MOST):
        self._n_cores, self._most = n_cores, most
        self.begin(None)

    def begin(self, test):
        """Another test runs."""
        self.test = test
        self._seconds = 0.0

    def is_over(self, seconds, load):
        """Count seconds on a machine where `load` processes want to run."""
        self._seconds += seconds * min(1.0, self._n_cores / max(load, 1.0))
        return self.test is not None and self._seconds > self._most


def watch(patience, stream, ended, wait=WAIT):
    """Until the Event `ended`: name a test that hangs, show where each thread is, and exit."""
    while not ended.wait(wait):
        load = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
        if patience.is_over(wait, load):
            os.write(stream, f"{patience.test} hangs\n".encode())
            faulthandler.dump_traceback(stream)
            os._exit(1)  # pytest-xdist starts another worker


def start(stream):
    """A thread that watches the tests of this process; returns its Patience and what ends it."""
    patience, ended = Patience(os.cpu_count() or 1), threading.Event()
    threading.Thread(target=watch, args=(patience, stream, ended), daemon=True).start()
    return patience, ended
