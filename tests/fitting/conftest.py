"""Each test closes its figures."""

import pytest


@pytest.fixture(autouse=True)
def figures_are_closed():
    yield
    from matplotlib import pyplot

    pyplot.close("all")
