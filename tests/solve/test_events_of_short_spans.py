"""Claims about the times of events in short spans: their resolution is a share of the span."""

import numpy as np
import pytest

from fastdyn import prepare, solve_ivp

ZEROS = np.pi * np.array([0.5, 1.5, 2.5])
TIGHT = {"rtol": 1e-9, "atol": 1e-9}


def turning(t, y, w):
    return [w * y[1], -w * y[0]]


def crossed(t, y, w):
    return y[0]


def slower(t, y, w):
    return [0.0, -0.9 * y[1]]


@pytest.mark.parametrize("unit", [1.0, 1e-9, 1e-15, 1e-30])
@pytest.mark.parametrize("method", ["Tsit5", "Vern9", "Rodas5P", "Taylor"])
def test_own_methods_resolve_the_span(method, unit):
    """The error is the solution's: the same in every unit of time."""
    given = (0.0, 9.0 * unit), [1.0, 0.0], method
    for acts in (None, slower):
        run = solve_ivp(turning, *given, args=(1 / unit,), events=crossed, on_event=acts, **TIGHT)
        assert run.status == 0
        assert run.t_events[0] == pytest.approx(unit * ZEROS, rel=1e-8)


def test_scipys_methods_resolve_the_span_where_events_act():
    """Without actions, their times are SciPy's, to 4 roundings of a second."""
    for method in ("RK45", "DOP853", "Radau"):
        given = turning, (0.0, 9e-15), [1.0, 0.0], method
        run = solve_ivp(*given, args=(1e15,), events=crossed, on_event=slower, **TIGHT)
        assert run.status == 0 and len(run.t_events[0]) == 3


def test_a_prepared_solver_resolves_the_span_that_it_is_given():
    shot = prepare(turning, (0.0, 9.0), [1.0, 0.0], "Vern9", args=(1.0,), events=crossed, **TIGHT)
    for unit in (1.0, 1e-15, 1.0, 1e-24):
        run = shot(t_span=(0.0, 9.0 * unit), args=(1 / unit,))
        assert run.t_events[0] == pytest.approx(unit * ZEROS, rel=1e-8)
