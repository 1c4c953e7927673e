"""A place for a store, where Zarr is installed."""

import pytest


@pytest.fixture
def store(tmp_path):
    pytest.importorskip("zarr", reason="needs zarr")
    return tmp_path / "run.zarr"
