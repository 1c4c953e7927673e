"""Neutral equations: the derivative of the past, beside exact solutions."""

import numpy as np
import pytest

from fastdyn import CompileWarning
from fastdyn.delays import solve_dde
from fastdyn.delays.points import followed
from fastdyn.delays.sensitive import NEUTRAL

TENFOLD = 10.0


def sine(t):
    return [np.sin(t)]


@pytest.mark.parametrize("method", NEUTRAL)
def test_a_derivative_of_the_past(method):
    """y = sin t, which begins without a jump."""

    def fun(t, y, past):
        return 0.5 * past.derivative(t - 0.7) + np.cos(t) - 0.5 * np.cos(t - 0.7)

    for rtol in (1e-4, 1e-9):
        found = solve_dde(fun, (0, 10), sine, method, rtol=rtol, atol=rtol)
        assert abs(found.y[0, -1] - np.sin(10)) < TENFOLD * rtol


@pytest.mark.parametrize("method", NEUTRAL)
def test_jumps_of_the_derivative_stay(method):
    """y' = y'(t - 1) jumps by 1 - cos(1) at each whole time, and never gets smoother.

    An error of a step comes back in each later interval: a bound is the sum over steps and
    intervals of a tolerance each.
    """
    for whole in (5, 30):
        found = solve_dde(
            lambda t, y, past: past.derivative(t - 1.0), (0, whole + 0.5), sine, method,
            rtol=1e-9, atol=1e-9,
        )  # fmt: skip
        exact = whole * np.sin(1) + np.sin(-0.5) - np.sin(-1)
        assert abs(found.y[0, -1] - exact) < 1e-9 * whole * len(found.t)
        assert set(range(whole + 1)) <= set(found.t.round(12).tolist())


def test_other_delays_smooth_what_a_neutral_one_repeats():
    """Levels of jumps: a delay of 0.4 adds one, up to the order; one of 1 none."""
    points, _ = followed([0.0], (0.4, 1.0), 0.0, 3.0, 2, (1.0,))
    levels = {round(0.4 * k + m, 12) for k in range(3) for m in range(5)}
    assert points.round(12).tolist() == sorted(p for p in levels if 0 < p < 3)


def test_a_history_has_its_derivative():
    def fun(t, y, past):
        return past.derivative(t - 2.0)

    tight = {"rtol": 1e-10, "atol": 1e-12, "method": "Vern7"}
    exact = np.sin(-1.0) - np.sin(-2.0)
    traced = solve_dde(fun, (0, 1), sine, **tight)
    assert abs(traced.y[0, -1] - exact) < 1e-9
    assert solve_dde(fun, (0, 1), [3.0], **tight).y[0, -1] == 3.0

    def hidden(t):
        return [float(str(np.sin(t)))]

    with pytest.raises(ValueError, match=r"give `history\.derivative`"):
        solve_dde(fun, (0, 1), hidden, **tight)
    hidden.derivative = np.cos
    given = solve_dde(fun, (0, 1), hidden, **tight)
    assert abs(given.y[0, -1] - exact) < 1e-9
    whole = solve_dde(fun, (0, 3), sine, **tight)
    first = solve_dde(fun, (0, 1), sine, dense_output=True, **tight)
    rest = solve_dde(fun, (1, 3), first, **tight)
    assert abs(rest.y[0, -1] - whole.y[0, -1]) < 1e-9


def test_a_neutral_function_in_python():
    def hidden(t, y, past):
        return [float(str(past.derivative(t - 1.0)[0]))]

    with pytest.warns(CompileWarning):
        found = solve_dde(hidden, (0, 4.5), sine, "Vern7", delays=[1.0], rtol=1e-9, atol=1e-9)
    traced = solve_dde(
        lambda t, y, past: past.derivative(t - 1.0), (0, 4.5), sine, "Vern7", rtol=1e-9, atol=1e-9
    )
    np.testing.assert_array_equal(found.y, traced.y)


def test_methods_of_imprecise_derivatives_are_refused():
    def fun(t, y, past):
        return past.derivative(t - 1.0)

    with pytest.raises(ValueError, match="'Tsit5'` does not solve neutral equations"):
        solve_dde(fun, (0, 2), sine, "Tsit5")
    found = solve_dde(fun, (0, 2), sine, rtol=1e-3, atol=1e-3)  # "auto" has Vern7
    assert abs(found.y[0, -1] - 2 * np.sin(1)) < TENFOLD * 1e-3
