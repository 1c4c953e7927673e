"""A function of NumPy or SciPy is one record: with it, all that follows from a record works.

One of the functions here comes from C, the other is a formula.
"""

import contextlib

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import exp10

import fastdyn
from fastdyn.trace.graph.derivatives import jacobian
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.operations import NAMES, OPERATIONS, Operation, add
from fastdyn.trace.operations.functions import LOG_10, function
from fastdyn.trace.operations.value import exp, log1p
from fastdyn.trace.paths.runs import trace

RECORDS = {
    exp10: function(
        "exp10", exp10, lambda o, a: LOG_10 * o, series=lambda a: exp(LOG_10 * a), monotone=True
    ),
    np.logaddexp: Operation("logaddexp", formula=lambda a, b: a + log1p(exp(b - a))),
}  # fmt: skip
Y = np.array([0.3, -0.4])


def called(ufunc, y):
    return ufunc(*y[: ufunc.nin])


@contextlib.contextmanager
def known(ufunc):
    """A context in which a function has the record of these tests, whether it has one or none."""
    name = ufunc.__name__
    before = [(table, table.pop(name, None)) for table in (OPERATIONS, NAMES)]
    add(RECORDS[ufunc])
    try:
        yield
    finally:
        for table, record in before:
            del table[name]
            if record is not None:
                table[name] = record


@pytest.fixture(params=RECORDS, ids=lambda ufunc: ufunc.__name__)
def ufunc(request):
    """A function whose record is known during the test."""
    with known(request.param):
        yield request.param


def test_whoever_adds_one_of_these_records_breaks_no_test():
    with known(np.logaddexp):
        first = OPERATIONS["logaddexp"]
        with known(np.logaddexp):
            pass
        assert OPERATIONS["logaddexp"] is first and "logaddexp" in NAMES
    assert "logaddexp" not in OPERATIONS or OPERATIONS["logaddexp"] is not first


def test_value_and_derivative(ufunc):
    found = trace(lambda t, y: [called(ufunc, y), y[0]], (), 2, (2,))
    assert not any(node.op == "in c" for node in found.graph.nodes.values())
    entries = jacobian(found.graph, found.outputs, 2)
    of_first = [node for row, node in zip(entries.rows, entries.nodes, strict=True) if row == 0]
    nodes = [found.outputs[0], *of_first]
    value, *slopes = evaluate(found.graph, nodes, np.zeros(1), Y[:, None], [])[0].ravel()
    np.testing.assert_allclose(value, called(ufunc, Y), rtol=1e-15)
    for i, slope in enumerate(slopes):
        moved = [called(ufunc, Y + h * np.eye(2)[i]) for h in (1e-5, -1e-5)]
        np.testing.assert_allclose(slope, (moved[0] - moved[1]) / 2e-5, rtol=1e-9)


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
@pytest.mark.parametrize("method", ["DOP853", "BDF", "Taylor"])
def test_solutions(ufunc, method):
    def fun(t, y):
        return [y[1], -called(ufunc, y)]

    given = {"rtol": 1e-9, "atol": 1e-11}
    mine = fastdyn.solve_ivp(fun, (0.0, 2.0), Y, method=method, **given)
    theirs = solve_ivp(fun, (0.0, 2.0), Y, method="DOP853", **given)
    np.testing.assert_allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-6)


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
def test_an_ensemble(ufunc):
    def fun(t, y, k):
        return [y[1], -k * called(ufunc, y)]

    k = np.linspace(0.5, 1.0, 9)
    found = fastdyn.solve_ensemble(fun, (0.0, 2.0), Y, args=(k,), rtol=1e-9, atol=1e-11)
    for one, result in zip(k, found.y, strict=True):
        theirs = solve_ivp(fun, (0.0, 2.0), Y, args=(one,), rtol=1e-9, atol=1e-11)
        np.testing.assert_allclose(result, theirs.y[:, -1], rtol=1e-6)
