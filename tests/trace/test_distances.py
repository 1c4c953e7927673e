"""Distances of points, and arrays of iterators, that depend on the state."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.distance import cdist, pdist, squareform

from fastdyn.compile.bind import bind
from fastdyn.compile.compare import machine_value
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.make import Near

POINTS = np.random.default_rng(0).normal(size=(4, 2))
KINDS = "euclidean", "sqeuclidean", "cityblock", "chebyshev"


def points(y):
    return y.reshape(-1, 2)


FUNCTIONS = {
    **{k: lambda y, k=k: np.exp(-cdist(points(y), POINTS, k)).sum() * y for k in KINDS},
    **{f"pairs, {k}": lambda y, k=k: pdist(points(y), metric=k).mean() * y for k in KINDS},
    "among themselves": lambda y: (cdist(points(y), points(y)) @ points(y)).ravel(),
    "a matrix": lambda y: (squareform(pdist(points(y))) @ points(y)).ravel(),
    "values of a dict": lambda y: np.fromiter({i: -v for i, v in enumerate(y)}.values(), float),
    "a map": lambda y: np.fromiter(map(abs, y), float, count=len(y)),
}


@pytest.mark.few(5)
@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("n", [6, 80])
def test_code_is_the_function(name, n):
    fun, rng = FUNCTIONS[name], np.random.default_rng(1)
    near = Near(0.0, 1.0, rng.normal(size=n), True)
    bound = bind(lambda t, y: fun(y), (), DERIVATIVE, n, near)
    assert bound.function is not None and bound.function.traced is not None
    for _ in range(5):
        y = rng.normal(size=n)
        found: Any = machine_value(bound, 0.0, y)
        np.testing.assert_allclose(found, fun(y), rtol=1e-12, atol=1e-13)
