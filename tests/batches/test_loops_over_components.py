"""Functions that loop over their components, in batches: values, patterns, conditions."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fastdyn
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced import pointer_form
from fastdyn.compile.traced.code import Traced
from fastdyn.trace.emit import program
from fastdyn.trace.paths.runs import trace
from support.pointer_forms import compiled


def oscillators(t, y):
    d = np.zeros(len(y))
    for i in range(len(y)):
        s = 0.0
        for j in range(len(y)):
            s += math.sin(y[j] - y[i])
        d[i] = 0.1 * i + s / len(y)
    return d


def cable(t, y):
    n = len(y) // 2
    d = [0.0] * (2 * n)
    for i in range(n):
        u, v = y[2 * i], y[2 * i + 1]
        left = y[2 * i - 2] if i > 0 else 0.0
        right = y[2 * i + 2] if i < n - 1 else 1.0
        d[2 * i] = 9.0 * (left - 2 * u + right) + u - u**3 / 3 - v
        d[2 * i + 1] = 0.08 * (u + 0.7 - 0.8 * v) + math.exp(-u * u)
    return d


def of_pairs(t, y):
    n = len(y) // 2
    x, v = y[:n], y[n:]
    a = [0.0] * n
    for i in range(n):
        for j in range(i + 1, n):
            d = x[j] - x[i]
            f = d / (d * d + 0.1) ** 1.5
            a[i] += f
            a[j] -= f
    return [*v, *a]


DRAWN = np.random.default_rng(2)
REACTIONS = [(*map(int, DRAWN.integers(0, 80, 3)), float(DRAWN.random())) for _ in range(400)]


def reactions(t, y):
    d = [0.0] * 80
    for a, b, c, k in REACTIONS:
        rate = k * y[a] * y[b]
        d[a] -= rate
        d[b] -= rate
        d[c] += rate
    return d


def among_arrays(t, y):
    """Ends that are computed one by one, of an array that they are put back into."""
    n = len(y) // 2
    u = np.roll(y, 1) - 2 * y + np.roll(y, -1)
    ends = [math.sin(u[i]) * math.cos(y[i + 1]) + (u[i] > 0) * y[i] ** 3 for i in range(n)]
    total = np.concatenate([np.array(ends), u[n:]])
    return total - total.mean() * np.exp(-y * y)


def with_a_condition(t, y):
    pairs = zip(y, y[::-1], strict=True)
    return [np.where(v * w > 0.2, v - w, np.sqrt(4.0 + v * v * abs(w))) for v, w in pairs]


EDGES = np.triu(np.random.default_rng(1).random((20, 20)) < 0.2, 1)
NEIGHBOURS = [np.flatnonzero(among).tolist() for among in EDGES | EDGES.T]


def consensus(t, y):
    """Sums of few to many terms: some are rows, others single nodes, in no order."""
    d = np.zeros(20)
    for i, others in enumerate(NEIGHBOURS):
        for j in others:
            d[i] += np.tanh(y[j] - y[i])
    return d


BY_COMPONENTS = [
    (oscillators, 32), (cable, 200), (of_pairs, 64), (reactions, 80), (among_arrays, 160),
    (with_a_condition, 400), (consensus, 20),
]  # fmt: skip


@pytest.mark.few(4)
@pytest.mark.parametrize(("fun", "n"), BY_COMPONENTS)
@pytest.mark.parametrize("batches", [False, True])
def test_loops_over_components_have_the_values_of_python(fun, n, batches, monkeypatch):
    found = trace(fun, (), n, (n,), batches=batches)
    text = Traced(found, DERIVATIVE, n, batches).text("f")
    assert "fastdyn_loops" in text
    call = compiled(fun, n, (), True, monkeypatch, batches)
    rng = np.random.default_rng(1)
    for t in (0.0, 0.7):
        y = rng.standard_normal(n)
        expected = np.array(fun(t, y))
        bound = 16 * np.finfo(float).eps * n**0.5 * max(1.0, np.abs(expected).max())
        assert np.abs(call(t, y) - expected).max() < bound


def test_the_code_of_a_loop_over_components_grows_with_its_formulas():
    def length(n):
        return len(Traced(trace(cable, (), n, (n,)), DERIVATIVE, n).text("f").splitlines())

    assert length(1000) < 1.1 * length(400) < 1500


def test_the_pattern_of_single_results():
    n = 600
    traced = Traced(trace(cable, (), n, (n,), batches=True), DERIVATIVE, n, True)
    rows, columns = traced.pattern
    found = set(zip(rows.tolist(), columns.tolist(), strict=True))
    near = [(2 * i, 2 * j) for i in range(n // 2) for j in (i - 1, i, i + 1) if 0 <= j < n // 2]
    both = [(2 * i + a, 2 * i + b) for i in range(n // 2) for a, b in ((0, 1), (1, 0), (1, 1))]
    assert found == {*near, *both}


def test_the_pattern_of_results_that_are_computed_one_by_one(monkeypatch):
    monkeypatch.setattr(program, "worth_loops", lambda nodes: False)
    test_the_pattern_of_single_results()


def test_a_component_that_raises_among_many():
    """The condition is one of 300: found in a loop, and said as Python says it."""

    def roots(t, y):
        return [-math.sqrt(v) for v in y]

    y0 = np.linspace(1.0, 9.0, 300)
    with pytest.raises(ValueError, match=r"math domain error|expected a nonnegative"):
        fastdyn.solve_ivp(roots, (0, 10), y0, method="RK23", max_step=0.1)
    y0[:] = 9.0
    assert fastdyn.solve_ivp(roots, (0, 2), y0).success


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("method", ["RK45", "BDF", "LSODA"])
def test_solutions_of_loops_over_components(method):
    y0 = np.random.default_rng(3).standard_normal(40)
    for fun in (cable, of_pairs):
        mine = fastdyn.solve_ivp(fun, (0, 0.5), y0, method=method, rtol=1e-8, atol=1e-8)
        other = solve_ivp(fun, (0, 0.5), y0, method=method, rtol=1e-8, atol=1e-8)
        assert np.abs(mine.y[:, -1] - other.y[:, -1]).max() < 1e-5


def ring(t, y):
    return [math.sin(y[i - 1] - y[i]) + math.sin(y[i + 1 - len(y)] - y[i]) for i in range(len(y))]


def lorenz(t, y):
    return [(y[i + 1 - len(y)] - y[i - 2]) * y[i - 1] - y[i] + 8.0 for i in range(len(y))]


@pytest.mark.parametrize(
    ("fun", "n", "lanes", "in_loops"),
    [(ring, 8, 8, False), (ring, 12, 8, True), (ring, 12, 4, False), (lorenz, 40, 8, False)],
)
def test_functions_of_ten_components_become_loops_by_their_cost(
    fun, n, lanes, in_loops, monkeypatch
):
    """Loops pay for sines by formulas on vectors; vectors of two registers have `lanes` numbers."""
    monkeypatch.setattr(pointer_form, "width", lambda: lanes)
    function = compiled(fun, n, (), None, monkeypatch)
    traced = Traced(trace(fun, (), n, (n,)), DERIVATIVE, n)
    assert ("fastdyn_loops" in traced.text("fastdyn_test_ring")) == in_loops
    # Each of two sines is exact to two units in the last place, and so is C's to one.
    most = 7 * np.finfo(float).eps if fun is ring else 0.0
    for y in np.random.default_rng(n).normal(scale=9.0, size=(20, n)):
        assert abs(function(0.0, y) - fun(0.0, y)).max() <= most
