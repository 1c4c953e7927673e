"""Repeated solves follow what a function uses from outside, as Python does."""

import builtins
import math
import warnings

import numpy as np
import pytest
import scipy.integrate
from scipy.interpolate import interp1d

from fastdyn import solve_ivp
from support.repeated import (
    START,
    assert_same,
    both_ways,
    is_plain,
    plain,
    prepared,
    warm,
    was_ready,
)

g, length, table = 9.81, 1.0, np.array([0.5, 2.0, 1.5])


def pendulum(t, y, damping=0.1):
    return [y[1], -g / length * math.sin(y[0]) - damping * y[1]]


def gravity(x):
    return -g / length * math.sin(x)


def with_helper(t, y):
    return [y[1], gravity(y[0])]


def with_table(t, y, k):
    return [y[1], -table[0] * k[1] * y[0] - table[2] * y[1]]


@pytest.fixture
def outside():
    """The globals of this module, put back at the end."""
    own = globals()
    before = {name: own[name] for name in ("g", "length", "table", "gravity", "math")}
    yield own
    own.update(before)


def test_outside_values_are_read_at_each_call(outside):
    inside = 1.5

    def fun(t, y, k, pair):
        return [y[1], -g * inside * y[0] - k * y[1] * pair[1] * pair[0] + abs(length)]

    args = 0.25, (2.0, 3)
    mine, plain = both_ways(fun, args=args)
    for change in (
        lambda: None, lambda: outside.update(g=1.62), lambda: outside.update(length=-2.5),
        lambda: outside.update(g=np.float64(3.0)), lambda: outside.update(g=9.0, length=2),
    ):  # fmt: skip
        change()
        for own in (args, (0.5, (1.0, 2)), (0.5, (1.0, 2.0)), (1, (1.0, 2)), (0.5, [1.0, 2])):
            assert_same(plain(START, own), mine(START, own))
    outside.update(g=9.81, length=1.0)
    assert is_plain(mine, START, args) and is_plain(mine, None, (0.5, (4.0, 7)))
    inside = 2.5
    result = mine(START, args)
    assert was_ready(result)
    assert_same(plain(START, args), result)


@pytest.mark.parametrize("n", [3, 4])
def test_functions_and_arrays_are_followed(outside, n):
    for fun, args in ((with_helper, ()), (with_table, (np.arange(1.0, n + 1.0),))):
        outside["table"] = np.array([0.5, 2.0, 1.5])
        mine, plain = both_ways(fun, args=args)
        assert is_plain(mine, START, args)
        outside["g"], outside["table"] = 3.0, np.array([1.0, 1e-3, 4.0])
        table[1] += 1.0
        assert is_plain(mine, START, args)
        assert_same(plain(START, args), mine(START, args))
        outside["gravity"] = lambda x: -2.0 * x
        outside["table"] = np.array([1.0, 0.25, 4.0, 5.0])
        assert_same(plain(START, args), mine(START, args))
        assert is_plain(mine, START, args)
        if args:
            for other in (args[0][::-1], args[0].astype("f4"), args[0].tolist()):
                assert_same(plain(START, (other,)), mine(START, (other,)))


def test_numbers_of_a_table_that_must_rise_are_followed():
    """What all numbers of an array must meet is asked again where one of them has changed."""
    knots = np.array([0.0, 0.5, 1.0, 2.0])

    def fun(t, y, u):
        return [np.interp(t, knots, u) - y[0]]

    u = np.array([1.0, 0.0, 3.0, 2.0])
    mine, long = both_ways(fun, y0=[1.0], args=(u,))
    assert is_plain(mine, [1.5], (u,))
    for i, value in ((1, 0.25), (1, 1.5), (1, 0.5), (0, -1.0), (0, 0.0), (2, np.nan), (2, 1.0)):
        knots[i] = value
        for _ in range(3):
            assert_same(long([1.5], (u,)), mine([1.5], (u,)))


def test_a_function_with_attributes_and_defaults():
    def fun(t, y, a=2.0):
        return [-a * y[0] + scale(y[0])]

    def scale(x, b=3.0):
        return b * x

    mine, plain = both_ways(fun, y0=[1.0])
    assert is_plain(mine, [1.5])
    for change in (
        lambda: setattr(fun, "__defaults__", (1.0,)),
        lambda: setattr(scale, "__defaults__", (5.0,)),
        lambda: setattr(scale, "note", "an attribute"),
        lambda: setattr(scale, "__code__", (lambda x, b=3.0: b + x).__code__),
        lambda: setattr(fun, "__code__", (lambda t, y, a=2.0: [scale(y[0])]).__code__),
    ):  # fmt: skip
        change()
        assert_same(plain([1.5]), mine([1.5]))


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_dicts_and_arrays_with_zeros():
    def fun(t, y, p):
        return p["matrix"] @ y - p["k"] * y + table[0]

    def given(k=1.0, corner=0.0, **more):
        return ({"matrix": np.array([[corner, 1.0], [-2.0, -0.1]]), "k": k, **more},)

    mine, plain = both_ways(fun, args=given())
    assert is_plain(mine, START, given(2.0))
    for args in (
        given(3.0), given(3), given(-0.0), given(1.0, -0.0), given(1.0, 1e-300), given(1.0, 2.0),
        given(1.0, math.nan), given(other=1), ({"k": 1.0, "matrix": np.eye(2)},), given(),
    ):  # fmt: skip
        assert_same(plain(START, args), mine(START, args))
        assert_same(plain(START, given(0.5)), warm(mine, START, given(0.5)))
    with pytest.raises(KeyError):
        mine(START, ({"k": 1.0},))


def test_a_number_for_which_the_code_is_made():
    """The length of a loop is in the code; a zero hides a formula from the comparison."""

    def fun(t, y, n, a):
        return [-sum(y[0] for _ in range(n)) + a * math.sqrt(y[0])]

    mine, plain = both_ways(fun, y0=[1.0], args=(2, 0.0))
    assert is_plain(mine, [1.5], (2, 0.0))
    for args in ((3, 0.0), (2, 1.0), (2, math.nan), (2, -0.0), (2, 0.0)):
        solver, _ = both_ways(fun, y0=[1.0], args=(2, 0.0))
        result = solver([1.5], args)
        assert not was_ready(result) or args[0] == 2
        assert_same(plain([1.5], args), result)
    for matrix, other in (([[0.0]], [[1.0]]), ([[1.0]], [[0.0]])):
        mine, plain = both_ways(lambda t, y, m: m @ y, y0=[1.0], args=(np.array(matrix),))
        assert_same(plain([1.5], (np.array(other),)), mine([1.5], (np.array(other),)))


def test_values_that_were_zero_in_each_comparison_are_compared_first():
    """Python compares the code anew before a parameter is not zero for the first time."""

    def scalar(t, y, a):
        return [-y[0] + a * 0.125]

    def of_array(t, y, a):
        return [-y[0] + a[1] * 0.375 + a[0]]

    for fun, zero, one in (
        (scalar, 0.0, 1.0), (of_array, np.array([1.0, 0.0]), np.array([1.0, 1.0])),
    ):  # fmt: skip
        mine = prepared(fun, y0=[1.0], args=(zero,))
        assert is_plain(mine, [1.5], (zero,))
        assert not was_ready(mine([1.5], (one,))) and not was_ready(mine([1.25], (one,)))
        assert was_ready(mine([1.5], (zero,))) or was_ready(mine([1.5], (zero,)))


def test_errors_of_numpy_are_heard():
    def fun(t, y):
        return -np.sqrt(y) / y

    mine, _ = both_ways(fun, y0=[1.0], span=(0.0, 0.5))
    assert is_plain(mine, [1.0])
    with np.errstate(invalid="raise"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with pytest.raises(FloatingPointError):
            mine([-1.0])


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_name_that_is_gone(outside):
    mine, _ = both_ways(pendulum)
    kept = outside["math"]
    del outside["math"]
    with pytest.raises(NameError):
        mine(START)
    outside["math"] = kept
    assert is_plain(mine, START)


@pytest.mark.parametrize("shown", [np.transpose, np.asfortranarray, lambda a: np.tile(a, 2)[:, :2]])
def test_whole_numbers_in_any_order_of_memory(shown):
    matrix = shown(np.array([[0, 1], [-2, -1]]))

    def fun(t, y):
        return matrix @ y

    assert is_plain(solve_ivp, fun, (0, 1), START)
    for values in ([[0, 1], [-2, -1]], [[0, 2], [-2, -1]]):
        matrix = shown(np.array(values))
        assert_same(plain(fun, (0, 1), START), warm(solve_ivp, fun, (0, 1), START))
    matrix[1, 1] = -3
    assert_same(plain(fun, (0, 1), START), solve_ivp(fun, (0, 1), START))


def test_an_interpolator_of_several_rows():
    t = np.linspace(0, 1, 6)
    found = interp1d(t, np.array([np.sin(t), np.cos(t)]))
    assert is_plain(solve_ivp, lambda t, y: -y + found(t), (0, 1), START)


def of_math(t, y):
    return [y[1], -math.cos(t) * y[0]]


def of_numpy(t, y):
    return np.array([y[1], -np.cos(t) * y[0]])


def imported(t, y):
    from numpy import cos

    return [y[1], -cos(t) * y[0]]


def of_builtins(t, y):
    return [y[1], -abs(y[0])]


def named(t, y):
    return [y[1], -(2.0 if named.__name__ == "named" else 3.0) * y[0]]


class Named:
    def __call__(self, t, y):
        return [y[1], -(2.0 if type(self).__name__ == "Named" else 3.0) * y[0]]


@pytest.mark.parametrize(
    ("fun", "place", "name", "other"),
    [
        (of_math, math, "cos", math.sin), (of_numpy, np, "cos", np.sin),
        (imported, np, "cos", np.sin), (of_builtins, builtins, "abs", lambda x: 2.0 * x),
        (named, named, "__name__", "other"), (Named(), Named, "__name__", "Other"),
    ],
)  # fmt: skip
def test_parts_of_libraries_and_names_are_read_at_each_call(fun, place, name, other):
    mine, long = both_ways(fun)
    assert is_plain(mine, START)
    before = getattr(place, name)
    setattr(place, name, other)
    try:
        found = [mine(START).y[:, -1], solve_ivp(fun, (0.0, 1.0), START, rtol=1e-6).y[:, -1]]
        expected = scipy.integrate.solve_ivp(fun, (0.0, 1.0), START, rtol=1e-6).y[:, -1]
    finally:
        setattr(place, name, before)
    for y in found:
        np.testing.assert_allclose(y, expected, rtol=1e-12)  # the same steps
    assert_same(long(START), mine(START))
