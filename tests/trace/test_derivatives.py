"""Derivatives of graphs beside differences in sixty digits: the formulas, without rounding.

What constants of a formula are rounded to (log 2, 1 / b) leaves a few units of a double.
"""

import math

import numpy as np
import pytest
from mpmath import mp

from fastdyn.systems import SYSTEMS
from fastdyn.trace.graph.derivatives import entries, jacobian, partials, time_derivative
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.refusal import Untraceable
from fastdyn.trace.paths.runs import trace
from support.branching import drawn
from support.in_digits import differences, exactly
from support.of_numbers import FP, ONE, TWO, XP

EPS = np.finfo(float).eps


def traced(fun, n, args=(), varying=()):
    return trace(fun, args, n, (n,), varying)


def dense(entries, shape):
    found = np.zeros(shape, dtype=object)
    found[:] = None
    found[entries.rows, entries.columns] = entries.nodes
    return found


def check(found, n, y, t=0.3, slots=None):
    """All derivatives at a point; those left out are zero."""
    g, outputs, values = found.graph, found.outputs, found.graph.values
    slots = list(range(len(values))) if slots is None else slots
    wrt = [("t", 0), *[("y", i) for i in range(n)], *[("par", slot) for slot in slots]]
    inputs = [g.make(kind, (), None if kind == "t" else i) for kind, i in wrt]
    rows = partials(g, outputs, inputs)
    nodes = [row.get(i, g.const(0.0)) for row in rows for i in range(len(inputs))]
    mine = exactly(g, nodes, t, y, values).reshape(len(outputs), -1)
    expected = differences(g, outputs, t, y, values, wrt)
    scale = 1 + max([abs(b) for b in expected.flat if not mp.isnan(b)], default=0)
    for a, b in zip(mine.flat, expected.flat, strict=True):
        assert mp.isnan(b) or abs(a - b) <= 64 * EPS * scale


@pytest.mark.parametrize("name", ONE)
def test_functions_of_one_number(name):
    found = traced(lambda t, y: [ONE[name](y[0])], 1)
    for x in (0.37, 0.91):
        check(found, 1, [x])


@pytest.mark.parametrize("name", TWO)
def test_functions_of_two_numbers(name):
    found = traced(lambda t, y, p: [TWO[name](y[0], y[1]), TWO[name](y[1] * t, p)], 2, (0.7,))
    for y in ([0.37, 0.91], [2.3, 0.4], [-1.3, 0.3]):
        check(found, 2, y)


def test_parameters_in_tables():
    def fun(t, y, table, heights):
        i = int(y[0])
        return [table[i] * y[1], np.interp(y[1], XP, heights)]

    args = np.array([0.2, 0.5, -0.4, 1.0, 3.0]), FP.copy()
    found = traced(fun, 2, args)
    for y in ([2.4, 0.6], [-1.5, -2.0], [0.2, 4.9], [3.1, 7.0], [3.1, -7.0]):
        check(found, 2, y)


@pytest.mark.hunt
@pytest.mark.parametrize("seed", range(30))
def test_random_functions_that_branch(seed):
    fun, n, args, _ = drawn(seed)
    try:
        found = traced(fun, n, args)
    except Untraceable:
        return
    rng = np.random.default_rng(seed)
    for i in range(3):
        y = rng.normal(size=n) * (0.3, 1.0, 3.0)[i]
        values = found.graph.values
        values[:] = np.array(values) + 0.01 * rng.random(len(values))  # off the kinks
        check(found, n, y, rng.normal(), range(min(3, len(found.graph.values))))


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_systems_of_the_course(name):
    system = SYSTEMS[name]()
    y0 = np.asarray(system.initial_state(), float)
    n = len(y0)
    found = traced(system.rhs, n, system.args)
    rng = np.random.default_rng(1)
    check(found, n, y0 + 0.1 * rng.normal(size=n), slots=[])
    whole = jacobian(found.graph, found.outputs, n)
    assert list(zip(whole.columns, whole.rows, strict=True)) == sorted(
        zip(whole.columns, whole.rows, strict=True)
    )


def at(found, nodes, y, t=0.0):
    y = np.asarray(y, float)[:, None]
    return evaluate(found.graph, nodes, np.array([t]), y, found.graph.values)[0][:, 0]


@pytest.mark.parametrize(
    ("fun", "below", "above"),
    [
        (abs, -1.0, 1.0),
        (lambda x: np.maximum(x, 3 * x), 1.0, 3.0),
        (lambda x: np.clip(x, 0.0, 2.0), 0.0, 1.0),
        (lambda x: x if x > 0 else 5 * x, 5.0, 1.0),
        (lambda x: np.where(x < 0, x * x, 2 * x), 0.0, 2.0),
    ],
)
def test_a_kink_has_the_slopes_of_its_sides_and_one_of_them_itself(fun, below, above):
    found = traced(lambda t, y: [fun(y[0])], 1)
    (node,) = jacobian(found.graph, found.outputs, 1).nodes
    tiny = 1e-300
    assert at(found, [node], [-tiny]) == pytest.approx(below, abs=1e-290)
    assert at(found, [node], [tiny]) == above
    assert at(found, [node], [0.0]) in (below, above)


@pytest.mark.parametrize(
    ("fun", "expected"),
    [
        (lambda x, v: np.hypot(x, v) * x, (0.0, 0.0)),  # drag, at rest
        (lambda x, v: (x * x) ** 1.5 + abs(v) * v, (0.0, 0.0)),
        (lambda x, v: np.sin(x) / x if x != 0 else 1.0, (0.0, 0.0)),
        (lambda x, v: np.sinc(x) + v, (0.0, 1.0)),
        (lambda x, v: (x % 3.0) + 2 * (v % 1.0), (1.0, 2.0)),
        (lambda x, v: 0.0 if x == 0 else x * x * v, (0.0, 0.0)),
    ],
)
def test_slopes_at_points_of_their_own(fun, expected):
    """0/0 in a formula, where the function has a slope."""
    found = traced(lambda t, y: [fun(y[0], y[1]), y[0]], 2)
    rows = dense(jacobian(found.graph, found.outputs, 2), (2, 2))[0]
    zero = found.graph.const(0.0)
    values = at(found, [node or zero for node in rows], [0.0, 0.0])
    assert tuple(values) == expected


def test_a_question_for_nan_is_no_point():
    found = traced(lambda t, y: [y[0] * y[1] if y[0] == y[0] else 0.0, y[0]], 2)
    rows = dense(jacobian(found.graph, found.outputs, 2), (2, 2))[0]
    assert tuple(at(found, list(rows), [3.0, 2.0])) == (2.0, 3.0)


def test_an_infinite_slope_is_not_hidden():
    found = traced(lambda t, y: [np.sqrt(y[0]) * np.cbrt(y[0] + t)], 1)
    assert not np.isfinite(at(found, jacobian(found.graph, found.outputs, 1).nodes, [0.0])).any()


def heat(t, u, k):
    return k * (np.roll(u, 1) - 2 * u + np.roll(u, -1)) + u * (1 - u)


def bodies(t, w):
    count = len(w) // 6
    r, v = w[: 3 * count].reshape(count, 3), w[3 * count :]
    a = np.zeros((count, 3))
    for i in range(count):
        for j in range(i):
            d = r[j] - r[i]
            f = d / np.linalg.norm(d) ** 3
            a[i] += f
            a[j] -= f
    return np.concatenate([v, a.ravel()])


def test_the_pattern_is_that_of_the_equations():
    n = 1000
    found = traced(heat, n, (2.0,))
    whole = jacobian(found.graph, found.outputs, n)
    assert len(whole.nodes) == 3 * n
    assert set(np.unique((whole.rows - whole.columns) % n)) == {0, 1, n - 1}
    assert len(live(whole.nodes)) < 5 * n + 10  # parts in common are there once
    by_k = entries(partials(found.graph, found.outputs, [found.graph.make("par", (), 0)]))
    assert np.array_equal(by_k.rows, np.arange(n)) and not by_k.columns.any()
    assert {node.data for node in time_derivative(found.graph, found.outputs)} == {0.0}


def test_large_graphs_have_as_many_nodes_as_terms():
    """Forty bodies: 14 520 entries; a hundred have too many, and are refused."""
    found = traced(bodies, 240)
    whole = jacobian(found.graph, found.outputs, 240)
    assert len(whole.nodes) == 120 + 120**2
    assert len(found.graph.nodes) < 6 * 120**2
    with pytest.raises(Untraceable, match="too many operations"):
        mean = traced(lambda t, y: y * np.sin(y).sum(), 400)
        jacobian(mean.graph, mean.outputs, 400)


def test_what_has_no_rule_is_refused():
    found = traced(lambda t, y: [math.lgamma(y[0]) + y[1], math.lgamma(2.5 + t)], 2)
    with pytest.raises(Untraceable, match="lgamma"):
        jacobian(found.graph, found.outputs, 2)
    assert len(jacobian(found.graph, found.outputs[1:], 2).nodes) == 0


def test_the_whole_number_in_a_remainder_is_not_missed_by_rounding():
    found = traced(lambda t, y: [np.fmod(y[0], y[1]), y[0]], 2)
    node = dense(jacobian(found.graph, found.outputs, 2), (2, 2))[0, 1]
    for k in range(1, 200):
        a, b = 0.1 * k + 1e-3, 0.1
        assert at(found, [node], [a, b])[0] == -(a // b)
