"""SciPy's special functions are called from compiled code, with SciPy's numbers."""

import numpy as np
import pytest
import scipy.integrate
import scipy.special

import fastdyn
from fastdyn.trace.operations.special import OF_MORE, OF_ONE

ORDERS = {"kn": (2,), "expn": (2,)}  # of whole numbers; others are (1.5, 2.5, 0.5)
NEAR = np.array([0.2, 0.6, 0.9])


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
@pytest.mark.parametrize("name", (OF_ONE + " " + OF_MORE).split())
def test_numbers_are_scipys(name):
    """Code and function are compared; with equal steps values differ by roundings."""
    special = getattr(scipy.special, name)
    before = ORDERS.get(name, (1.5, 2.5, 0.5)[: special.nin - 1])

    def fun(t, y):
        return np.tanh(special(*before, NEAR + 1e-3 * y)) - y

    steps: dict = {"first_step": 1 / 16, "max_step": 1 / 16, "atol": 1e3}
    mine = fastdyn.solve_ivp(fun, (0.0, 1.0), NEAR, **steps)
    theirs = scipy.integrate.solve_ivp(fun, (0.0, 1.0), NEAR, **steps)
    np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-13)
