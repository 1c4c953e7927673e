"""Vectors: each lane holds what the number alone would be."""

import itertools
import operator

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError

from fastdyn.kernels.ensemble import lanes
from fastdyn.kernels.state.layout import Form
from fastdyn.kernels.vector.scalar_or_vector import fused, rare, select
from support.by_vectors import ANY, SPECIAL, formula, numbers, same, uniform, vectors

PAIRS = np.array([*itertools.product(SPECIAL, SPECIAL)]).T
OF_ONE = {
    "neg": lambda x: -x,
    "abs": lambda x: abs(x),
    "sqrt": lambda x: np.sqrt(abs(x)),
    "inside": lambda x: select((x > -1.0) & (x <= 2.0) | (x == 5.0), x, 0.0),
    "outside": lambda x: select(~(x >= -1.0), x, 0.0),
    "unequal": lambda x: select(x != 1.0, 2.0, 3.0),
    "rare": lambda x: select(rare(x > 1.0), 2.0 * x, x),
    "fused": lambda x: fused(x, 3.0, 1.0),
}
OF_TWO = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "truediv": operator.truediv,
}


@pytest.mark.few(2)
@pytest.mark.parametrize("name", OF_ONE)
def test_a_lane_holds_what_the_number_would_be(name):
    function = OF_ONE[name]
    expected = numbers(function, ANY)
    for width in (2, 4, 8):
        assert same(vectors(function, ANY, width=width), expected)


@pytest.mark.parametrize("name", OF_TWO)
def test_a_lane_of_two_vectors_holds_what_the_numbers_would_be(name):
    of_two = OF_TWO[name]
    a, b = np.concatenate([PAIRS, [uniform(-9, 9), uniform(-9, 9)]], axis=1)
    found = vectors(lambda x, y: of_two(x, y), a, b)
    assert same(found, numbers(lambda x, y: of_two(x, y), a, b))


def test_the_remainder_is_cs():
    a, b = np.concatenate([PAIRS, [uniform(-9, 9), uniform(-9, 9)]], axis=1)
    remainder = formula("fmod", 2)
    with np.errstate(invalid="ignore"):
        assert same(vectors(lambda x, y: remainder(x, y), a, b), np.fmod(a, b))


def test_a_number_becomes_a_vector_where_it_meets_one():
    def summed(x):
        s = 0.0
        for i in range(3):
            s += x * i
        return s

    assert same(vectors(summed, ANY), numbers(summed, ANY))


def test_vectors_of_two_widths_do_not_mix():
    four, eight = Form(1, 4), Form(1, 8)

    @njit
    def mixed(a):
        lanes.leave(eight, a, 0, lanes.field(four, a, 0) + lanes.field(eight, a, 0))

    with pytest.raises(TypingError):
        mixed(np.ones((2, 8)))
