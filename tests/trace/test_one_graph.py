"""However a function is written, its graph is the same: the same code, at the same cost."""

import functools
import math

import numpy as np
import pytest

from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced.code import Traced
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.paths.runs import trace


def key(fun, n, args=()):
    return Traced(trace(fun, args, n, (n,)), DERIVATIVE, n).key()


def power(t, w):
    x, y, vx, vy = w
    r3 = (x * x + y * y) ** 1.5
    return [vx, vy, -x / r3, -y / r3]


def root_of_squares(t, w):
    x, y, vx, vy = w
    return vx, vy, -x / np.sqrt(x**2 + y**2) ** 3, -y / np.sqrt(x**2 + y**2) ** 3


def three_factors(t, w):
    r = math.sqrt(w[0] ** 2 + w[1] ** 2)
    return np.array([w[2], w[3], -(w[0] / (r * r * r)), -w[1] / (r * r * r)])


def hypotenuse(t, w):
    d = np.zeros(4)
    d[:2] = w[2:]
    d[2:] = -w[:2] / np.hypot(w[0], w[1]) ** 3
    return d


def norm(t, w):
    return np.concatenate([w[2:], -w[:2] / np.linalg.norm(w[:2]) ** 3])


def dot(t, w):
    q = w[:2]
    return np.r_[w[2:], -q / (q @ q) ** (3 / 2)]


def by_methods(t, w):
    r = (w[:2] ** 2).sum() ** 0.5
    return np.hstack((w[2:], np.negative(w[:2]) / r**3))


def in_a_loop(t, w):
    total = 0
    for q in w[:2]:
        total += q * q
    r = np.power(total, 0.5)
    return [*w[2:], *[-q / r**3 for q in w[:2]]]


@pytest.mark.parametrize(
    "fun", [root_of_squares, norm, dot, by_methods, in_a_loop], ids=lambda f: f.__name__
)
def test_the_way_of_writing_does_not_matter(fun):
    assert key(fun, 4) == key(power, 4)


def test_a_hypotenuse_adds_only_where_its_squares_overflow_or_vanish():
    one, other = (trace(f, (), 4, (4,)) for f in (power, hypotenuse))
    a, b = ([(n.op, n.data) for n in live(each.outputs)] for each in (one, other))
    assert a == b and other.failing is other.graph.false and other.raising is not other.failing


def test_functions_of_math_add_only_what_raises():
    assert three_factors.__name__  # `math.sqrt` raises where NumPy gives nan
    one, other = (trace(f, (), 4, (4,)) for f in (power, three_factors))
    same = [(n.op, n.data) for n in live(one.outputs)] == [
        (n.op, n.data) for n in live(other.outputs)
    ]
    assert same and other.raising is not other.graph.false


def by_slices(t, y):
    matrix = np.zeros((4, 4))
    matrix[:2, 2:], matrix[2:, :2], matrix[2, 3], matrix[3, 3] = np.eye(2), np.diag(y[:2]), t, 2
    return matrix @ y


def by_blocks(t, y):
    corner = np.block([[0, t], [0.0, np.array([2])]])
    return np.block([[np.zeros((2, 2)), np.eye(2)], [np.diag(y[:2]), corner]]) @ y


def of_complex_blocks(t, y):
    return (np.block([[np.eye(2) * y[0], 1j * np.eye(2)]]) @ y).imag


def test_blocks_are_slices():
    assert key(by_slices, 4) == key(by_blocks, 4)
    y = np.arange(1.0, 5.0)
    found = trace(of_complex_blocks, (), 4, (2,))
    values, _ = evaluate(found.graph, found.outputs, np.zeros(1), y[:, None], ())
    assert values.ravel().tolist() == [3.0, 4.0]


def test_a_fold_is_a_chain():
    def largest(t, w):  # as SymPy writes Max
        return functools.reduce(np.maximum, (w[0], t, w[1])) * w

    assert key(largest, 4) == key(lambda t, w: np.maximum(np.maximum(w[0], t), w[1]) * w, 4)


def test_a_new_value_is_not_new_code():
    def fun(t, y, k, many, named):
        return [y[1], -k * y[0] - many[0] * named["c"] * y[1] ** 2]

    first = key(fun, 2, (2.0, [0.1, 3.0], {"c": 1.0}))
    assert first == key(fun, 2, (5.5, [0.7, 9.0], {"c": -1.0}))
    assert first == key(fun, 2, (2.25, [0.1, 4.0], {"c": 7.0}))


def test_structure_is_part_of_the_code():
    def fun(t, y, n):
        return [sum(y[0] ** i for i in range(n)), y[0]]

    assert key(fun, 2, (2,)) != key(fun, 2, (3,))


def test_signs_of_zero_are_kept():
    def fun(t, y):
        return [np.arctan2(0 * y[1], 0.0 - y[0]), y[0]]

    found = trace(fun, (), 2, (2,))
    from fastdyn.trace.graph.evaluate import evaluate

    values, _ = evaluate(found.graph, found.outputs, np.zeros(1), np.zeros((2, 1)), [])
    assert values[0, 0] == fun(0.0, np.zeros(2))[0] == 0.0
