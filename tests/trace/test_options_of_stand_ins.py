"""A stand-in for a function of NumPy takes an option, or refuses the option by its name."""

import ast
import pathlib

import numpy as np
import pytest

import fastdyn
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.known import Attempt
from fastdyn.trace.functions import stand_ins
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.paths.runs import trace

FOLDER = pathlib.Path(stand_ins.__file__).parent
# Options that decide only whether NumPy raises an error: Python runs the function once, too.
NO_VALUE = {("joined", "casting"), ("copied", "casting"), ("squareform", "checks")}
REFUSED = {
    "np.clip with dtype": lambda t, y: np.clip(y, 0.0, 1.0, dtype=np.float32),
    "np.clip with where": lambda t, y: np.clip(y, 0.0, 1.0, out=1.0 * y, where=[True, False, True]),
    "np.linspace with dtype": lambda t, y: np.linspace(y[0], 9.5, 3, dtype=int),
    "np.linspace with axis": lambda t, y: np.linspace(y, 2.0, 4, axis=1)[:, 1],
    "np.einsum with casting": lambda t, y: np.einsum("i,i->i", y, y, casting="unsafe"),
    "np.var with dtype": lambda t, y: y * np.var(y, dtype=np.float32),
}
TAKEN = [
    lambda y: np.einsum("i,i->i", y, y, optimize=True),
    lambda y: np.linspace(y, 2.0, 4)[1],
    lambda y: np.linspace(y, 2.0 * y, len(y)).sum(axis=0),
    lambda y: np.linspace(y[0], 2.0, 3, dtype=float),
    lambda y: np.trace(np.outer(y, y), dtype=float) * y,
]
Y = np.array([0.3, -0.4, 1.7])


@pytest.mark.parametrize("reason", REFUSED)
def test_an_option_that_a_stand_in_lacks_is_named(reason):
    fun = REFUSED[reason]
    with pytest.warns(fastdyn.CompileWarning, match=reason):
        r = fastdyn.solve_ivp(fun, (0, 0.1), Y, "RK4", step=0.1)
    assert reason in Attempt(fun, (), DERIVATIVE, 3).why()
    slopes = [fun(0.0, Y).astype(float)]
    for share in (0.5, 0.5, 1.0):
        slopes.append(fun(0.1 * share, Y + 0.1 * share * slopes[-1]).astype(float))
    end = Y + 0.1 / 6 * np.array([1.0, 2.0, 2.0, 1.0]) @ slopes
    rounding = 16 * np.finfo(float).eps * abs(end).max()
    np.testing.assert_allclose(r.y[:, -1], end, rtol=0.0, atol=rounding)


@pytest.mark.parametrize("function", TAKEN)
def test_an_option_that_a_stand_in_takes_has_the_values_of_numpy(function):
    traced = trace(lambda t, y: function(y), (), 3, (3,))
    found = evaluate(traced.graph, traced.outputs, np.zeros(1), Y[:, None], [])[0].ravel()
    np.testing.assert_allclose(found, function(Y), rtol=4 * np.finfo(float).eps)


def unread():
    """(function, argument) of each argument that the body of a stand-in does not read."""
    for path in FOLDER.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.FunctionDef) or path.name in ("stand_ins.py", "objects.py"):
                continue
            given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
            given += filter(None, [node.args.kwarg])
            read = {n.id for part in node.body for n in ast.walk(part) if isinstance(n, ast.Name)}
            yield from ((node.name, a.arg) for a in given if a.arg not in read | {"self", "cls"})


def test_no_stand_in_takes_an_option_that_it_does_not_read():
    found = set(unread())
    assert ("function", "workers") in found  # of SciPy's transforms: how many threads compute
    assert found - NO_VALUE - {("function", "workers")} == set()
