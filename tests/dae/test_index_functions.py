"""Functions as people write them, and their comparison with what index reduction computes."""

import functools

import numpy as np
import pytest

from fastdyn import solve_dae
from fastdyn.dae.reduced.compare import check_with_function
from support.mechanisms import pendulum

reduced = functools.partial(solve_dae, method="DOP853")
START = [1.0, 0, 0, 0, 0]


class Pendulum:
    def __init__(self, length):
        self.length = length

    def __call__(self, t, y, yp, g):
        q, v, force = y[:2], y[2:4], y[4]
        return np.concatenate(
            [yp[:2] - v, yp[2:4] + force * q + np.array([0, g]), [q @ q - self.length**2]]
        )


@pytest.fixture(scope="module")
def swung():
    return reduced(pendulum, (0, 1), START, args=(1.0, 9.81))


@pytest.mark.parametrize("fun, args", [
    (Pendulum(1.0), (9.81,)),
    (Pendulum(1.0).__call__, (9.81,)),
    (lambda t, y, yp, p: pendulum(t, y, yp, *p), (np.array([1.0, 9.81]),)),
    (lambda t, y, yp, p: pendulum(t, y, yp, p["l"], p["g"]), ({"l": 1, "g": 9.81},)),
])  # fmt: skip
def test_functions_in_every_form(fun, args, swung):
    found = reduced(fun, (0, 1), START, args=args)
    assert abs(found.y[:, -1] - swung.y[:, -1]).max() < 1e-9


def test_derivatives_are_in_the_result(swung):
    x, z, u, v, force = swung.y
    assert abs(swung.yp[:4] - [u, v, -force * x, -force * z - 9.81]).max() < 1e-12
    assert np.isnan(swung.yp[4]).all()  # the equations have no derivative of the force


def test_a_solution_is_compared_with_the_function(swung):
    check_with_function(pendulum, (1.0, 9.81), swung)
    with pytest.raises(ValueError, match="equations 4 do not hold"):
        check_with_function(pendulum, (1.01, 9.81), swung)
    with pytest.raises(ValueError, match="equations 3 do not hold"):
        check_with_function(pendulum, (1.0, 9.9), swung)
