"""Claims about `solve_dae`, by exact and by published solutions."""

import math
import pickle

import numpy as np
import pytest

from bench.problems.daes import AKZO_NOBEL, DAES
from fastdyn import CompileWarning, solve_dae, solve_ivp
from tests.support.daes import linear, linear_solution

TIGHT = {"rtol": 1e-9, "atol": 1e-11}
START = linear_solution(0.0)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("first_step", [None, 2.0])
def test_errors_follow_the_tolerance(rtol, first_step):
    """A first step that is too long is rejected.  Formulas of order 1 begin: y' to sqrt(rtol)."""
    run = solve_dae(linear, (0, 6), *START, rtol=rtol, atol=rtol, first_step=first_step)
    y, yp = linear_solution(run.t)
    assert run.success and np.abs(run.y - y).max() <= 8 * rtol
    assert first_step is None or run.n_rejected > 0
    late = run.t > 2.0
    assert np.abs(run.yp - yp).max() <= np.sqrt(rtol)
    assert np.abs(run.yp - yp)[:, late].max() <= 3 * rtol**0.8
    assert np.abs(run.y[0] + run.y[1] - np.sin(run.t)).max() <= rtol


@pytest.mark.parametrize("published", DAES, ids=lambda dae: dae.name)
@pytest.mark.parametrize("given", [None, "differential"])
def test_published_solutions(published, given):
    p = published
    atol = 1e-7 * np.asarray(p.floor)
    run = solve_dae(p.F, (0, p.end), p.y0, p.yp0, given=given, rtol=1e-7, atol=atol)
    assert run.success
    assert np.abs(run.y[:, -1] / p.solution - 1).max() <= 2e-5


def test_all_points_fulfil_the_equations():
    p = AKZO_NOBEL
    run = solve_dae(p.F, (0, p.end), p.y0, p.yp0, rtol=1e-8, atol=1e-12)
    residuals = [p.F(t, y, yp) for t, y, yp in zip(run.t, run.y.T, run.yp.T, strict=True)]
    assert np.abs(residuals).max() <= 1e-7


def test_an_ode_has_the_solution_of_solve_ivp():
    def pendulum(t, y):
        return [y[1], -9.81 * math.sin(y[0])]

    def implicit(t, y, yp):
        rate = pendulum(t, y)
        return [yp[0] - rate[0], yp[1] - rate[1]]

    times = np.linspace(0, 5, 11)
    exact = solve_ivp(pendulum, (0, 5), [1.0, 0.0], "DOP853", t_eval=times, rtol=1e-12, atol=1e-12)
    run = solve_dae(implicit, (0, 5), [1.0, 0.0], t_eval=times, **TIGHT)
    assert np.abs(run.y - exact.y).max() <= 1e-6
    assert np.array_equal(run.t, times)
    rates = [pendulum(0, y) for y in exact.y.T]
    assert np.abs(run.yp.T - rates).max() <= 1e-5


def test_a_derivative_may_occur_in_any_form():
    def cubic(t, y, yp):
        c = math.cos(t)
        return [yp[0] ** 3 + yp[0] - c**3 - c]

    run = solve_dae(cubic, (0, 5), [0.0], [0.9], given="y", **TIGHT)
    assert np.abs(run.y[0] - np.sin(run.t)).max() <= 1e-7
    run = solve_dae(lambda t, y, yp: [t * yp[0] ** 2 - y[0]], (1, 4), [1.0], [1.0], **TIGHT)
    assert np.abs(run.y[0] - run.t).max() <= 1e-8


def test_time_may_run_backwards():
    y, yp = linear_solution(2.0)
    run = solve_dae(linear, (2.0, 0.0), y, yp, **TIGHT)
    assert run.t[-1] == 0.0 and np.abs(run.y[:, -1] - START[0]).max() <= 1e-6


def test_the_continuous_solution_and_its_derivative():
    run = solve_dae(linear, (0, 6), *START, dense_output=True, **TIGHT)
    times = np.linspace(0, 6, 500)
    y, yp = linear_solution(times)
    assert np.abs(run.sol(times) - y).max() <= 1e-7
    assert np.abs(run.sol.derivative(times) - yp).max() <= 1e-5
    assert run.sol(1.0).shape == run.sol.derivative(1.0).shape == (2,)
    assert np.abs(run.sol(run.t) - run.y).max() <= 1e-15
    kept = pickle.loads(pickle.dumps(run))
    assert np.array_equal(kept.sol.derivative(times), run.sol.derivative(times))
    step = 1e-5
    slope = (run.sol(times[1:-1] + step) - run.sol(times[1:-1] - step)) / (2 * step)
    assert np.abs(slope - run.sol.derivative(times[1:-1])).max() <= 1e-4


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_events_are_located(compiled):
    seen = []

    def crossing(t, y, *args):
        if not compiled:
            seen.append(t)
        return y[0] - 0.25

    crossing.direction = -1
    run = solve_dae(linear, (0, 6), *START, events=[crossing], **TIGHT)
    (times,), (states,), (rates,) = run.t_events, run.y_events, run.yp_events
    y, yp = linear_solution(times)
    assert len(times) and np.abs(y[0] - 0.25).max() <= 1e-7
    assert (yp[0] < 0).all() and np.abs(states.T - y).max() <= 1e-7
    assert np.abs(rates.T - yp).max() <= 1e-4
    crossing.terminal = True
    run = solve_dae(linear, (0, 6), *START, events=[crossing], **TIGHT)
    assert run.status == 1 and run.t[-1] == pytest.approx(times[0], abs=1e-7)
    assert run.yp.shape == run.y.shape == (2, len(run.t))


def test_args_reach_f_and_events():
    def decay(t, y, yp, k, limit):
        return [yp[0] + k * y[0], y[1] - 2 * y[0]]

    def low(t, y, k, limit):
        return y[1] - limit

    for k in (1.0, 2.0):
        run = solve_dae(decay, (0, 3), [1.0, 2.0], [-k, -2 * k], args=(k, 1.0), events=low, **TIGHT)
        assert run.t_events[0] == pytest.approx([math.log(2) / k], abs=1e-7)


def test_f_in_python_has_the_same_solution():
    calls = []

    def F(t, y, yp):
        calls.append(t)
        return linear(t, y, yp)

    with pytest.warns(CompileWarning, match="test_solve_dae"):
        slow = solve_dae(F, (0, 6), *START, rtol=1e-6, atol=1e-8)
    fast = solve_dae(linear, (0, 6), *START, rtol=1e-6, atol=1e-8)
    assert abs(slow.n_accepted - fast.n_accepted) <= 3
    assert np.abs(slow.y[:, -1] - fast.y[:, -1]).max() <= 1e-6
    assert len(calls) >= slow.nfev > fast.nfev


def test_callables_of_all_kinds():
    class Circuit:
        def __init__(self, gain):
            self.gain = gain

        def residual(self, t, y, yp):
            return [yp[0] + self.gain * y[0], y[1] - y[0]]

        __call__ = residual

    for gain in (1.0, 3.0):
        for F in (Circuit(gain), Circuit(gain).residual):
            run = solve_dae(F, (0, 1), [1.0, 1.0], **TIGHT)
            assert run.y[1, -1] == pytest.approx(math.exp(-gain), abs=1e-8)


@pytest.mark.parametrize("options", [{}, {"sensitivity": ["y0"]}], ids=["alone", "tangent"])
def test_an_exception_of_f_is_raised(options):
    def F(t, y, yp):
        if t > 1.0:
            raise ArithmeticError("out of range")
        return linear(t, y, yp)

    with pytest.raises(ArithmeticError, match="out of range"):
        solve_dae(F, (0, 6), *START, **options)


def test_a_limit_of_steps_and_what_is_not_a_number():
    run = solve_dae(linear, (0, 6), *START, max_steps=7)
    assert run.status == -1 and run.n_accepted == 7 and "`max_steps=7`" in run.message
    run = solve_dae(
        lambda t, y, yp: [yp[0] + y[0] - np.sqrt(1 - t), y[1] - y[0]], (0, 2), [1.0, 1.0]
    )
    assert run.status == -1 and 0.99 <= run.t[-1] <= 1.0 and "nan" in run.message
    run = solve_dae(lambda t, y, yp: [yp[0] - y[0] ** 2], (0, 4), [1.0], **TIGHT)
    assert run.status == -1 and run.t[-1] == pytest.approx(1.0, abs=1e-6)
    assert "blows up" in run.message
