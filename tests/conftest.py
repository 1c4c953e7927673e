"""Each test process has a cache of compiled code of its own, filled once and kept for its life."""

import os
import pathlib
import tempfile

import matplotlib
import pytest

matplotlib.use("Agg")

BASE = os.environ.get("NUMBA_CACHE_DIR") or tempfile.mkdtemp(prefix="fastdyn-tests-")
WORKER = os.environ.get("PYTEST_XDIST_WORKER", "main")
os.environ["NUMBA_CACHE_DIR"] = str(pathlib.Path(BASE, WORKER))


def pytest_collection_modifyitems(items):
    """Keep together what shares a fixture, or the kernels of a method: both are made once then."""
    from fastdyn.kernels import METHODS

    for item in items:
        call = getattr(item, "callspec", None)
        given = [v for v in call.params.values() if isinstance(v, str)] if call else []
        group = next((name for name in given if name in METHODS), None)
        fixtures = item._fixtureinfo.name2fixturedefs.values()
        if any(found[-1].scope == "module" for found in fixtures):
            group = item.path.stem
        if group is not None:
            item.add_marker(pytest.mark.xdist_group(group))
