"""A cached property gives the value that its object holds, as in Python, even when it is old."""

import functools

import numpy as np
import pytest
from scipy.integrate import solve_ivp as reference

import fastdyn
from fastdyn.compile.traced import find


class Model:
    def __init__(self, k):
        self.k = k

    @functools.cached_property
    def rate(self):
        return 2 * self.k + 0.1


def solved(solver, change):
    model, ends = Model(1.0), []

    def fun(t, y):
        return -model.rate * y + np.sin(model.k * t)

    for i in range(4):
        change(model, i)
        ends.append(solver(fun, (0, 2), [1.0]).y[0, -1])
    return ends


CHANGES = {
    "held before": lambda model, i: model.rate,
    "never": lambda model, i: None,
    "old": lambda model, i: setattr(model, "k", 1.0 + i),
    "forgotten": lambda model, i: (setattr(model, "k", 1.0 + i), vars(model).pop("rate", 0)),
    "set by hand": lambda model, i: setattr(model, "rate", 0.3 * i),
    "another class": lambda model, i: i == 2 and vars(model).update(rate=5.0),
}


@pytest.mark.parametrize("change", CHANGES)
def test_solutions_are_scipys(change):
    mine, theirs = (solved(f, CHANGES[change]) for f in (fastdyn.solve_ivp, reference))
    np.testing.assert_allclose(mine, theirs, rtol=1e-9)


def test_a_solution_in_a_function_is_read_once(monkeypatch):
    made, count = find._traced, []
    monkeypatch.setattr(find, "_traced", lambda *args: count.append(1) or made(*args))
    flow = fastdyn.solve_ivp(lambda t, y: -y, (0, 2), [1.0, 2.0], dense_output=True)
    count.clear()

    def fun(t, y):
        a, b = flow.sol(t)
        return y * a - b

    mine, theirs = (f(fun, (0, 2), [1.0], rtol=1e-8) for f in (fastdyn.solve_ivp, reference))
    fastdyn.solve_ivp(fun, (0, 2), [1.0], rtol=1e-8)
    assert len(count) == 1 and mine.nfev == theirs.nfev
    np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-8)
