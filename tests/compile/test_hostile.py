"""Calls that would make compiled code answer wrongly without a word."""

import math
import os
import subprocess
import sys
import warnings

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn import prepare, solve_ensemble, solve_ivp
from fastdyn.compile import memory
from support.hostile import (
    FUNCTIONS,
    complex_eigenvalues,
    complex_later,
    factorial,
    unassigned,
    whole_of_float,
    with_event_that_sets_a_flag,
    with_event_that_sets_an_item,
)


def outcome(solve, make, args=(), **options):
    """The end state, the events and the number of calls; or what was raised."""
    fun, events = make() if make.__name__.startswith("with_event") else (make(), None)
    calls = []

    def counted(t, y, *args):
        calls.append(t)
        return fun(t, y, *args)

    np.random.seed(3)  # noqa: NPY002
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            r = solve(fun, (0, 1), [1.0], args=args, events=events, **options)
        except Exception as error:
            return type(error)
    return r.y[0, -1], r.nfev, r.t_events


def same(ours, theirs):
    if isinstance(theirs, type) or isinstance(ours, type):
        return ours == theirs
    pairs = zip(ours[2] or [], theirs[2] or [], strict=True)
    events = [np.allclose(a, b) for a, b in pairs]
    return math.isclose(ours[0], theirs[0], rel_tol=1e-9) and ours[1] == theirs[1] and all(events)


@pytest.mark.parametrize("make", FUNCTIONS, ids=lambda make: make.__name__)
def test_functions_that_compiled_code_would_get_wrong(make):
    assert same(outcome(solve_ivp, make), outcome(scipy.integrate.solve_ivp, make))


SOME = [factorial, whole_of_float, unassigned, complex_eigenvalues, with_event_that_sets_a_flag]


BY_LSODA = [("LSODA", make) for make in (*SOME, with_event_that_sets_an_item)]
BY_RADAU = [("Radau", make) for make in SOME if make is not with_event_that_sets_a_flag]


@pytest.mark.parametrize(("method", "make"), [*BY_LSODA, *BY_RADAU])
def test_the_same_by_a_method_of_scipy_and_by_one_for_stiff_problems(method, make):
    theirs = outcome(scipy.integrate.solve_ivp, make, method=method)
    assert same(outcome(solve_ivp, make, method=method), theirs)


def test_a_flag_under_radau():
    """Differences across the flag leave Newton's iteration to chance: `nfev` varies in SciPy."""
    theirs = outcome(scipy.integrate.solve_ivp, with_event_that_sets_a_flag, method="Radau")
    ours = outcome(solve_ivp, with_event_that_sets_a_flag, method="Radau")
    assert math.isclose(ours[0], theirs[0], rel_tol=1e-9) and np.allclose(ours[2], theirs[2])


def test_an_ensemble_whose_functions_change_each_other_is_refused():
    fun, event = with_event_that_sets_a_flag()
    with pytest.raises(ValueError, match="would depend on their order"):
        solve_ensemble(fun, (0, 1), np.ones((3, 1)), events=event)


def of_parts(t, y, p):
    a, b = p
    return [-a * b * y[0]]


def of_sum(t, y, p):
    return [-sum(p) * max(p) * len(p) * y[0]]


def of_doubled(t, y, p):
    return [-(p * 2)[3] * y[0]]


def of_joined(t, y, p):
    return [-(p + p)[2] * y[0]]


def of_slice(t, y, p):
    return [-(p[1:] * 3)[2] * y[0]]


def of_array(t, y, p):
    return [-(np.ones(2) * p)[1] * y[0]]


def written(t, y, p):
    p[0] += 0.5
    return [-p[0] * y[0]]


@pytest.mark.parametrize(
    "fun", [of_parts, of_sum, of_doubled, of_joined, of_slice, of_array, written]
)
def test_a_list_among_the_arguments_is_a_list(fun):
    theirs = outcome(scipy.integrate.solve_ivp, lambda: fun, ([2.0, 3.0],))
    assert same(outcome(solve_ivp, lambda: fun, ([2.0, 3.0],)), theirs)


def test_every_call_of_a_function_is_counted():
    for method in ("RK23", "RK45", "DOP853", "LSODA"):
        for vectorized in (False, True):
            calls = []

            def fun(t, y, calls=calls):
                calls.append(t)
                return -y

            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                r = solve_ivp(fun, (0, 3), [1.0, 2.0], method, vectorized=vectorized)
            assert len(calls) == r.nfev


def by_solver(fun):
    return prepare(fun, (0, 1), [1.0])().y[0, -1]


def by_ensemble(fun):
    return solve_ensemble(fun, (0, 1), np.ones((3, 1))).y_end[2, 0]


def by_study(fun):
    invariants = {"y": lambda t, y: y[0]}
    study = fastdyn.energy_drift(
        fun, "RK45", t_end=1.0, y0=[1.0], invariants=invariants, rtol=1e-3, atol=1e-6
    )
    return study.y[0, -1]


@pytest.mark.parametrize("solve", [by_solver, by_ensemble, by_study])
def test_a_run_that_gave_up_goes_on_in_python(solve):
    memory.forget()
    expected = outcome(scipy.integrate.solve_ivp, complex_later)[0]
    with pytest.warns(fastdyn.CompileWarning, match="could not go on at t"):
        assert math.isclose(solve(complex_later()), expected, rel_tol=1e-9)


def test_what_compiled_code_cannot_hold_is_named():
    class Thing:
        k = 1.0

        def pull(self, y):
            return -self.k * y

    things = {"it": Thing()}

    def halving(t, y):
        x = abs(y[0])
        while x > 1e-3:
            x /= 2
        return [things["it"].pull(y[0])]

    with pytest.warns(fastdyn.CompileWarning) as caught:
        solve_ivp(halving, (0, 1), [1.0])
    assert "it uses `things`" in str(caught[0].message)
    assert caught[0].filename == __file__  # the line of the user


def test_a_list_that_changes_between_two_solves_is_read_anew():
    rates = [1.0, 5.0]
    decay = lambda t, y: [-rates[0] * y[0]]  # noqa: E731
    ends = []
    for k in (1.0, 2.0):
        rates[0] = k
        ends.append(solve_ivp(decay, (0, 1), [1.0], rtol=1e-8).y[0, -1])
    assert np.allclose(ends, np.exp([-1.0, -2.0]), rtol=1e-6)


DISABLED = """
import warnings, fastdyn, numpy as np
def turn(t, y): return [y[1], -y[0]]
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    one = fastdyn.solve_ivp(turn, (0, 1), [1.0, 0.0], compile="inlined", rtol=1e-8)
    two = fastdyn.solve_ensemble(turn, (0, 1), [[1.0, 0.0]], events=lambda t, y: y[0])
    three = fastdyn.systems.satellite().solve((0, 1))
print(one.y[0, -1], len(caught), "NUMBA_DISABLE_JIT" in str(caught[0].message))
"""


def test_numba_switched_off_runs_in_python_with_one_warning():
    done = subprocess.run(
        [sys.executable, "-c", DISABLED], capture_output=True, text=True, check=True,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
    )  # fmt: skip
    end, n_warnings, said = done.stdout.split()
    assert abs(float(end) - math.cos(1.0)) < 1e-6 and n_warnings == "1" and said == "True"
