"""Cached properties and functions give the values that they hold, as in Python, even old ones."""

import functools

import numpy as np
import pytest
from scipy.integrate import solve_ivp as reference

import fastdyn
from fastdyn.compile.traced import make as by_tracing


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
    made, count = by_tracing._traced, []
    monkeypatch.setattr(by_tracing, "_traced", lambda *args: count.append(1) or made(*args))
    flow = fastdyn.solve_ivp(lambda t, y: -y, (0, 2), [1.0, 2.0], dense_output=True)
    count.clear()

    def fun(t, y):
        a, b = flow.sol(t)
        return y * a - b

    mine, theirs = (f(fun, (0, 2), [1.0], rtol=1e-8) for f in (fastdyn.solve_ivp, reference))
    fastdyn.solve_ivp(fun, (0, 2), [1.0], rtol=1e-8)
    assert len(count) == 1 and mine.nfev == theirs.nfev
    np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-8)


RATES = {"a": 0.5, "b": 2.0}


def cached_solves(solver, maxsize, change):
    rates, ends, asked = dict(RATES), [], []

    @functools.lru_cache(maxsize=maxsize)
    def rate(name, factor=1.0):
        asked.append(name)
        return factor * rates[name]

    def fun(t, y):
        return -rate("a") * y + rate("b", factor=0.1) * np.sin(t)

    for i in range(4):
        change(i, rate, rates)
        ends.append(solver(fun, (0, 2), [1.0]).y[0, -1])
    return ends


CACHES = {
    "nothing": lambda i, rate, rates: None,
    "an old value": lambda i, rate, rates: rates.update(a=1.0 + i),
    "a new value": lambda i, rate, rates: (rates.update(a=1.0 + i), rate.cache_clear()),
    "other entries": lambda i, rate, rates: (rates.update(b=1.0 + i), rate("a", 2.0 * i)),
}


@pytest.mark.parametrize("change", CACHES)
@pytest.mark.parametrize("maxsize", [None, 128, 2, 1, 0])
def test_a_cached_function_gives_what_its_cache_holds(maxsize, change):
    ours, theirs = (
        cached_solves(f, maxsize, CACHES[change]) for f in (fastdyn.solve_ivp, reference)
    )
    np.testing.assert_allclose(ours, theirs, rtol=1e-9)


def test_a_cached_function_that_fails_later_is_heard():
    rates = dict(RATES)
    rate = functools.lru_cache(lambda name: rates[name])

    def fun(t, y):
        return -rate("a") * y

    fastdyn.solve_ivp(fun, (0, 2), [1.0])
    rates.clear()
    rate.cache_clear()
    with pytest.raises(KeyError):
        fastdyn.solve_ivp(fun, (0, 2), [1.0])


def test_a_function_with_a_cache_is_traced_once(monkeypatch):
    made, count = by_tracing._traced, []
    monkeypatch.setattr(by_tracing, "_traced", lambda *args: count.append(1) or made(*args))
    rate = functools.lru_cache(RATES.get)

    def fun(t, y):
        return -rate("a") * y

    for _ in range(5):  # the cache holds nothing before the first solve
        fastdyn.solve_ivp(fun, (0, 2), [1.0])
    assert len(count) == 2
