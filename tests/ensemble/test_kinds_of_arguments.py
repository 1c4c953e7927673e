"""Truth values and whole numbers that differ between trajectories stay what they are."""

import numpy as np
import pytest

from fastdyn import solve_ensemble, solve_ivp

GIVEN = {"rtol": 1e-8, "atol": 1e-10}


def either(t, y, on):
    return [-y[0] if on else 0.1 * y[0]]


def branched(t, y, on):
    if not on:
        return [0.1 * y[0]]
    return [-y[0]]


def chosen(t, y, on):
    return [np.where(on, -y[0], 0.1 * y[0])]


def indexed(t, y, on):
    return [-y[0] * (1.0, 2.0)[on]]


def counted(t, y, on):
    return [-y[0] * (on + on)]


def inverted(t, y, on):
    return [-y[0] * ~on]


def and_more(t, y, on):
    return [-y[0] * (on and 0.5)]


def identical(t, y, on):
    return [-y[0] if on is True else 0.1 * y[0]]


def asked_for_its_kind(t, y, on):
    return [-y[0] * isinstance(on, bool)]


@pytest.mark.few
@pytest.mark.filterwarnings("ignore:.*cannot be compiled")
@pytest.mark.filterwarnings("ignore:Bitwise inversion:DeprecationWarning")
@pytest.mark.parametrize("first", [True, False])
@pytest.mark.parametrize(
    "fun",
    [either, branched, chosen, indexed, counted, inverted, and_more, identical, asked_for_its_kind],
)
def test_truth_values(fun, first):
    on = [first, not first, first]
    run = solve_ensemble(fun, (0, 1), np.ones((3, 1)), args=(on,), **GIVEN)
    for value, y in zip(on, run.y[:, 0], strict=True):
        alone = solve_ivp(fun, (0, 1), [1.0], args=(value,), **GIVEN).y[0, -1]
        assert np.isclose(y, alone, rtol=1e-7)


@pytest.mark.parametrize("first", [True, False])
def test_truth_values_in_lanes(first):
    """A truth value that differs is a number of the lanes, no part of the code."""
    on = [first, not first] * 4
    run = solve_ensemble(either, (0, 1), np.ones((8, 1)), args=(on,), simd=True, **GIVEN)
    assert np.allclose(run.y[:, 0], np.where(on, np.exp(-1.0), np.exp(0.1)), rtol=1e-7)


def long_loop(t, y, on):
    total = 0.0
    for i in range(3000):
        if y[0] > i:
            total += 1.0
    return [-y[0] if on else 0.1 * y[0] * min(total, 1.0)]


def test_truth_values_in_code_of_numba():
    """Numba's code holds the first truth value: the function runs in Python instead."""
    with pytest.warns(UserWarning, match="differs between trajectories is True or False"):
        run = solve_ensemble(long_loop, (0, 0.1), np.ones((2, 1)), args=([True, False],), rtol=1e-2)
    assert np.allclose(run.y[:, 0], np.exp([-0.1, 0.01]), rtol=1e-2)


def test_whole_numbers_that_floats_do_not_hold_are_refused():
    def last_digit(t, y, n):
        return [-y[0] * (n % 10)]

    near = [3, 2**53]
    run = solve_ensemble(last_digit, (0, 1), np.ones((2, 1)), args=(near,), **GIVEN)
    assert np.allclose(run.y[:, 0], np.exp([-3.0, -2.0]), atol=1e-7)
    with pytest.raises(ValueError, match=r"`args\[0\]` has whole numbers beyond 2\*\*53"):
        solve_ensemble(last_digit, (0, 1), np.ones((2, 1)), args=([3, 2**60 + 1],))
