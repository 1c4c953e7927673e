"""What tests of methods ask for by name."""

import pytest

from fastdyn.solve import by_method


@pytest.fixture
def nothing_is_left_to_scipy(monkeypatch, request):
    """Solves that call SciPy's methods fail, but in tests of sparse matrices."""
    if "sparse" not in request.node.name:
        monkeypatch.delattr(by_method, "by_scipy")
