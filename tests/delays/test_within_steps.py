"""Delays that vanish or are shorter than a step: a step contains its own past."""

import math

import numpy as np
import pytest

from fastdyn import CompileWarning
from fastdyn.delays import solve_dde, solve_dde_ensemble
from fastdyn.delays.equation import EXPLICIT

TENFOLD = 10.0


def pantograph(t, q):
    """The solution of y' = -y(q t), y(0) = 1."""
    return sum((-1) ** k * q ** (k * (k - 1) / 2) * t**k / math.factorial(k) for k in range(30))


@pytest.mark.parametrize("method", EXPLICIT)
def test_a_delay_that_vanishes_at_the_start(method):
    for rtol in (1e-4, 1e-8):
        found = solve_dde(
            lambda t, y, past: -past(0.5 * t), (0, 5), [1.0], method, rtol=rtol, atol=rtol
        )
        assert abs(found.y[0, -1] - pantograph(5.0, 0.5)) < TENFOLD * rtol


@pytest.mark.parametrize("method", EXPLICIT)
def test_delays_far_shorter_than_the_span_do_not_bound_the_steps(method):
    """y = exp(-r t) with r = exp(r tau); a thousand thousand steps would be as long as tau."""
    tau = 1e-5
    rate = 1.0 + tau + 1.5 * tau**2  # of r = exp(r tau), to 3e-15
    found = solve_dde(
        lambda t, y, past: -past(t - tau), (0, 10), lambda t: [np.exp(-rate * t)], method,
        rtol=1e-8, atol=1e-8,
    )  # fmt: skip
    assert len(found.t) < 300
    assert abs(found.y[0, -1] - np.exp(-10 * rate)) < TENFOLD * 1e-8


def test_the_machine_code_and_python_iterate_alike():
    def hidden(t, y, past):
        return [float(str(-past(0.5 * t)[0]))]

    with pytest.warns(CompileWarning):
        found = solve_dde(hidden, (0, 5), [1.0], "Tsit5", delays=[], rtol=1e-6, atol=1e-6)
    traced = solve_dde(
        lambda t, y, past: -past(0.5 * t), (0, 5), [1.0], "Tsit5", rtol=1e-6, atol=1e-6
    )
    np.testing.assert_allclose(found.y[0, -1], traced.y[0, -1], rtol=0, atol=1e-7)


def test_a_delay_that_becomes_negative_ends_the_solve_with_the_time():
    found = solve_dde(lambda t, y, past: past(t - (1.0 - t)), (0, 2), [1.0], rtol=1e-6)
    assert (found.status, found.success) == (-1, False)
    assert "a delay is negative" in found.message
    assert abs(found.t[-1] - 1.0) < 1e-4  # a time later by ten tolerances counts as t


def test_an_iteration_without_a_limit_ends_the_solve_with_the_time():
    """At t = 1, y' = -3 y'(t): the iteration triples its errors, however short the step."""
    found = solve_dde(
        lambda t, y, past: 1.0 - 3.0 * past.derivative(t - np.maximum(1.0 - t, 0.0)),
        (0, 2), [0.0], rtol=1e-6,
    )  # fmt: skip
    assert (found.status, found.success) == (-1, False)
    assert "a delay vanishes" in found.message and abs(found.t[-1] - 1.0) < 1e-6


def test_a_jump_that_a_varying_delay_passes_is_seen():
    """The past at t / 3 passes a level: y' jumps, and no step is over it."""

    def fun(t, y, past):
        return [1.0 if t < 1.0 else -1.0, np.sign(past(t / 3)[0] - 0.9)]

    found = solve_dde(fun, (0, 4), [0.0, 0.0], rtol=1e-7, atol=1e-7)
    # y0 rises to 1 at t = 1 and falls: above 0.9 for t / 3 in (0.9, 1.1)
    assert abs(found.y[1, -1] - (-2.7 + 0.6 - 0.7)) < TENFOLD * 1e-7


def test_a_failure_before_the_first_time_of_output_has_its_sentence():
    """Its time is that of the run: the result has none."""
    found = solve_dde(lambda t, y, past: past(2 * t - 1.0), (0, 3), [1.0], t_eval=[2.0])
    assert len(found.t) == 0
    assert "delay is negative" in found.message or "a delay vanishes" in found.message


def delayed(t, y, past, rate, taus):
    """An average over earlier states, the present one among them."""
    return [rate * y[0] * (1.0 - past(t - taus)[0].mean())]


TAUS = np.linspace(0.0, 1.0, 6)
AVERAGE = {"rtol": 1e-9, "atol": 1e-11, "t_eval": [1.0, 4.0]}


def one_by_one(t, y, past, rate, taus):
    late = sum(past(t - tau)[0] for tau in taus[1:])
    return [rate * y[0] * (1.0 - (y[0] + late) / len(taus))]


@pytest.mark.parametrize("method", ["Tsit5", "Vern9", "Radau"])
def test_the_past_without_a_delay_is_the_present(method):
    found = solve_dde(delayed, (0, 4), [0.2], method, args=(1.3, TAUS), **AVERAGE)
    other = solve_dde(one_by_one, (0, 4), [0.2], method, args=(1.3, TAUS), **AVERAGE)
    assert found.delays.tolist() == other.delays.tolist() == TAUS[1:].tolist()
    np.testing.assert_allclose(found.y, other.y, rtol=0, atol=TENFOLD * 1e-9)


def test_a_delay_may_be_an_argument_that_is_zero():
    options = {"rtol": 1e-9, "atol": 1e-11}

    def fun(t, y, past, tau):
        return -past(t - tau)

    exact = np.exp(-2.0)
    found = solve_dde(fun, (0, 2), [1.0], args=(0.0,), **options)
    assert len(found.delays) == 0 and abs(found.y[0, -1] - exact) < TENFOLD * 1e-9
    many = solve_dde_ensemble(fun, (0, 2), [1.0], ([0.0, 0.5],), **options)
    assert many.y[0, 0] == found.y[0, -1] != many.y[1, 0]
    stiff = solve_dde(lambda t, y, past: -1e6 * past(t - 0.0), (0, 2), [1.0], "Radau", rtol=1e-6)
    assert stiff.success and len(stiff.t) < 100  # the Jacobian has the past without a delay
    with pytest.raises(ValueError, match="a delay is 0"):
        solve_dde(fun, (0, 2), [1.0], "Rodas5P", args=(0.0,))


def test_sensitivities_without_a_delay_are_those_of_the_present():
    found = solve_dde(delayed, (0, 4), [0.2], args=(1.3, TAUS), sensitivity="rate", **AVERAGE)
    other = solve_dde(one_by_one, (0, 4), [0.2], args=(1.3, TAUS), sensitivity="rate", **AVERAGE)
    given = found.sensitivity["rate"], other.sensitivity["rate"]
    np.testing.assert_allclose(*given, rtol=0, atol=TENFOLD * 1e-9)


def test_in_python_the_past_without_a_delay_is_the_present():
    def fun(t, y, past):
        float(str(t))
        return past(t - TAUS)[0].mean() - y

    with pytest.warns(CompileWarning):
        found = solve_dde(fun, (0, 2), lambda t: [np.cos(t)], delays=TAUS[1:], rtol=1e-8)
    exact = solve_dde(
        lambda t, y, past: past(t - TAUS)[0].mean() - y, (0, 2), lambda t: [np.cos(t)], rtol=1e-8
    )
    np.testing.assert_allclose(found.y[0, -1], exact.y[0, -1], rtol=0, atol=TENFOLD * 1e-8)
