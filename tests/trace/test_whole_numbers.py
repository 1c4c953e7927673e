"""A derivative that is stored in an array of whole numbers loses its fraction, with a warning."""

import warnings

import numpy as np
import pytest

from fastdyn import solve_ivp


def whole(t, w):
    rates = np.array([0, 0])
    rates[0] = w[1]
    rates[1] = -2.5 * w[0]
    return rates


def whole_zeros(t, w):
    rates = np.zeros(2, dtype=int)
    rates[0], rates[1] = w[1], -2.5 * w[0]
    return rates


def floats(t, w):
    rates = np.array([0.0, 0.0])
    count = np.array([0, 0])
    count[0] = 1
    rates[0] = w[1]
    return rates


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("function", [whole, whole_zeros])
def test_a_cut_fraction_is_warned_of(function):
    with pytest.warns(UserWarning, match="array of whole numbers, which cuts its fraction"):
        solve_ivp(function, (0, 1), [1.5, 2.3])


def test_other_arrays_are_not_warned_of():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert solve_ivp(floats, (0, 1), [1.5, 2.3]).success
