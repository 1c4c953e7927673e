"""A step is shortened where the derivative at its end is no number, as in SciPy."""

import numpy as np
import pytest
import scipy.integrate

from fastdyn import solve_ensemble, solve_ivp

METHODS = ["RK23", "RK45", "DOP853", "Tsit5", "Vern7", "Vern9", "ode45"]


def drains(t, y):
    return [-np.sqrt(y[0]) if y[0] > 0.3 else -np.sqrt(y[0] - 0.29999), 1.0]


@pytest.mark.few(4)
@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
@pytest.mark.parametrize("method", METHODS)
def test_a_step_does_not_end_where_the_next_cannot_begin(method, rtol):
    given, how = (drains, (0, 1.5), [1.0, 0.0]), {"rtol": rtol, "max_step": 1.0}
    ours = solve_ivp(*given, method, **how)
    assert ours.success, ours.message
    known = method if method in ("RK23", "RK45", "DOP853") else "RK45"
    theirs = scipy.integrate.solve_ivp(*given, known, **how)
    assert abs(ours.y[0, -1] - theirs.y[0, -1]) < 1e-2
    if known == method:  # the search for the edge amplifies rounding: SciPy's own counts differ
        starts = 1.0 + np.arange(-5, 6) * np.finfo(float).eps
        solves = [scipy.integrate.solve_ivp(*given[:2], [y, 0.0], known, **how) for y in starts]
        counts = [solve.nfev for solve in solves]
        assert 0.95 * min(counts) <= ours.nfev <= 1.05 * max(counts)
    many = solve_ensemble(*given[:2], np.array([given[2]] * 3), method=method, **how)
    assert many.success.all()
