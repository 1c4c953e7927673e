"""A run that stops where its equations become nan says so, and where a gap begins and ends."""

import math

import numpy as np
import pytest

import fastdyn

TIMES = np.arange(0.0, 6.0, 0.5)
RECORD = np.where((TIMES > 3.0) & (TIMES < 4.0), np.nan, np.sin(TIMES))


def of_record(t, y):
    return [np.interp(t, TIMES, RECORD) - y[0]]


def of_formula(t, y):
    return [math.nan if 3.0 < t < 4.0 else -y[0]]


GAP = "`fun` returns nan or inf just after t = 3, up to t = 4, as a record with a gap does"


@pytest.mark.few(5)
@pytest.mark.parametrize("fun", [of_record, of_formula])
@pytest.mark.parametrize("method", ["RK45", "Radau", "BDF", "LSODA", "Rodas5P", "auto"])
def test_a_gap_is_named(fun, method):
    run = fastdyn.solve_ivp(fun, (0, 5), [2.0], method)
    assert run.status == -1 and GAP in run.message


def test_a_gap_of_a_run_backwards_is_named():
    run = fastdyn.solve_ivp(of_record, (5, 0), [2.0], "Radau")
    assert "just after t = 4, up to t = 3," in run.message


def test_equations_that_end_are_told_to_end_there():
    run = fastdyn.solve_ivp(lambda t, y: [np.sqrt(3.0 - t)], (0, 5), [2.0], "Radau")
    assert "`fun` returns nan or inf at all times after t = 3: end the span there." in run.message


@pytest.mark.parametrize("method", ["Radau", "BDF"])
def test_a_state_where_they_are_undefined_is_no_gap(method):
    def fun(t, y):
        return [-np.sqrt(y[0]) - 0.1]

    run = fastdyn.solve_ivp(fun, (0, 5), [2.0], method)
    end = 2 * math.sqrt(2.0) - 0.2 * math.log1p(10 * math.sqrt(2.0))  # where y is 0
    at = float(run.message.partition("just after t = ")[2].rstrip("."))
    assert at == pytest.approx(end, abs=2e-2)


def test_a_singularity_is_none_either():
    run = fastdyn.solve_ivp(lambda t, y: [1 / (t - 2.0)], (0, 5), [2.0], "Radau")
    assert "a singularity or a jump" in run.message
