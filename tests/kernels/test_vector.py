"""Vectors: each lane holds what the number alone would be."""

import itertools
import math
import operator

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError

from fastdyn.kernels.ensemble import lanes
from fastdyn.kernels.state.layout import Form
from support.by_vectors import ANY, SPECIAL, numbers, same, uniform, vectors

PAIRS = np.array([*itertools.product(SPECIAL, SPECIAL)]).T
OF_ONE = {
    "neg": lambda x: -x,
    "abs": lambda x: abs(x),
    "sqrt": lambda x: math.sqrt(abs(x)),
    "floor": lambda x: np.floor(x),
    "rint": lambda x: np.rint(x),
    "sign": lambda x: np.sign(x),
    "square": lambda x: np.square(x),
    "reciprocal": lambda x: np.reciprocal(x),
    "radians": lambda x: math.radians(x),
    "degrees": lambda x: np.degrees(x),
    "isnan": lambda x: np.where(np.isnan(x), 1.0, 2.0),
    "isinf": lambda x: np.where(np.isinf(x), 1.0, 2.0),
    "isfinite": lambda x: np.where(math.isfinite(x), 1.0, 2.0),
    "inside": lambda x: np.where((x > -1.0) & (x <= 2.0) | (x == 5.0), x, 0.0),
    "unequal": lambda x: np.where(x != 1.0, 2.0, 3.0),
    "conversion": lambda x: float(x) + np.float64(1),
}
OF_TWO = {
    "add": operator.add,
    "sub": operator.sub,
    "mul": operator.mul,
    "truediv": operator.truediv,
    "mod": operator.mod,
    "floordiv": operator.floordiv,
    "fmod": np.fmod,
    "copysign": math.copysign,
    "min": min,
    "max": max,
    "minimum": np.minimum,
    "maximum": np.maximum,
}


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


@pytest.mark.parametrize("n", [*range(-4, 8), 20, 63])
def test_a_whole_power_multiplies_as_for_numbers(n):
    namespace = {}
    exec(f"def power(x):\n    return x**{n}", namespace)  # so that the exponent is a literal
    x = ANY[abs(ANY) > 1e-5]
    assert same(vectors(namespace["power"], x), numbers(namespace["power"], x))


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
