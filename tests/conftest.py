"""All workers share one cache of compiled code; it is kept from one run to the next."""

import os
import pathlib

import hypothesis.configuration
import matplotlib
import pytest

matplotlib.use("Agg")

KEPT = pathlib.Path(__file__).parent.parent / ".pytest_cache"
os.environ.setdefault("NUMBA_CACHE_DIR", str(KEPT / "compiled"))
hypothesis.configuration.set_hypothesis_home_dir(KEPT / "hypothesis")


def pytest_addoption(parser):
    parser.addoption("--draws", type=int, default=12, help="functions drawn across processes")


@pytest.hookimpl(tryfirst=True)  # before xdist reads the marks
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
