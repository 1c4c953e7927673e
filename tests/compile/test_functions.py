"""Any function: every way to write one compiles, agrees with SciPy, and is never stale."""

import fractions
import functools
import math
import warnings

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.python_callback import OtherShape
from support import oscillators
from support.oscillators import (
    CASES,
    MATRIX,
    SETTINGS,
    Oscillator,
    closure_over,
    reads_object,
    returns_array,
    returns_list,
    returns_tuple,
    takes,
    writes_to_y,
)
from support.rounding import spread

OSCILLATION = {"t_span": (0, 10), "y0": [1.0, 0.0], "rtol": 1e-6}

ROUNDING = spread(lambda t, y: [y[1], -2.0 * y[0]], **OSCILLATION)  # all cases have this solution


@pytest.mark.parametrize(("fun", "args"), CASES.values(), ids=CASES)
def test_it_compiles_and_agrees_with_scipy(fun, args):
    problem = {**OSCILLATION, "args": args or None}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ours = fastdyn.solve_ivp(fun, **problem)
    theirs = scipy.integrate.solve_ivp(fun, **problem)
    assert ours.nfev == theirs.nfev
    np.testing.assert_allclose(ours.y, theirs.y, rtol=0, atol=ROUNDING)


def test_a_function_that_writes_to_the_state_runs_in_python():
    with pytest.warns(fastdyn.CompileWarning, match="changes the state that it is given"):
        ours = fastdyn.solve_ivp(writes_to_y, **OSCILLATION)
    theirs = scipy.integrate.solve_ivp(writes_to_y, **OSCILLATION)
    assert ours.nfev == theirs.nfev
    np.testing.assert_allclose(ours.y, theirs.y, rtol=0, atol=ROUNDING)


def final(fun, **options):
    return fastdyn.solve_ivp(fun, (0, 1), [1.0, 0.0], rtol=1e-8, atol=1e-10, **options).y[0, -1]


def test_closures_globals_and_attributes_are_never_stale_and_not_recompiled(monkeypatch):
    oscillator = Oscillator(2.0)
    changes = {
        "closure": lambda k: closure_over(k),
        "global": lambda k: (
            monkeypatch.setattr(oscillators, "STIFFNESS", k),
            returns_array,
        )[1],
        "attribute": lambda k: (setattr(oscillator, "k", k), oscillator.method)[1],
        "object": lambda k: (setattr(SETTINGS, "k", k), reads_object)[1],
        "argument": lambda k: functools.partial(takes, k=k),
    }
    for name, changed in changes.items():
        final(changed(2.0))
        compiled = fastdyn.code_store.COUNTS["compiled"]
        for k in (3.0, 5.0):
            assert abs(final(changed(k)) - math.cos(math.sqrt(k))) < 1e-6, name
        assert fastdyn.code_store.COUNTS["compiled"] == compiled, name
    SETTINGS.k = 2.0


def test_a_constant_in_a_called_function_is_never_stale(monkeypatch):
    for k in (2.0, 3.0, 2.0):
        monkeypatch.setattr(oscillators, "STIFFNESS", k)
        assert abs(final(returns_tuple) - math.cos(math.sqrt(k))) < 1e-6
        assert abs(final(returns_tuple, compile="inlined") - math.cos(math.sqrt(k))) < 1e-6


def test_a_called_function_that_is_replaced_is_replaced(monkeypatch):
    final(returns_tuple)
    monkeypatch.setattr(oscillators, "pull", lambda x: -9.0 * x)
    assert abs(final(returns_tuple) - math.cos(3.0)) < 1e-6


def test_arrays_are_read_when_they_are_used():
    matrix = MATRIX.copy()

    def fun(t, y):
        return matrix @ y

    final(fun)
    matrix[1, 0] = -9.0
    assert abs(final(fun) - math.cos(3.0)) < 1e-6


@pytest.mark.filterwarnings("always")
def test_what_cannot_be_compiled_says_which_line_and_runs_all_the_same():
    table, seen = {"k": 2.0}, []

    def keeps(t, y):
        seen.append(t)
        return [y[1], -table["k"] * y[0]]

    with pytest.warns(fastdyn.CompileWarning, match=r"keeps.*list.*line \d+"):
        first = final(keeps)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert final(keeps) == first == final(returns_list)
        table["k"] = 9.0
        assert abs(final(keeps) - math.cos(3.0)) < 1e-6


@pytest.mark.parametrize("compiles", [True, False])
def test_what_the_function_raises_arrives(compiles):
    seen = []
    limit = 0.5

    def compiled(t, y):
        if t > limit:
            raise RuntimeError("too late")
        return [y[1], -y[0]]

    def in_python(t, y):
        seen.append(t)
        if t > limit:
            raise RuntimeError("too late")
        return [y[1], -y[0]]

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fastdyn.CompileWarning)
        with pytest.raises(RuntimeError, match="too late"):
            final(compiled if compiles else in_python)


RETURNED = {
    "text": lambda t, y: "abc",
    "texts": lambda t, y: ["a", "b"],
    "dict": lambda t, y: {"x": 1},
    "objects": lambda t, y: np.array([-y[0], fractions.Fraction(1, 2)], dtype=object),
    "other objects": lambda t, y: np.array([y, y[0]], dtype=object),
    "column": lambda t, y: -y[:, None],
    "too many": lambda t, y: [1.0, 2.0, 3.0],
}


@pytest.mark.few(4)
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", RETURNED)
def test_what_is_no_derivative_raises_what_scipy_raises(name):
    found = []
    for solve in (scipy.integrate.solve_ivp, fastdyn.solve_ivp):
        try:
            found.append(solve(RETURNED[name], (0, 1), [1.0, 2.0]).y[:, -1])
        except Exception as error:
            found.append(type(error))
    if name == "objects":
        np.testing.assert_allclose(*found, rtol=1e-13)  # sums in another order
    else:  # of a shape, our class of SciPy's errors
        assert found[1] is found[0] or (found[0] is ValueError and issubclass(found[1], OtherShape))


@pytest.mark.parametrize("method", ["Radau", "LSODA"])
def test_what_numba_compiled_raises_under_methods_of_scipy(method):
    def halving(t, y):
        x = y[0]
        while x > 0.3:  # no graph: Numba compiles it
            x /= 2
        if t > 0.5:
            raise RuntimeError("too late")
        return [-x]

    with pytest.raises(RuntimeError, match="too late"):
        fastdyn.solve_ivp(halving, (0, 3), [1.0], method=method)


def test_whole_powers_are_pythons():
    N = 10

    def fun(t, y, n, k):
        return [y[0] * n**-2, y[1] * N**k, y[2] * 2**3, y[3] * 10**n * 1e-30]

    given = (10, -1)
    ours = fastdyn.solve_ivp(fun, (0, 0.5), [1.0] * 4, args=given, rtol=1e-8)
    assert ours.y[:, -1] == pytest.approx(np.exp(0.5 * np.array([0.01, 0.1, 8.0, 1e-20])))


def test_a_function_that_calls_itself_stays_in_python():
    def deep(x):
        return x if x < 0.5 else deep(x)

    with pytest.warns(fastdyn.CompileWarning, match="calls itself"), pytest.raises(RecursionError):
        fastdyn.solve_ivp(lambda t, y: [-y[0] * deep(t)], (0, 1), [1.0])


def test_one_function_among_args_that_does_not_compile_spoils_no_other():
    seen = []

    def fun(t, y, force):
        return [force(t)]

    def plain(t):
        return 2.0

    def odd(t):
        seen.append(t)
        return 2.0

    with pytest.warns(fastdyn.CompileWarning):
        fastdyn.solve_ivp(fun, (0, 1), [0.0], args=(odd,))
    bound = fastdyn.compile.bind.bind(fun, (plain,), DERIVATIVE, 1)
    assert bound.function is not None
