"""A start that the constraints forbid."""

import warnings

import numpy as np
import pytest

from fastdyn.systems import pendulum_xy, vehicle


def test_a_start_off_the_constraints_is_warned_of_or_projected():
    car, slipping = vehicle(), [0.0, 0.0, 0.0, 1.0, 0.5, 0.0]
    with pytest.warns(UserWarning, match=r"`front_slip` is 0.597, `rear_slip` is 0.5"):
        car.solve((0, 1), slipping)
    held = car.solve((0, 1), slipping, project=True)
    assert max(np.abs(v).max() for v in held.residuals().values()) < 1e-15
    pendulum = pendulum_xy()
    start = np.array(pendulum.initial_state())
    with pytest.warns(UserWarning, match="this is trajectory 1"):
        pendulum.ensemble((0, 1), np.outer([1.0, 1.01], start))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pendulum.solve((0, 1), start)
        car.solve((0, 1), car.rolling(2.0))
        car.ensemble((0, 1), [car.rolling(1.0), car.rolling(2.0)])
