"""All workers share one cache of compiled code; it is kept from one run to the next."""

import gc
import os
import pathlib
import signal

import hypothesis.configuration
import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")
gc.set_threshold(100_000, 20, 100)  # compiling makes many small objects that live long

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # started in the background of a shell
    signal.signal(signal.SIGINT, signal.default_int_handler)

KEPT = pathlib.Path(__file__).parent.parent / ".pytest_cache"
os.environ.setdefault("NUMBA_CACHE_DIR", str(KEPT / "compiled"))
os.environ.setdefault("DASK_TEMPORARY_DIRECTORY", str(KEPT / "dask"))
hypothesis.configuration.set_hypothesis_home_dir(KEPT / "hypothesis")


def pytest_sessionstart(session):
    """Let each worker compile its share of the kernels that all of them use."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "").removeprefix("gw")
    if not worker:
        return
    count = int(os.environ["PYTEST_XDIST_WORKER_COUNT"])
    from fastdyn.kernels.methods import METHODS
    from fastdyn.specialise.scalar import dense_rows_kernel, shared_kernel, start_kernel

    for name, method in list(METHODS.items())[int(worker) :: count]:
        for kernel in (start_kernel, dense_rows_kernel, *[shared_kernel] * (not method.series)):
            kernel(name)


def pytest_addoption(parser):
    parser.addoption("--draws", type=int, default=4, help="functions drawn across processes")
    parser.addoption("--all-modes", action="store_true", help="of everyday functions, too")
    parser.addoption("--whole-corpus", action="store_true", help="all cases of bench/corpus")


@pytest.fixture(autouse=True)
def memory_is_poisoned(monkeypatch):
    """What a kernel reads before it is written is NaN."""
    monkeypatch.setattr("fastdyn.run.laid_out.new_memory", lambda size: np.full(size, np.nan))
