"""Code is used only where it was compared with its function, along the solution, too."""

import math

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.compile import compare
from fastdyn.compile.compare import compare_around
from fastdyn.compile.functions import Bound
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.python_callback import Held
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near, traced_function
from fastdyn.ensemble import compared as of_ensembles
from fastdyn.kernels.calls.block import FAULT, FIRST
from fastdyn.run.functions import compared


def test_a_wrong_side_of_a_decision_is_found_on_the_solution(wrong_choices):
    def fun(t, y):
        return [-y[0] if y[0] > 0.2 else -2.0 * y[0]]

    theirs = scipy.integrate.solve_ivp(fun, (0, 5), [1.0], rtol=1e-8)
    with pytest.warns(fastdyn.CompileWarning, match=r"compiled form gives \[-.*and Python \[-"):
        ours = fastdyn.solve_ivp(fun, (0, 5), [1.0], rtol=1e-8)
    assert np.allclose(ours.y[:, -1], theirs.y[:, -1], rtol=1e-9) and ours.nfev == theirs.nfev
    again = fastdyn.solve_ivp(fun, (0, 5), [1.0], rtol=1e-8)  # the code is not used again
    assert again.y[0, -1] == ours.y[0, -1]


def test_when_functions_are_compared(monkeypatch):
    seen = []
    monkeypatch.setattr(compared, "compare", lambda run, count, *_: seen.append(count) or {})
    for when, expected in (
        ("auto", [True, True, False, True, False, False, False, True]),
        ("always", [True] * 8),
        ("never", [False] * 8),
    ):
        monkeypatch.setattr(compared, "WHEN", when)

        def fun(t, y, when=when):
            return [-y[0] * (1.0 + len(when))]

        found = []
        for _ in range(8):
            seen.clear()
            fastdyn.solve_ivp(fun, (0, 1), [1.0])
            found.append(bool(seen))
        assert found == expected


def test_a_side_that_is_new_is_compared(monkeypatch):
    seen = []
    monkeypatch.setattr(compared, "compare", lambda run, count, *_: seen.append(count) or {})
    solver = fastdyn.prepare(lambda t, y: [-y[0] if y[0] < 5.5 else 1.0 - y[0]], (0, 1), [1.0])
    for start in (1.0, 1.5, 1.2, 1.1, 7.0, 8.0, 1.0):
        solver([start])
    assert seen == [compared.AT_FIRST, compared.LATER, compared.LATER, compared.AT_FIRST]


FORMS = {
    "where": lambda t, y: np.where(y < 5.5, -y, 1.0 - y),
    "mask": lambda t, y: -y * (1.0 + masked(y)),
    "one number": lambda t, y: -y * max(y[3], 5.5),
    "path": lambda t, y: -y if y.max() < 5.5 else 1.0 - y,
    "edge": lambda t, y: np.concatenate([np.where(y[:3] < 5.5, -y[:3], 1.0), -y[3:]]),
    "one by one": lambda t, y: [-v * math.sin(max(v, 5.5)) for v in y],
}


def masked(y):
    v = y.copy()
    v[v > 5.5] = 5.5
    return v


@pytest.mark.few
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("n", [40, 64, 65, 301])
def test_a_side_that_an_array_takes_first_is_compared(form, n, monkeypatch):
    seen = []
    monkeypatch.setattr(compared, "compare", lambda run, count, *_: seen.append(count) or {})
    solver = fastdyn.prepare(FORMS[form], (0, 1), np.ones(n))
    for start in (1.0, 1.5, 1.2, 1.1, 7.0, 8.0, 1.0):
        solver(np.r_[np.ones(3), start, np.ones(n - 4)] if form != "edge" else [start] * n)
    assert seen == [compared.AT_FIRST, compared.LATER, compared.LATER, compared.AT_FIRST]


@pytest.mark.parametrize("n_before", [0, 2])
@pytest.mark.parametrize("times", [None, [9.0]])
def test_the_states_that_show_a_side_are_compared(times, n_before, wrong_choices):
    """The window is so narrow that states at equal distances, and short steps, miss it."""
    c = 2.0 + n_before + (times is None) / 8
    fun = eval(f"lambda t, y, at: [-{c} * y[0] if (t < at) | (t > at + 0.02) else -{c / 2} * y[0]]")
    given, options = ((0, 9), [1.0]), {"rtol": 1e-10, "max_step": 0.015, "t_eval": times}
    theirs = scipy.integrate.solve_ivp(fun, *given, args=(0.61,), **options)
    solver = fastdyn.prepare(fun, *given, args=(20.0,), **options)
    for _ in range(n_before):  # solve 3 is not due
        solver()
    with pytest.warns(fastdyn.CompileWarning, match="at t = 0.6"):
        ours = solver(args=(0.61,))
    assert abs(ours.y[0, -1] - theirs.y[0, -1]) < 1e-9 * abs(theirs.y[0, -1])


def test_a_wrong_side_taken_late_is_found(wrong_choices):
    def fun(t, y):
        return [-y[0] if y[0] < 5.25 else -2.0 * y[0]]

    solver = fastdyn.prepare(fun, (0, 1), [1.0], rtol=1e-8)
    for start in (1.0, 1.5, 1.2, 1.1, 1.3):
        solver([start])
    with pytest.warns(fastdyn.CompileWarning, match="compiled form gives"):
        ours = solver([8.0])
    theirs = scipy.integrate.solve_ivp(fun, (0, 1), [8.0], rtol=1e-8)
    assert abs(ours.y[0, -1] - theirs.y[0, -1]) < 1e-9


def test_a_prepared_solver_compares_too(monkeypatch):
    seen = []
    monkeypatch.setattr(compared, "compare", lambda run, count, *_: seen.append(count) or {})
    solver = fastdyn.prepare(lambda t, y: [-3.25 * y[0]], (0, 1), [1.0])
    for _ in range(5):
        solver()
    assert seen == [compared.AT_FIRST, compared.LATER, compared.LATER]


def test_what_rounds_otherwise_is_no_difference():
    assert not compare.differ(np.array([1.0, 1e-13]), np.array([1.0 + 1e-14, 3e-13]))
    assert compare.differ(np.array([1.0]), np.array([1.0 + 1e-7]))
    assert compare.differ(np.array([np.nan]), np.array([1.0]))
    assert compare.differ(np.array([np.inf]), np.array([-np.inf]))
    assert not compare.differ(np.array([np.inf, np.nan]), np.array([np.inf, np.nan]))


def test_what_rounding_leaves_of_large_terms_is_no_difference():
    def fun(t, y):
        return [1e6 * (np.sin(3 * y[0]) - 3 * np.sin(y[0]) + 4 * np.sin(y[0]) ** 3), -y[1]]

    near = Near(0.0, 1.0, np.array([0.7, 0.9]))
    assert traced_function(Attempt(fun, (), DERIVATIVE, 2), near) is not None


def test_a_small_difference_beside_large_numbers_is_one(monkeypatch):
    def function(t, y):
        return np.array([1e6 * y[0], 1e-3 * y[1]])

    def compiled(bound, t, y):
        return function(t, y) + np.array([0.0, 1e-4])

    monkeypatch.setattr(compare, "machine_value", compiled)
    near, block = Near(0.0, 1.0, np.array([0.7, 0.9])), np.zeros(FIRST + 2, np.int64)
    block[FAULT] = FIRST
    bound = Bound(None, block, function, Held(), None, [], DERIVATIVE)
    assert "compiled form gives" in str(compare_around(bound, near))


@pytest.mark.parametrize("ensemble", [False, True])
def test_each_of_two_functions_with_the_same_code_is_compared(ensemble, monkeypatch):
    """Their machine code is one; the second function is another in Python."""
    functions = []
    for module in (compared, of_ensembles):
        monkeypatch.setattr(
            module, "compare_along", lambda bound, *_: functions.append(bound.held.fun)
        )

    def first(t, y):
        return [-y[0], -1.25 * y[1]]

    def second(t, y):
        return [-y[0], y[1] * -1.25]

    for fun in (first, first, first, second, second, second):
        if ensemble:
            fastdyn.solve_ensemble(fun, (0, 1), [[1.0, 2.0], [2.0, 1.0]])
        else:
            fastdyn.solve_ivp(fun, (0, 1), [1.0, 2.0])
    assert functions.count(first) == functions.count(second) > 0
