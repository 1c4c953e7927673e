"""Steps that cannot move the time are refused or fail."""

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn import solve_ensemble, solve_ivp
from fastdyn.kernels.methods import METHODS

ADAPTIVE = [name for name, m in METHODS.items() if m.error_order]


@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_longest_step_below_the_spacing_of_t_fails(method):
    r = solve_ivp(lambda t, y: -y, (5, 9), [1.0], method, max_step=1e-20)
    assert r.status == -1 and "max_step=1e-20" in r.message and r.n_accepted < 2
    if method in ("RK23", "RK45", "DOP853"):
        s = scipy.integrate.solve_ivp(lambda t, y: -y, (5, 9), [1.0], method, max_step=1e-20)
        assert s.status == -1 and s.message in r.message and s.nfev == r.nfev


@pytest.mark.parametrize("simd", [False, True])
def test_such_a_step_fails_in_ensembles(simd):
    states = np.ones((9, 1))
    many = solve_ensemble(lambda t, y: [-y[0]], (5, 9), states, max_step=1e-20, simd=simd)
    assert not many.success.any() and (many.nfev == 8).all()


def test_runs_that_would_never_end_are_refused():
    given = {"y0": [1.0], "invariants": {"y": lambda t, y: y[0]}}
    with pytest.raises(ValueError, match="would take centuries"):
        fastdyn.energy_drift(lambda t, y: [-y[0]], "RK45", t_end=9.0, max_step=1e-300, **given)
    with pytest.raises(ValueError, match="would take centuries"):
        solve_ivp(lambda t, y: [-y[0]], (0, 9), [1.0], max_step=1e-20)
    assert solve_ivp(lambda t, y: [-y[0]], (0, 9), [1.0], max_step=1e-20, max_steps=10).status == -1


@pytest.mark.parametrize("method", ["RK4", "VelocityVerlet", "Gauss4"])
def test_a_constant_step_below_the_spacing_of_t_is_refused(method):
    with pytest.raises(ValueError, match="the time would stand still"):
        solve_ivp(lambda t, y: [y[1], -y[0]], (5, 9), [1.0, 0.0], method, step=1e-20)
