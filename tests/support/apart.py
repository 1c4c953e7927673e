"""In a worker, each folder of tests runs in a process of its own, which ends with all its memory.

Numba, LLVM and JAX keep what they have compiled: of all tests, one process grew to more than 2 GB,
0.8 of them before the first test.  A worker forks a process for each folder; that process has
collected the tests already, and sends the reports of its tests to the worker.  Where there is no
fork, tests run as pytest runs them.
"""

import multiprocessing.connection
import os

import pytest
from _pytest.runner import runtestprotocol

CAN_FORK = hasattr(os, "fork")
DIED = "the process of this folder of tests ended by signal or exit status {}, within this test"


class Apart:
    """A plugin of pytest.  `begun` is called in each new process."""

    def __init__(self, begun):
        self._begun, self._folder = begun, None
        self._connection, self._process = None, 0
        self._serves, self._found = False, []

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item, nextitem):
        if not CAN_FORK:
            return None
        if self._serves:
            self._found = runtestprotocol(item, log=False, nextitem=nextitem)
            return True
        hook = item.ihook
        hook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        if self._folder != item.path.parent:
            self._start(item)
        for report in self._reports(item, nextitem):
            hook.pytest_runtest_logreport(report=report)
        hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        if nextitem is None or nextitem.path.parent != item.path.parent:
            self._stop()
        return True

    def _start(self, item):
        """Fork; the new process runs the tests that it is told to run."""
        item.config._tmp_path_factory.getbasetemp()  # one for all folders
        here, there = multiprocessing.connection.Pipe()
        self._process, self._folder = os.fork(), item.path.parent
        if self._process:
            there.close()
            self._connection = here
            return
        here.close()
        status = 1
        try:
            self._begun()
            self._serve(item.session, there)
            status = 0
        finally:
            os._exit(status)

    def _serve(self, session, connection):
        self._serves = True
        places = {item.nodeid: item for item in session.items}
        while asked := connection.recv():
            item, nextitem = (places.get(nodeid) for nodeid in asked)
            item.ihook.pytest_runtest_protocol(item=item, nextitem=nextitem)  # with what wraps it
            dumped = item.config.hook.pytest_report_to_serializable
            connection.send([dumped(config=item.config, report=each) for each in self._found])

    def _reports(self, item, nextitem):
        """The reports of a test from the process of its folder."""
        try:
            goes_on = nextitem is not None and nextitem.path.parent == self._folder
            self._connection.send((item.nodeid, nextitem.nodeid if goes_on else None))
            reports = self._connection.recv()
        except (EOFError, OSError):
            _, status = os.waitpid(self._process, 0)
            self._process, self._folder = 0, None
            text = DIED.format(os.waitstatus_to_exitcode(status))
            return [pytest.TestReport(item.nodeid, item.location, {}, "failed", text, "call")]
        loaded = item.config.hook.pytest_report_from_serializable
        return [loaded(config=item.config, data=each) for each in reports]

    def _stop(self):
        if self._process:
            self._connection.send(None)
            os.waitpid(self._process, 0)
            self._process, self._folder = 0, None
