"""Functions that only Numba compiles: values from outside are constants, by their content."""

import warnings

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn import solve_ivp
from fastdyn.code_store import COUNTS
from fastdyn.compile.bind import bind
from fastdyn.compile.by_numba import function as by_numba
from fastdyn.compile.by_numba import pointer_form
from fastdyn.compile.callables import parts_of
from fastdyn.compile.mode import DERIVATIVE, JUMP, MATRIX, MODES
from fastdyn.compile.sentences import Uncompilable
from fastdyn.compile.traced.make import Near
from support.halving import halved

START = np.array([1.0, 2.0])
RATE = 2.0
TABLE = np.array([1.0, 2.0])
LARGE = np.ones(200_000)


TABLES = TABLE, TABLE + 1.0


def of_global(t, y):
    return -RATE * halved(y[0]) * y


def of_array(t, y):
    return -TABLE[1] * halved(y[0]) * y


def of_argument(t, y, k):
    return -k * halved(y[0]) * y


def agrees(fun, args=()):
    """Solve as SciPy does, without a warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ours = solve_ivp(fun, (0, 1), START, args=args)
    theirs = scipy.integrate.solve_ivp(fun, (0, 1), START, args=args)
    assert ours.nfev == theirs.nfev
    np.testing.assert_allclose(ours.y, theirs.y, rtol=1e-12)


def refused(fun, sentence, args=()):
    """Solve as SciPy does, with a warning."""
    with pytest.warns(fastdyn.CompileWarning, match=sentence):
        ours = solve_ivp(fun, (0, 1), START, args=args)
    theirs = scipy.integrate.solve_ivp(fun, (0, 1), START, args=args)
    np.testing.assert_allclose(ours.y, theirs.y, rtol=1e-12)


@pytest.mark.parametrize("fun", [of_global, of_array])
def test_a_changed_value_recompiles_and_a_known_one_does_not(fun, monkeypatch):
    for value in (2.0, 3.5, 2.0):
        monkeypatch.setattr(f"{__name__}.RATE", value)
        TABLE[1] = value
        agrees(fun)
    compiled = COUNTS["compiled"]
    agrees(fun)
    assert COUNTS["compiled"] == compiled


def test_arguments_are_parameters():
    agrees(of_argument, (2.0,))
    compiled = COUNTS["compiled"]
    agrees(of_argument, (3.0,))
    assert COUNTS["compiled"] == compiled


def test_a_value_that_changes_from_solve_to_solve_is_left_to_python():
    def fun_of(k):
        return lambda t, y: -k * halved(y[0]) * y

    for k in range(by_numba.MOST_TRIES):
        agrees(fun_of(1.0 + k))
    refused(fun_of(100.0), "changes from solve to solve: pass the values as `args`")


def test_a_value_that_changes_while_numba_compiles_makes_no_code(monkeypatch):
    k = 2.0

    def fun(t, y):
        return -k * halved(y[0] + 0.125) * y

    made = pointer_form.pointer_form

    def slow(*given):
        nonlocal k
        k = 3.0
        return made(*given)

    monkeypatch.setattr(pointer_form, "pointer_form", slow)
    with pytest.raises(Uncompilable, match="changed while it was compiled"):
        by_numba.compiled_function(parts_of(fun, ()), DERIVATIVE)


def test_arrays_that_are_too_large_for_code_are_arguments():
    refused(lambda t, y: -LARGE[3] * halved(y[0]) * y, "`LARGE`, an array of 1600000 bytes")
    agrees(lambda t, y, large: -large[3] * halved(y[0]) * y, (LARGE,))


def test_arrays_with_gaps_are_constants_without():
    gaps = np.arange(8.0)[::2]
    agrees(lambda t, y: -gaps[1] * halved(y[0]) * y)


@pytest.mark.parametrize("where", ["outside", "in a tuple", "argument", "state"])
def test_code_writes_to_no_array_that_others_see(where):
    texts = {
        "outside": "TABLE[0] = halved(y[0]); return -y * TABLE[0]",
        "in a tuple": "a = TABLES[0]; a[0] = halved(y[0]); return -y * a[0]",
        "argument": "array[0] = halved(y[0]); return -y * array[0]",
        "state": "y[0] = max(y[0], 1e-9 * halved(y[0])); return -y",
    }
    space = {"TABLE": TABLE.copy(), "TABLES": TABLES, "halved": halved}
    exec(f"def fun(t, y, array): {texts[where]}", space)
    refused(space["fun"], "writes|changes", (np.zeros(2),))


def test_other_modes_stay_in_python():
    def matrix(t, y):
        return -halved(y[0]) * np.eye(2)

    assert [mode.name for mode in MODES.values() if mode.by_numba] == [
        "derivative",
        "residual",
        "event",
        "projection",
        "history",
    ]
    for mode in (MATRIX, JUMP):
        bound = bind(matrix, (), mode, 2, Near(0.0, 1.0, START))
        assert bound.function is None and bound.callback is not None
    assert bind(of_argument, (1.0,), DERIVATIVE, 2, Near(0.0, 1.0, START)).function is not None


def test_powers_of_whole_numbers_that_are_no_whole_numbers_go_to_python():
    def fun(t, y):
        k = int(halved(y[0]) * 0) + 2
        return -y * k ** -(k - 1)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        ours = solve_ivp(fun, (0, 1), START)
    theirs = scipy.integrate.solve_ivp(fun, (0, 1), START)
    np.testing.assert_allclose(ours.y, theirs.y, rtol=1e-12)
