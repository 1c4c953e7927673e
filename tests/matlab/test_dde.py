"""dde23 and ddesd with MATLAB's calls."""

import numpy as np
import pytest

from fastdyn.matlab import dde23, ddesd, deval, odeset

# Wille and Baker's example 3, as of dde23's documentation, at t = 5 to 8 digits: by JiTCDDE.
AT_5 = [19.174998, 176.42253, 190.34415]


def wille_and_baker(t, y, Z):
    return [Z[0, 0], Z[0, 0] + Z[1, 1], y[1]]


def test_the_example_of_dde23():
    options = odeset(RelTol=1e-8, AbsTol=1e-10)
    sol = dde23(wille_and_baker, [1, 0.2], [1, 1, 1], [0, 5], options)
    np.testing.assert_allclose(deval(sol, 5), AT_5, rtol=1e-6)
    t, y = dde23(wille_and_baker, [1, 0.2], lambda t: [1, 1, 1], [0, 2.5, 5], options)
    assert t.tolist() == [0, 2.5, 5]
    np.testing.assert_allclose(y[-1], AT_5, rtol=1e-6)


def test_ddesd_takes_functions_and_numbers():
    options = odeset(RelTol=1e-8, AbsTol=1e-10)
    constant = ddesd(wille_and_baker, [1, 0.2], [1, 1, 1], [0, 5], options)
    np.testing.assert_allclose(deval(constant, 5), AT_5, rtol=1e-6)
    moving = ddesd(
        lambda t, y, Z: [-Z[0, 0] + np.sin(t - 0.5 - 0.4 * y[0] ** 2) + np.cos(t)],
        lambda t, y: [t - 0.5 - 0.4 * y[0] ** 2], lambda t: [np.sin(t)], [0, 5], options,
    )  # fmt: skip
    np.testing.assert_allclose(deval(moving, 5), [np.sin(5)], rtol=1e-6)


def test_a_solution_goes_on():
    options = odeset(RelTol=1e-8, AbsTol=1e-10)
    first = dde23(wille_and_baker, [1, 0.2], [1, 1, 1], [0, 3], options)
    rest = dde23(wille_and_baker, [1, 0.2], first, [3, 5], options)
    np.testing.assert_allclose(deval(rest, 5), AT_5, rtol=1e-5)


def test_lags_are_positive():
    with pytest.raises(ValueError, match="`lags` must be positive"):
        dde23(wille_and_baker, [1, 0.0], [1, 1, 1], [0, 5])
