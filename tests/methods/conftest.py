"""What tests of methods ask for by name."""

import pytest

from fastdyn.solve import by_method


@pytest.fixture
def nothing_is_left_to_scipy(monkeypatch):
    """Solves that call SciPy's methods fail."""

    def refused(asked, method):
        raise AssertionError(f"{method} is left to SciPy")

    monkeypatch.setattr(by_method, "by_scipy", refused)
