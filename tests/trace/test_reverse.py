"""Reverse mode is the transpose of forward mode: k^T (J v) = (k^T J) v."""

import math
import warnings

import numpy as np
import pytest
from hostile.compose import draw_case

from fastdyn.systems import SYSTEMS
from fastdyn.trace.graph.derivatives import partials
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.graph.reverse import pullback
from fastdyn.trace.paths.runs import trace
from support.branching import drawn
from support.of_numbers import ONE, TWO

EPS = np.finfo(float).eps


def traced(fun, n, args=(), m=None):
    return trace(fun, args, n, (m or n,), ())


def check(found, n, t, y, seed=0):
    """Compare both products at points, t (k,) and y (n, k); the number of finite comparisons."""
    g, values, rng = found.graph, found.graph.values, np.random.default_rng(seed)
    inputs = [g.make("y", (), i) for i in range(n)]
    inputs += [g.make("par", (), slot) for slot in range(min(40, len(values)))]
    k, v = rng.normal(size=len(found.outputs)), rng.normal(size=len(inputs))
    rows = partials(g, found.outputs, inputs)
    places = [(i, j) for i, row in enumerate(rows) for j in row]
    read = []
    ends = [g.const(x) for x in k]
    columns = pullback(g, found.outputs, ends, inputs)
    columns += pullback(g, found.outputs, ends, inputs, read)
    nodes = [rows[i][j] for i, j in places] + columns
    of_reads = [node for _, *own in read for node in own]
    entries, of_reads = np.split(evaluate(g, nodes + of_reads, t, y, values)[0], [len(nodes)])
    with np.errstate(all="ignore"):
        forward = [k[i] * v[j] * row for (i, j), row in zip(places, entries, strict=False)]
        terms = np.array(forward).reshape(-1, len(t))
        expected, size = terms.sum(axis=0), np.abs(terms).sum(axis=0)
        whole, mine = (v[:, None] * np.split(entries[len(places) :], 2)).sum(axis=1)
        for (at, *_), index, cotangent in zip(read, of_reads[::2], of_reads[1::2], strict=True):
            mine += v[at][np.clip(index, -len(at), len(at) - 1).astype(int)] * cotangent
        largest = np.abs(entries).max(axis=0, initial=0.0)  # factors that cancel in a sum
    finite = np.isfinite(expected)
    for found in (whole, mine):
        error = np.abs(found - expected)[finite]
        assert (error <= 1e4 * EPS * (size + largest)[finite]).all(), (found, expected)
    return np.count_nonzero(finite & (size > 0))


@pytest.mark.parametrize("name", [*ONE, *TWO])
def test_functions_of_one_and_two_numbers(name):
    fun = ONE.get(name) or (lambda x, name=name: TWO[name](x, 0.3 + x * x))
    found = traced(lambda t, y, p: [fun(y[0]) * y[1], fun(y[1] * p) - y[0]], 2, (0.7,))
    y = np.random.default_rng(0).uniform(0.1, 0.9, (2, 20))
    assert check(found, 2, np.full(20, 0.3), y) == 20


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_systems_of_the_course(name):
    system = SYSTEMS[name]()
    y0 = np.asarray(system.initial_state(), float)
    found = traced(system.rhs, len(y0), system.args)
    y = y0[:, None] + 0.1 * np.random.default_rng(1).normal(size=(len(y0), 8))
    assert check(found, len(y0), np.full(8, 0.3), y) > 0


@pytest.mark.few(6)
@pytest.mark.parametrize("seed", range(30))
def test_random_functions_that_branch(seed):
    fun, n, args, _ = drawn(seed)
    try:
        found = traced(fun, n, args)
    except Untraceable:
        return
    rng = np.random.default_rng(seed)
    check(found, n, rng.normal(size=30), rng.normal(size=(n, 30)) * rng.choice([0.3, 1.0, 3.0]))


@pytest.mark.few(20)
@pytest.mark.parametrize("index", [*range(100), 174, 263, 304, 399])
def test_random_functions_of_the_idioms(index):
    family = ("numbers", "arrays", "of_numpy", "tables", "language")[index % 5]
    module: dict = {"__name__": "drawn"}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            exec(draw_case(5, index // 5, light=True, family=family).source, module)
            y0 = np.asarray(module["HOW"]["y0"], float)
            found = traced(module["fun"], len(y0), tuple(module["HOW"].get("args", ())))
            t = np.linspace(0.0, 2.0, 20)
            y = y0[:, None] * np.random.default_rng(index).uniform(0.5, 1.5, (len(y0), 20))
            check(found, len(y0), t, y)
        except (Untraceable, ImportError, ValueError, TypeError) as reason:
            pytest.skip(f"{reason}"[:60])


READS = {  # of a table of u, at a place that moves
    "entry": lambda t, u: u[int(abs(t))],
    "neighbours": lambda t, u: u[int(abs(t))] * u[-1 - int(abs(t))],
    "chord": lambda t, u: np.interp(t, np.arange(float(len(u))), u),
    "knot": lambda t, u: np.interp(t, u, np.arange(float(len(u)))),
}


@pytest.mark.parametrize("name", READS)
def test_a_read_of_a_long_table_gives_its_own_entries(name):
    """As many nodes for 300 entries as for 10; np.interp names the two ends, too."""
    sizes = []
    for n in (10, 30, 300):
        found = traced(lambda t, y, u: [READS[name](t, u) * y[0]], 1, (np.linspace(0.1, 2.0, n),))
        g = found.graph
        inputs = [g.make("y", (), 0)] + [g.make("par", (), slot) for slot in range(n)]
        read = []
        sums = pullback(g, found.outputs, [g.const(1.0)], inputs, read)
        sizes.append(len(live([*sums, *(node for _, *own in read for node in own)])))
        if n < 40:
            assert check(found, 1, np.linspace(0.2, 1.8, 50), np.ones((1, 50))) > 0
    assert len(set(sizes)) == 1


@pytest.mark.parametrize(
    ("fun", "y", "expected"),
    [
        (lambda x, v: np.hypot(x, v) * x, (0, 0), (0, 0)),  # drag, at rest
        (lambda x, v: (x * x) ** 1.5 + abs(v) * v, (0, 0), (0, 0)),
        (lambda x, v: np.sin(x) / x if x != 0 else 1.0, (0, 1), (0, 0)),
        (lambda x, v: 0.0 if x == 0 else x * x * v, (0, 2), (0, 0)),
        (lambda x, v: 0.0 if x == 0 else x * v, (0, 2), (2, 0)),
        (lambda x, v: np.where(x > 0, np.log(x), v), (-1, 3), (0, 1)),
        (lambda x, v: np.where(x > 0, np.sqrt(x) * v, 2 * v), (0, 3), (0, 2)),
        (lambda x, v: np.where(v > 0, 1 / (x * v), v), (0, -1), (0, 1)),
        (lambda x, v: np.sqrt(1 - np.cos(x) ** 2) + v, (0, 1), (0, 1)),
        (lambda x, v: x * v if x == x else 0.0, (3, 2), (2, 3)),  # not NaN
    ],
)
def test_slopes_at_points_of_their_own(fun, y, expected):
    """0 / 0 and 0 inf in a formula, and in a branch that is not taken."""
    found = traced(lambda t, y: [fun(y[0], y[1])], 2, m=1)
    g = found.graph
    nodes = pullback(g, found.outputs, [g.const(1.0)], [g.make("y", (), i) for i in range(2)])
    at = np.array(y, float)[:, None]
    assert tuple(evaluate(g, nodes, np.zeros(1), at, g.values)[0][:, 0]) == expected


def test_an_infinite_slope_is_not_hidden():
    found = traced(lambda t, y: [np.sqrt(y[0]) + y[1]], 2, m=1)
    g = found.graph
    nodes = pullback(g, found.outputs, [g.const(1.0)], [g.make("y", (), i) for i in range(2)])
    assert evaluate(g, nodes, np.zeros(1), np.zeros((2, 1)), g.values)[0][0, 0] == np.inf


def test_what_has_no_rule_is_refused():
    found = traced(lambda t, y: [math.lgamma(y[0]) + y[1]], 2, m=1)
    g = found.graph
    with pytest.raises(Untraceable, match="lgamma"):
        pullback(g, found.outputs, [g.const(1.0)], [g.make("y", (), 0)])
    by_other = pullback(g, found.outputs, [g.const(1.0)], [g.make("y", (), 1)])
    assert by_other[0].data == 1.0
