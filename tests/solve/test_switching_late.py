"""Switching times of functions whose code is not ready: they run in Python, or tell."""

import threading
import warnings

import numpy as np
import pytest

from fastdyn import SwitchingWarning, solve_dae, solve_ivp
from fastdyn.compile import background, budget
from fastdyn.compile.traced.code import Traced
from fastdyn.trace.graph.refusal import OutOfTime
from support.pulsed import fresh, pulse


@pytest.fixture
def late(monkeypatch):
    """No code is ready before the end of the test."""
    go_on = threading.Event()
    compiled = Traced.compiled

    def awaited(traced, *given):
        if not background.is_here():
            raise OutOfTime
        return compiled(traced, *given)

    monkeypatch.setattr(budget, "SECONDS", 0.1)
    monkeypatch.setattr(background.Job, "run", lambda job: go_on.wait(60) and (job.end() or True))
    monkeypatch.setattr(Traced, "compiled", awaited)
    yield
    go_on.set()
    background.finish()


@pytest.mark.parametrize("method", ["Tsit5", "Vern9", "Rodas5P"])
def test_own_steps_end_at_the_times_of_a_trace_without_code(method, late):
    outside = {"start": 5.0}
    fun = fresh(lambda t, y, width: [pulse(t, outside["start"], width)])
    for start, width in ((5.0, 0.2), (7.0, 0.1)):
        outside["start"] = start
        run = solve_ivp(fun, (0, 10), [0.0], method, args=(width,))
        assert run.y[0, -1] == pytest.approx(width) and start in run.t


def test_scipys_methods_tell_without_code(late):
    fun = fresh(lambda t, y: [pulse(t)])
    with pytest.warns(SwitchingWarning, match="no step of RK45 looked there"):
        assert solve_ivp(fun, (0, 10), [0.0], "RK45").y[0, -1] == 0.0
    solve_ivp(fun, (0, 10), [0.0], "RK45")


def test_a_dae_has_the_times_of_a_trace_without_code(late):
    F = fresh(lambda t, y, yp: [yp[0] - y[1], y[1] - pulse(t)])
    assert solve_dae(F, (0, 10), [0.0, 0.0]).y[0, -1] == pytest.approx(0.2, rel=1e-4)


@pytest.mark.parametrize("of_time", [True, False])
def test_a_function_that_is_not_traced_yet_is_told(of_time, late, monkeypatch):
    def slowly(*_):
        raise OutOfTime

    monkeypatch.setattr("fastdyn.compile.traced.make.Traced", slowly)
    fun = fresh((lambda t, y: [pulse(t)]) if of_time else (lambda t, y: [-y[0]]))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        solve_ivp(fun, (0, 10), [0.0], "Vern9")
        solve_ivp(fun, (0, 10), [0.0], "Vern9")
    told = [str(each.message) for each in caught if each.category is SwitchingWarning]
    assert len(told) == of_time and all("not known yet" in each for each in told)
    assert np.all([each.category is SwitchingWarning for each in caught])
