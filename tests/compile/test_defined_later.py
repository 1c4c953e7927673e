"""A name that was undefined and is defined later: the refusal of the function is forgotten."""

import types
import warnings

import numpy as np
import pytest

from fastdyn import prepare, solve_ivp
from fastdyn.compile.bind import bind
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.make import Near

START = np.array([1.0, 0.0])


def is_compiled(fun):
    return bind(fun, (), DERIVATIVE, 2, Near(0.0, 1.0, START, True)).callback is None


def solved(space):
    return solve_ivp(space["fun"], (0, 1), START, rtol=1e-8, atol=1e-10)


def prepared(space):
    return prepare(space["fun"], (0, 1), START, rtol=1e-8, atol=1e-10)(START)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("solve", [solved, prepared])
@pytest.mark.parametrize("again", [1, 3])
def test_a_notebooks_usual_order_is_compiled_in_the_end(solve, again):
    """Function, run (NameError), helper, run (k is missing), k, run: compiled, without a word."""
    space = types.ModuleType("notebook").__dict__
    exec("def fun(t, y):\n    return helper(y)", space)
    cells = {"helper": "def helper(y):\n    return [y[1], -k * y[0]]", "k": "k = 4.0"}
    for missing, cell in cells.items():
        for _ in range(again):
            with pytest.raises(NameError, match=missing):
                solve(space)
        exec(cell, space)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = solve(space)
    assert run.y[0, -1] == pytest.approx(np.cos(2.0), abs=1e-6)
    assert is_compiled(space["fun"])
    space["k"] = 9.0
    assert solve(space).y[0, -1] == pytest.approx(np.cos(3.0), abs=1e-6)


def test_a_name_that_is_taken_away_raises_again():
    space = types.ModuleType("notebook").__dict__
    exec("k = 4.0\ndef fun(t, y):\n    return [y[1], -k * y[0]]", space)
    assert solved(space).success
    del space["k"]
    with pytest.raises(NameError, match="k"):
        solved(space)
    space["k"] = 9.0
    assert solved(space).y[0, -1] == pytest.approx(np.cos(3.0), abs=1e-6)
    assert is_compiled(space["fun"])
