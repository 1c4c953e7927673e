"""Claims about signs in other words: "auto" slides along each as along np.sign."""

import math

import numpy as np
import pytest

from fastdyn import solve_ivp

SIGNS = {
    "x / abs(x)": lambda x: x / abs(x),
    "guarded": lambda x: x / abs(x) if abs(x) > 1e-12 else 0.0,
    "x / sqrt(x * x)": lambda x: x / math.sqrt(x * x),
    "abs(x) / x": lambda x: abs(x) / x,
    "copysign": lambda x: math.copysign(1.0, x),
    "np.copysign": lambda x: np.copysign(1.0, x),
    "heaviside": lambda x: 2.0 * np.heaviside(x, 0.5) - 1.0,
}


@pytest.mark.parametrize("name", SIGNS)
def test_a_relay_by_another_sign(name):
    sign = SIGNS[name]

    def fun(t, y):
        return [-2.0 * sign(y[0] - 0.3) + 0.5 * np.sin(t)]

    run = solve_ivp(fun, (0, 5), [1.0], "auto", rtol=1e-6, atol=1e-8)
    assert run.success and run.y[0, -1] == pytest.approx(0.3, abs=1e-6)
    assert run.nfev < 2000 and "Filippov" in run.reason


@pytest.mark.parametrize("name", SIGNS)
def test_friction_by_another_sign(name):
    """An oscillator with dry friction comes to rest where the spring is weaker than friction."""
    sign = SIGNS[name]

    def friction(t, y, sign):
        return [y[1], -y[0] - 0.2 * sign(y[1])]

    given = {"method": "auto", "rtol": 1e-6, "atol": 1e-8}
    run = solve_ivp(friction, (0, 20), [1.0, 0.5], args=(sign,), **given)
    right = solve_ivp(friction, (0, 20), [1.0, 0.5], args=(np.sign,), **given)
    assert run.success and run.nfev < 5000
    assert run.y[:, -1] == pytest.approx(right.y[:, -1], abs=1e-5)
