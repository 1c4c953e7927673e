"""The estimate of the global error: beside the true one."""

import numpy as np
import pytest

from bench.problems.collection import WORK
from bench.problems.end_states import reference
from fastdyn import solve_ivp

FACTOR = 3.0


@pytest.mark.parametrize("tol", [1e-4, 1e-8])
@pytest.mark.parametrize("method", ["RK45", "DOP853"])
def test_it_is_within_a_factor_of_three_on_the_problems_of_the_benchmark(method, tol):
    for p in WORK:
        r = solve_ivp(
            p.fun, p.t_span, p.y0, method, args=p.args, rtol=tol, atol=tol, error_estimate=True
        )
        assert r.error_estimate.shape == r.y.shape
        if not r.success:
            continue  # Arenstorf's orbit may hit the moon
        true = np.linalg.norm(r.y[:, -1] - reference(p))
        estimate = np.linalg.norm(r.error_estimate[:, -1])
        assert true / FACTOR <= estimate <= true * FACTOR, p.name


def oscillator(t, y, k):
    return [y[1], -k * y[0]]


@pytest.mark.parametrize(
    "options",
    [
        {"method": "RK23"},
        {"method": "Radau"},
        {"method": "ode45"},
        {"method": "Vern9", "rtol": 1e-10, "atol": 1e-10},
        {"method": "RK4", "step": 0.1},
        {"method": "VelocityVerlet", "step": 0.05},
        {"method": "Gauss4", "step": 0.2},
        {"rtol": [1e-6, 1e-4], "atol": [1e-8, 1e-6]},
        {"t_eval": np.linspace(0, 10, 7), "dense_output": True},
        {"breakpoints": [1.0, 12.0], "max_steps": 500},
        {"vectorized": True},
        {"sensitivity": "k"},
    ],
    ids=lambda options: options.get("method", next(iter(options))),
)
def test_every_method_at_all_times(options):
    r = solve_ivp(oscillator, (0, 10), [1.0, 0.0], args=(4.0,), error_estimate=True, **options)
    true = np.linalg.norm(r.y - [np.cos(2 * r.t), -2 * np.sin(2 * r.t)], axis=0)
    estimate = np.linalg.norm(r.error_estimate, axis=0)
    known = true > 0.1 * true.max()  # where two errors pass through zero, at different times
    assert np.all(estimate[known] <= FACTOR * true[known])
    assert np.all(estimate[known] >= true[known] / FACTOR)
    assert ("sensitivity" in r) == ("sensitivity" in options)


def test_up_to_a_terminal_event_and_backwards():
    def stops(t, y):
        return y[0]

    stops.terminal = True
    fun = lambda t, y: [y[1], -4 * y[0]]  # noqa: E731
    r = solve_ivp(fun, (10, 0), [np.cos(20), -2 * np.sin(20)], events=stops, error_estimate=True)
    assert r.status == 1 and r.error_estimate.shape == r.y.shape
    true = r.y[0] - np.cos(2 * r.t)
    assert abs(r.error_estimate[0, -1] / true[-1] - 1) < 1


def test_complex_states():
    r = solve_ivp(lambda t, z: 1j * z, (0, 10), [1.0 + 0j], error_estimate=True)
    true = r.y[0, -1] - np.exp(10j)
    assert abs(r.error_estimate[0, -1] - true) < abs(true) / 2


def test_without_time_there_is_no_error():
    r = solve_ivp(oscillator, (0, 10), [1.0, 0.0], args=(4.0,), t_eval=[0.0], error_estimate=True)
    assert r.error_estimate.shape == (2, 1) and not r.error_estimate.any()
    assert "error_estimate" not in solve_ivp(oscillator, (0, 1), [1.0, 0.0], args=(4.0,))


def test_a_state_without_components_has_no_error():
    r = solve_ivp(lambda t, y: -y, (0, 1), [], error_estimate=True)
    assert r.error_estimate.shape == r.y.shape == (0, len(r.t))


def test_what_has_none_is_refused():
    given = {"args": (4.0,), "error_estimate": True}
    with pytest.raises(ValueError, match="`rtol` of at least 1e-12"):
        solve_ivp(oscillator, (0, 1), [1.0, 0.0], rtol=1e-13, **given)
    with pytest.raises(ValueError, match="jump at different times"):
        solve_ivp(
            oscillator, (0, 1), [1.0, 0.0], events=lambda t, y, k: y[0],
            on_event=lambda t, y, k: -y, **given,
        )  # fmt: skip
