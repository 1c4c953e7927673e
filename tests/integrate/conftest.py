"""The tests of odeint are tests of compiled code, unless they ask for `patience`."""

import pytest

from fastdyn.integrate import few


@pytest.fixture(autouse=True)
def at_once(request, monkeypatch):
    """Functions are compiled before their first evaluation."""
    if "patience" not in request.fixturenames:
        monkeypatch.setattr(few, "MOST", 0)


@pytest.fixture
def patience(monkeypatch):
    """Functions stay in Python for as many evaluations as outside tests; the counts begin anew."""
    monkeypatch.setattr(few, "_solves", few.memory.Table())
