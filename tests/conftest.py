"""All workers share one cache of compiled code; it is kept from one run to the next."""

import os
import pathlib

import hypothesis.configuration
import matplotlib

matplotlib.use("Agg")

KEPT = pathlib.Path(__file__).parent.parent / ".pytest_cache"
os.environ.setdefault("NUMBA_CACHE_DIR", str(KEPT / "compiled"))
hypothesis.configuration.set_hypothesis_home_dir(KEPT / "hypothesis")


def pytest_addoption(parser):
    parser.addoption("--draws", type=int, default=8, help="functions drawn across processes")
