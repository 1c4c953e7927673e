"""Functions that fill an array and return it: the bits of those that return a list."""

import numpy as np
import pytest
from numpy import zeros_like as cleared

from fastdyn import CompileWarning, solve_ensemble, solve_ivp

K = 2.0


def empty(t, y):
    d = np.empty(2)
    d[0], d[1] = y[1], -K * y[0]
    return d


def sized(t, y):
    d = np.empty(y.size, dtype=np.float64)
    d[:1] = y[1:]
    d[1:] = -K * y[:1]
    return d


def zeros(t, y):
    d = np.zeros(len(y))
    d[0] += y[1]
    d[1] -= K * y[0]
    return d


def like(t, y):
    d = cleared(y)
    for _ in range(3):
        d[0] += y[1] / 3
        d[1] -= K * y[0] / 3
    return d


def early(t, y):
    rates = np.empty_like(y)
    rates[0] = y[1]
    rates[1] = -K * y[0]
    if t > 1.0:
        return rates
    rates[1] = -K * y[0] * 1.0
    return rates


def renamed(t, y):
    d = np.zeros(2)
    e = d
    e[0], e[1] = y[1], -K * y[0]
    return e


def reversed_view(t, y):
    d = np.empty(2)
    d[1], d[0] = y[1], -K * y[0]
    return d[::-1]


def scaled(t, y):
    d = np.empty(2)
    d[0], d[1] = y[1] / 2, -K * y[0] / 2
    return 2 * d


def two_of_them(t, y):
    if t > 1.0:
        d = np.empty(2)
        d[0], d[1] = y[1], -K * y[0]
        return d
    e = np.zeros(2)
    e[0], e[1] = y[1], -K * y[0]
    return e


def in_a_loop(t, y):
    old = np.zeros(2)
    d = old
    for _ in range(2):
        d = np.empty(2)
        d[0], d[1] = old[0] + y[1] / 2, old[1] - K * y[0] / 2
        old = d
    return d


def added_to(t, y):
    d = np.zeros(2)
    d += np.array([y[1], -K * y[0]])
    return d


def whole_numbers(t, y):
    d = np.zeros(2, dtype=np.int64)
    return d + np.array([y[1], -K * y[0]])


def square(t, y):
    d = np.empty((2, 1))
    d[0, 0], d[1, 0] = y[1], -K * y[0]
    return d


FUNCTIONS = [
    empty, sized, zeros, like, early, renamed, reversed_view, scaled, two_of_them, in_a_loop,
    added_to, whole_numbers,
]  # fmt: skip


@pytest.mark.parametrize(
    ("fun", "tier"),
    [(f, "shared") for f in FUNCTIONS] + [(f, "inlined") for f in (zeros, reversed_view)],
    ids=lambda value: getattr(value, "__name__", value),
)
def test_the_bits_of_a_list(fun, tier):
    def as_list(t, y):
        return [y[1], -K * y[0]]

    given = {"dense_output": True, "compile": tier}
    expected = solve_ivp(as_list, (0, 3), [1.0, 0.5], **given)
    found = solve_ivp(fun, (0, 3), [1.0, 0.5], **given)
    if fun in (like, in_a_loop):
        np.testing.assert_allclose(found.y, expected.y, rtol=1e-12)
    else:
        assert np.array_equal(found.y, expected.y)
        assert np.array_equal(found.sol(1.7), expected.sol(1.7))


def test_a_column_is_refused_as_by_scipy():
    with pytest.raises(ValueError, match="column"):
        solve_ivp(square, (0, 3), [1.0, 0.5])


def test_a_wrong_length_is_named():
    def short(t, y):
        d = np.zeros(len(y) - (1 if t > 0.5 else 0))
        d[0] = 1.0
        return d

    with (
        pytest.warns(CompileWarning, match="it returns 1 numbers, not 2"),
        pytest.raises(ValueError, match="1 value for a state of 2"),
    ):
        solve_ivp(short, (0, 3), [1.0, 0.5], max_step=0.1)


def test_other_modes_and_ensembles():
    def acceleration(t, w):
        d = np.zeros(4)
        d[0], d[1] = w[2], w[3]
        d[2], d[3] = -w[0], -w[1]
        return d

    def as_list(t, w):
        return [w[2], w[3], -w[0], -w[1]]

    def column(t, y):
        d = np.zeros_like(y)
        d[0], d[1] = y[1], -y[0]
        return d

    start = [1.0, 0.0, 0.0, 1.0]
    for method in ("VelocityVerlet", "RK4"):
        found, expected = (
            solve_ivp(f, (0, 1), start, method, step=0.01) for f in (acceleration, as_list)
        )
        assert np.array_equal(found.y, expected.y), method
    found = solve_ivp(column, (0, 1), [1.0, 0.0], vectorized=True)
    assert np.array_equal(found.y, solve_ivp(column, (0, 1), [1.0, 0.0]).y)
    y0 = np.linspace(0, 1, 20).reshape(10, 2)
    many = [solve_ensemble(f, (0, 3), y0, reduce="mean") for f in (empty, sized)]
    assert np.array_equal(many[0].reduced["mean"], many[1].reduced["mean"])
    assert many[0].y_end[3, 0] == pytest.approx(solve_ivp(empty, (0, 3), y0[3]).y[0, -1], rel=1e-9)
