"""Dense plans: the code is made from loops and short blocks, the numbers are those of a pair."""

import re

import numpy as np
import pytest

import fastdyn
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.taylor.recurrences.operations import Integral
from fastdyn.compile.taylor.recurrences.plan import Plan
from fastdyn.compile.taylor.text import lines
from fastdyn.compile.traced import series
from fastdyn.compile.traced.code import MANY_OPERATIONS, Traced
from fastdyn.specialise.series import NoSeries
from fastdyn.trace.paths.runs import trace
from tests.support.smooth import write_in_rows


class Network:
    """Oscillators, each coupled to each."""

    def __init__(self, n):
        rng = np.random.default_rng(n)
        self.coupling, self.rates = rng.random((n, n)) / n, rng.normal(size=n)
        self.y0 = 6.0 * rng.random(n)

    def __call__(self, t, y):
        i, j = np.meshgrid(y, y)
        return self.rates + (self.coupling * np.sin(j - i)).sum(axis=0)


def traced(fun, n):
    return Traced(trace(fun, (), n, (n,), (), "all", 0, False), DERIVATIVE, n)


def plan(fun, n):
    found = traced(fun, n)
    return Plan(found.trace.graph, found.stored, found.trace.graph.false)


def end(fun, y0, method="Taylor"):
    options = {"rtol": 1e-9, "atol": 1e-9} if method == "Taylor" else {"rtol": 1e-12, "atol": 1e-12}
    return fastdyn.solve_ivp(fun, (0.0, 2.0), y0, method, t_eval=[2.0], **options).y[:, 0]


def blocks(text):
    """The numbers of lines of the blocks of a series."""
    code = text[text.index("@series(double") :]
    return [block.count("\n") for block in re.split(r"\n\w+:\n", code)]


@pytest.mark.hunt
def test_a_long_block_is_cut(monkeypatch):
    """The numbers are the same, to the bit."""
    ends, longest, fun = [], [], Network(10)
    for most in (lines.LONG, 10**9):
        monkeypatch.setattr(lines, "LONG", most)
        write_in_rows(monkeypatch, rows=True)
        longest.append(max(blocks(series.text(traced(fun, 10), "kernel", 17, False))))
        ends.append(end(fun, fun.y0))
    assert longest[0] <= 2 * lines.SHORT and longest[1] > 5000
    assert (ends[0] == ends[1]).all()


def test_elements_of_a_matrix_are_copied_in_a_loop():
    """Copied one by one, 1600 elements take 6 s.  The values are read anew at each call."""
    text = series.text(traced(Network(40), 40), "kernel", 17, False)
    assert text[text.index("define void") : text.index("\n}")].count("\n") < 400
    fun = Network(20)
    for _ in range(2):
        np.testing.assert_allclose(end(fun, fun.y0), end(fun, fun.y0, "DOP853"), atol=1e-8)
        fun.coupling *= -1.5


@pytest.mark.parametrize("n", [7, 12])
def test_sines_of_both_signs_share_a_recurrence(n):
    pairs = n * (n - 1) // 2
    calls = sum(isinstance(step, Integral) for step in plan(Network(n), n).steps)
    assert calls == 2 * n + 2 * pairs


@pytest.mark.hunt
def test_a_dense_matrix_has_like_nodes_in_the_lanes(monkeypatch):
    matrix = np.random.default_rng(1).normal(size=(20, 20)) / 20.0

    def neurons(t, y):
        return np.tanh(matrix @ y) - y

    assert plan(neurons, 20).n_sums <= series.MAX_ONLINE < series.size_of(plan(neurons, 20))
    y0 = np.linspace(-1.0, 1.0, 20)
    np.testing.assert_allclose(end(neurons, y0), end(neurons, y0, "DOP853"), atol=1e-8)
    write_in_rows(monkeypatch, rows=False)
    np.testing.assert_allclose(end(neurons, y0), end(neurons, y0, "DOP853"), atol=1e-8)


def test_long_sums_become_loops():
    """In straight-line code, each of 9 orders of 63 neurons had 500 products."""
    matrix = np.random.default_rng(1).normal(size=(63, 63))
    text = series.text(traced(lambda t, y: matrix @ y, 63), "kernel", 17, False)
    assert max(blocks(text)) < 1000


def test_auto_leaves_a_large_plan_to_a_pair(capfd):
    """By its size alone; Taylor asked for by name says what it does while nothing is seen."""
    n = 46  # 46^2 sines and differences, and a sum of as many products
    fun = Network(n)
    assert traced(fun, n).n_operations > MANY_OPERATIONS > traced(Network(40), 40).n_operations
    options = {"rtol": 1e-7, "atol": 1e-7, "t_eval": [0.5]}
    found = fastdyn.solve_ivp(fun, (0.0, 0.5), fun.y0, "auto", **options)
    assert found.method == "Vern7" and "operations" in found.reason
    assert "series" not in capfd.readouterr().err
    with capfd.disabled():
        few = fastdyn.solve_ivp(Network(20), (0.0, 0.5), Network(20).y0, "auto", **options)
    assert few.method == "Taylor"
    traced(fun, n).tell_if_long()
    assert f"{traced(fun, n).n_operations} operations" in capfd.readouterr().err


def test_what_was_solved_before_does_not_decide():
    network = Network(46)

    def fun(t, y):
        return network(t, y)

    options = {"rtol": 1e-7, "atol": 1e-7, "t_eval": [0.5]}
    first = [fastdyn.solve_ivp(fun, (0.0, 0.5), network.y0, "Taylor", **options) for _ in range(2)]
    for _ in range(3):
        found = fastdyn.solve_ivp(fun, (0.0, 0.5), network.y0, "auto", **options)
        assert found.method == "Vern7"
    np.testing.assert_allclose(first[1].y, found.y, atol=1e-6)


def test_errors_that_raise_are_named_as_the_reason():
    with np.errstate(all="raise"), pytest.raises(NoSeries, match=re.escape("np.seterr")):
        fastdyn.solve_ivp(lambda t, y: [y[1], -y[0]], (0.0, 1.0), [1.0, 0.0], "Taylor")
