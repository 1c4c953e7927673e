"""np.sinc: its values, its derivative and its Taylor series where sin(u) / u is 0 / 0."""

import numpy as np
import pytest

from fastdyn import solve_ivp


def through_zero(t, y, at):
    return [np.sinc(y[0] - at)]


def test_values_are_those_of_numpy():
    """One step of RK4 of a function of t alone is Simpson's rule."""
    at = np.r_[0.0, 1e-300, 1e-8, np.linspace(-3.0, 3.0, 401), 0.3183098861837907]
    for x in at:
        found = solve_ivp(lambda t, y, x: [np.sinc(x + 0 * t)], (0, 1), [0.0], "RK4", step=1.0,
                          args=(float(x),)).y[0, -1]  # fmt: skip
        assert abs(found - np.sinc(x)) <= 4 * np.finfo(float).eps


@pytest.mark.parametrize("y0", [0.0, 0.499, 0.5 - 1e-9, 0.5])
@pytest.mark.parametrize("rtol", [1e-6, 1e-12])
def test_a_series_passes_the_removable_point(y0, rtol):
    run = solve_ivp(through_zero, (0, 2), [y0], "Taylor", args=(0.5,), rtol=rtol, atol=rtol)
    other = solve_ivp(through_zero, (0, 2), [y0], "DOP853", args=(0.5,), rtol=1e-13, atol=1e-13)
    assert run.status == 0 and abs(run.y[0, -1] - other.y[0, -1]) < 20 * rtol


def test_the_derivative_at_the_removable_point():
    """s' = sinc'(y - a) s, and -s for the place: at rest in time, dy/da = 1 - dy/dy0."""
    given = {"args": (0.5,), "rtol": 1e-11, "atol": 1e-12, "sensitivity": ("y0", "args[0]")}
    run = solve_ivp(through_zero, (0, 2), [0.5], "DOP853", **given)
    by_start, by_place = (run.sensitivity[name][0, ..., -1] for name in ("y0", "at"))
    assert np.allclose(by_start, np.sinc(run.y[0, -1] - 0.5), rtol=1e-9)
    assert np.allclose(by_place, 1 - by_start[0], atol=1e-9)
