"""What index reduction finds in the structure of F(t, y, y') = 0."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fastdyn.dae.problem import checked
from fastdyn.dae.structure import reduce_index
from fastdyn.dae.structure.equations import equations
from fastdyn.dae.structure.signature import ABSENT, offsets
from fastdyn.trace.graph.derivatives import along
from fastdyn.trace.graph.evaluate import evaluate
from support.mechanisms import ANDREWS_START, CAR_AXIS_START, andrews, car_axis, pendulum


def test_pendulum_is_of_index_3():
    found = reduce_index(pendulum, [0.6, -0.8, 0, 0, 0], args=(1.0, 9.81))
    assert found.index == 3 and found.freedom == 2
    assert found.differentiated.tolist() == [1, 1, 0, 0, 2]  # Mattsson and Soederlind, section 2


def test_mechanisms_are_of_index_3():
    for function, start, counts in (
        (car_axis, CAR_AXIS_START, [1, 1, 1, 1, 0, 0, 0, 0, 2, 2]),
        (andrews, ANDREWS_START, [1] * 7 + [0] * 14 + [2] * 6),
    ):
        found = reduce_index(function, start)
        assert found.index == 3 and found.differentiated.tolist() == counts


@pytest.mark.parametrize("index", range(1, 7))
def test_index_of_a_chain(index):
    def chain(t, y, yp):
        return [*[yp[i] - y[i + 1] for i in range(index - 1)], y[0] - np.sin(t)]

    found = reduce_index(chain, np.zeros(index))
    assert found.index == index and found.freedom == 0


def test_ordinary_equations_have_index_0_and_semi_explicit_ones_index_1():
    assert reduce_index(lambda t, y, yp: [yp[0] - y[1], yp[1] + y[0]], [1, 0]).index == 0
    found = reduce_index(lambda t, y, yp: [yp[0] - y[1], y[1] ** 3 + y[0]], [1, 0])
    assert found.index == 1 and not found.differentiated.any()


def test_a_component_times_zero_is_absent():
    def two(t, y, yp):
        return [yp[0] - y[1], y[0] - t + 0 * y[1]]

    assert reduce_index(two, [0, 0]).index == 2


@settings(max_examples=100, deadline=None)
@given(st.integers(1, 5).flatmap(
    lambda n: st.lists(st.lists(st.sampled_from([ABSENT, ABSENT, 0, 1]), min_size=n, max_size=n),
                       min_size=n, max_size=n)))  # fmt: skip
def test_offsets_are_the_smallest_of_a_best_assignment(rows):
    sigma = np.array(rows)
    n, every = len(sigma), range(len(sigma))
    best = [
        sum(sigma[i, j] for i, j in enumerate(order))
        for order in itertools.permutations(every)
        if all(sigma[i, j] != ABSENT for i, j in enumerate(order))
    ]
    if not best:
        with pytest.raises(ValueError, match="structurally singular"):
            offsets(sigma, list(every), list(every))
        return
    c, d = offsets(sigma, list(every), list(every))
    assert ((d - c[:, None] >= sigma) | (sigma == ABSENT)).all() and c.min() == 0
    assert d.sum() - c.sum() == max(best)  # duality: no smaller degree of freedom exists
    for i in every:  # and no equation is differentiated in vain
        less = c - (np.arange(n) == i)
        smaller = np.where(sigma == ABSENT, ABSENT, sigma + less[:, None]).max(axis=0, initial=0)
        assert less[i] < 0 or smaller.sum() - less.sum() > max(best)


def test_time_derivatives_are_exact():
    def one(t, y, yp, a):
        return [np.sin(a * t) * y[0] ** 2 / (1 + yp[0] ** 2) + np.exp(-t) * np.sqrt(1 + y[0])]

    asked = checked(one, (0, 1), np.ones(1), np.ones(1), None, False, None, (1.5,), None, {})
    given, _ = equations(asked)
    g = given.graph
    motion = [(g.make("t"), g.const(1.0))]
    motion += [(given.node(0, k), given.node(0, k + 1)) for k in range(3)]
    first = along(g, given.outputs, motion)
    second = along(g, first, motion)

    def at(nodes, t):
        y = np.array([np.cos(t), -np.sin(t), -np.cos(t), np.sin(t)])
        return evaluate(g, nodes, np.array([t]), y[:, None], given.values)[0][0, 0]

    h, t = 1e-5, 0.4
    for low, high in ((given.outputs, first), (first, second)):
        slope = (at(low, t + h) - at(low, t - h)) / (2 * h)
        assert at(high, t) == pytest.approx(slope, rel=1e-8)


def test_functions_are_the_same_for_the_same_equations():
    a = reduce_index(pendulum, [0.6, -0.8, 0, 0, 0], args=(2.0, 9.81))
    b = reduce_index(pendulum, [0.6, -0.8, 0, 0, 0], args=(3.0, 9.81))
    assert a.motion is b.motion and a.projection is b.projection
    assert {2.0, 9.81} <= {*a.parameters} and {3.0, 9.81} <= {*b.parameters}
