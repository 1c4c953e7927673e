"""All workers share one cache of compiled code; it is kept from one run to the next."""

import ctypes
import gc
import itertools
import os
import pathlib
import signal
import subprocess
import sys
import threading

import hypothesis.configuration
import matplotlib
import numpy as np
import pytest

from support import few, hanging
from support.apart import Apart

matplotlib.use("Agg")
gc.set_threshold(100_000, 20, 100)  # compiling makes many small objects that live long
if sys.platform == "linux":  # M_MMAP_THRESHOLD: long arrays go back to the system when they end
    ctypes.CDLL(None).mallopt(-3, 2**20)

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # started in the background of a shell
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Bytecode is kept: two workers import the tests, hundreds of processes import the package.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

COMMON_KERNELS = str(pathlib.Path(__file__).parent / "support" / "common_kernels.py")
KEPT = pathlib.Path(__file__).parent.parent / ".pytest_cache"
os.environ.setdefault("NUMBA_CACHE_DIR", str(KEPT / "compiled"))
os.environ.setdefault("FASTDYN_BUDGET", "inf")  # compiled code is there at once
os.environ.setdefault("DASK_TEMPORARY_DIRECTORY", str(KEPT / "dask"))
hypothesis.configuration.set_hypothesis_home_dir(KEPT / "hypothesis")


def pytest_sessionstart(session):
    """Let each worker compile its share of the common kernels, in a process of its own.

    The process ends with all the memory that Numba keeps; the worker loads what the process left on
    disk.  If a kernel does not compile, a test tells.
    """
    worker = os.environ.get("PYTEST_XDIST_WORKER", "").removeprefix("gw")
    if worker:
        share = [worker, os.environ["PYTEST_XDIST_WORKER_COUNT"]]
        command = [sys.executable, "-W", "ignore", COMMON_KERNELS, *share]
        subprocess.run(command, stdin=subprocess.DEVNULL, check=False)


def pytest_configure(config):
    stderr = os.dup(2)  # nothing captures stderr yet

    def watched():
        config.stash[WATCH] = hanging.start(stderr)

    watched()
    if "PYTEST_XDIST_WORKER" in os.environ:
        config.pluginmanager.register(Apart(watched))


def pytest_runtest_setup(item):
    item.config.stash[WATCH][0].begin(item.nodeid)


WATCH = pytest.StashKey()
FAST = 80.0  # seconds of all tests of the fast tier: half a minute and the start on two cores
_seconds: dict = {}  # of each test of this run


def pytest_runtest_logreport(report):
    _seconds[report.nodeid] = _seconds.get(report.nodeid, 0.0) + report.duration


def pytest_sessionfinish(session):
    """Note how long each test took, for ``--fast``."""
    session.config.stash[WATCH][1].set()
    cache = getattr(session.config, "cache", None)  # without it: -p no:cacheprovider
    if cache is not None and "PYTEST_XDIST_WORKER" not in os.environ:
        cache.set("seconds", cache.get("seconds", {}) | _seconds)


@pytest.hookimpl(wrapper=True)
def pytest_collection_modifyitems(config, items):
    """Before markers deselect: ``few``.  After: ``--fast``, what was quickest in its last run."""
    addresses = [item.nodeid for item in items if " at 0x" in item.nodeid]
    if addresses:  # xdist asks each process for the same names
        raise pytest.UsageError(f"an address in the name of a test: {addresses[0]}")
    for _, group in itertools.groupby(items, lambda item: item.nodeid.partition("[")[0]):
        of_test = list(group)
        marker = of_test[0].get_closest_marker("few")
        for item in few.left_out(of_test, *marker.args) if marker else ():
            item.add_marker("hunt")
    yield
    if config.getoption("fast"):
        cache, total = getattr(config, "cache", None), 0.0
        known = cache.get("seconds", {}) if cache is not None else {}
        left_out = []
        for item in sorted(items, key=lambda item: known.get(item.nodeid, 0.0)):
            total += known.get(item.nodeid, 0.0)
            left_out += [item] if total > FAST else []
        config.hook.pytest_deselected(items=left_out)
        left_out = set(left_out)
        items[:] = [item for item in items if item not in left_out]


def pytest_collection_finish():
    """What is there before the first test stays: no collection of garbage looks at that again."""
    gc.collect()
    gc.freeze()


def pytest_addoption(parser):
    parser.addoption("--draws", type=int, default=2, help="functions drawn across processes")
    parser.addoption("--all-modes", action="store_true", help="of everyday functions, too")
    parser.addoption("--fast", action="store_true", help="the quickest tests, of one minute")
    parser.addoption("--whole-corpus", action="store_true", help="all cases of bench/corpus")


@pytest.fixture(scope="module", autouse=True)
def memory_goes():
    """A file of tests leaves nothing: no functions that fastdyn remembers, and no garbage.

    The thresholds above would never look at old garbage.
    """
    yield
    from fastdyn.compile import memory

    memory.forget()
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def memory_is_poisoned(monkeypatch):
    """What a kernel reads before it is written is NaN."""
    monkeypatch.setattr("fastdyn.run.laid_out.new_memory", lambda size: np.full(size, np.nan))


@pytest.fixture(autouse=True)
def nothing_asks_what_lives(monkeypatch):
    """After a function that asks, each refusal of the process collects garbage: of this test."""
    monkeypatch.setattr("fastdyn.compile.traced.make._asks_what_lives", threading.Event())


@pytest.fixture
def nothing_known(monkeypatch):
    """No call has come before: the kept runs are forgotten."""
    from fastdyn.compile.memory import Table

    monkeypatch.setattr("fastdyn.run.again.calls", Table())


@pytest.fixture
def wrong_choices(monkeypatch):
    """Code with three times what is right on one side, and a first comparison that sees nothing."""
    from fastdyn.trace.graph.expressions import Graph

    select = Graph.select

    def wrong(g, condition, a, b):
        return select(g, condition, a, g.mul(g.const(3.0), b))

    monkeypatch.setattr(Graph, "select", wrong)
    monkeypatch.setattr("fastdyn.compile.traced.make.compare_around", lambda *_: None)


@pytest.fixture
def wrong_products(monkeypatch):
    """Code whose products with 3 are products with 3.003."""
    from fastdyn.trace.graph.expressions import Graph

    mul = Graph.mul

    def wrong(g, a, b):
        a, b = [g.const(3.003) if x.op == "const" and x.data == 3.0 else x for x in (a, b)]
        return mul(g, a, b)

    monkeypatch.setattr(Graph, "mul", wrong)


@pytest.fixture
def no_comparisons(monkeypatch):
    """Code is used as it is: a comparison would leave a function to Python that it gets wrong."""
    monkeypatch.setattr("fastdyn.compile.traced.make.compare_around", lambda *_: None)
    monkeypatch.setattr("fastdyn.run.functions.compared.WHEN", "never")


@pytest.fixture
def no_wrong_code():
    """The comparisons of a test find no wrong code."""
    from fastdyn.compile.traced.known import N_WRONG

    before = N_WRONG[0]
    yield
    assert N_WRONG[0] == before, "machine code was wrong, was found and was set aside"
