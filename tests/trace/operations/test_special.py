"""Special functions in compiled code are SciPy's own: the same bits."""

import numpy as np
import pytest
import scipy.special

from fastdyn.compile.bind import bind
from fastdyn.compile.compare import machine_value
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.make import Near
from fastdyn.trace.operations.special import OF_ONE, OF_TWO

STATES = np.random.default_rng(1).normal(scale=3.0, size=(50, 2))
NAMES = [(name, n) for n, names in ((1, OF_ONE), (2, OF_TWO)) for name in names.split()]


@pytest.mark.few(8)
@pytest.mark.parametrize(("name", "n"), NAMES)
def test_a_function_has_the_bits_of_scipy(name, n):
    function = getattr(scipy.special, name)
    assert function.nin == n

    def fun(t, y):
        return [function(*y[:n]), t]

    bound = bind(fun, (), DERIVATIVE, 2, Near(0.0, 1.0, np.array([0.4, 0.6])))
    assert bound.function is not None and bound.function.traced is not None
    for y in STATES:
        found, expected = machine_value(bound, 0.5, y), np.array(fun(0.5, y))
        assert np.array_equal(found, expected, equal_nan=True)
