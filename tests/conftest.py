"""Each test process has a cache of compiled code of its own, filled once and kept for its life."""

import os
import pathlib
import tempfile

import matplotlib

matplotlib.use("Agg")

BASE = os.environ.get("NUMBA_CACHE_DIR") or tempfile.mkdtemp(prefix="fastdyn-tests-")
WORKER = os.environ.get("PYTEST_XDIST_WORKER", "main")
os.environ["NUMBA_CACHE_DIR"] = str(pathlib.Path(BASE, WORKER))
