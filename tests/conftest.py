"""All workers share one cache of compiled code; it is kept from one run to the next."""

import gc
import os
import pathlib
import signal
import sys
import threading

import hypothesis.configuration
import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")
gc.set_threshold(100_000, 20, 100)  # compiling makes many small objects that live long

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # started in the background of a shell
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Bytecode is kept: two workers import the tests, hundreds of processes import the package.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

KEPT = pathlib.Path(__file__).parent.parent / ".pytest_cache"
os.environ.setdefault("NUMBA_CACHE_DIR", str(KEPT / "compiled"))
os.environ.setdefault("FASTDYN_BUDGET", "inf")  # compiled code is there at once
os.environ.setdefault("DASK_TEMPORARY_DIRECTORY", str(KEPT / "dask"))
hypothesis.configuration.set_hypothesis_home_dir(KEPT / "hypothesis")


def pytest_sessionstart(session):
    """Let each worker compile its share of the kernels that all of them use.

    Those with matrices have most of their parts in common: one process compiles them all.
    """
    worker = os.environ.get("PYTEST_XDIST_WORKER", "").removeprefix("gw")
    if not worker:
        return
    others = int(os.environ["PYTEST_XDIST_WORKER_COUNT"]) - 1
    from fastdyn.kernels.methods import METHODS
    from fastdyn.specialise import scalar

    plain = [name for name, method in METHODS.items() if method.n_matrices == 0]
    with_matrices = [name for name in METHODS if name not in plain]
    mine = plain[int(worker) - 1 :: others] if int(worker) else with_matrices
    for name in mine:
        kernels = scalar.start_kernel, scalar.dense_rows_kernel, scalar.shared_kernel
        for kernel in kernels[: 2 if METHODS[name].series else 3]:
            kernel(name)
    if int(worker) == 0:
        watches = scalar.watch_plain_kernel, scalar.watch_events_kernel, scalar.watch_kernel
        for kernel in (*watches, scalar.whole_solve_kernel):
            kernel()


def pytest_collection_finish():
    """What is there before the first test stays: no collection of garbage looks at that again."""
    gc.collect()
    gc.freeze()


def pytest_addoption(parser):
    parser.addoption("--draws", type=int, default=2, help="functions drawn across processes")
    parser.addoption("--all-modes", action="store_true", help="of everyday functions, too")
    parser.addoption("--whole-corpus", action="store_true", help="all cases of bench/corpus")


@pytest.fixture(autouse=True)
def memory_is_poisoned(monkeypatch):
    """What a kernel reads before it is written is NaN."""
    monkeypatch.setattr("fastdyn.run.laid_out.new_memory", lambda size: np.full(size, np.nan))


@pytest.fixture(autouse=True)
def nothing_asks_what_lives(monkeypatch):
    """After a function that asks, each refusal of the process collects garbage: of this test."""
    monkeypatch.setattr("fastdyn.compile.traced.make._asks_what_lives", threading.Event())


@pytest.fixture
def wrong_choices(monkeypatch):
    """Code with three times what is right on one side, and a first comparison that sees nothing."""
    from fastdyn.trace.graph.expressions import Graph

    select = Graph.select

    def wrong(g, condition, a, b):
        return select(g, condition, a, g.mul(g.const(3.0), b))

    monkeypatch.setattr(Graph, "select", wrong)
    monkeypatch.setattr("fastdyn.compile.traced.make.compare_around", lambda *_: None)
