"""Parts of a function that the comparison at its start does not reach: NumPy is followed there."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp as reference

import fastdyn
from support.beside_scipy import agrees

pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.mark.parametrize(
    "term",
    [
        lambda y: y.max(initial=0.5) + 0 * y,
        lambda y: np.multiply.reduce(y, initial=0.1) + 0 * y,
        lambda y: np.max(y, where=y < 0.5, initial=-7.0) + 0 * y,
        lambda y: y.astype(np.float32) / 3,
        lambda y: (-y).astype(np.uint8) + 0.5,
        lambda y: np.full_like(y, 2.7, dtype=int) * 1.0,
        lambda y: np.digitize(y, [0.8, 0.5]) * 1.0,
        lambda y: ((y > 0) + (y < 1)) * 1.0,
    ],
)
def test_numpy_is_followed_where_the_check_cannot_see_it(term):
    def fun(t, y, amplitude):
        return -y + amplitude * term(y)

    agrees(fun, 0.0)
    agrees(fun, 1.0)


def _copied(y):
    dy = np.zeros(2)
    np.copyto(dy, [1.0, 2.0])
    return dy


def _diagonal(y):
    m = np.zeros((2, 2))
    np.fill_diagonal(m, 3.0)
    return m @ y


def _at(y):
    dy = np.zeros(2)
    np.add.at(dy, [0, 0], 1.0)
    np.put(dy, [1], 5.0)
    return dy


def _among(y):
    return y if int(y[0]) in {0, 1, 2} else -y


def _into(function, *given, shape=(2,)):
    """What a function of NumPy writes where it is told to."""

    def term(y):
        result = np.zeros(shape)
        function(*(g(y) if callable(g) else g for g in given), out=result)
        return result.reshape(-1)[:2]

    return term


def _square(y):
    return np.outer(np.tanh(y), [1.0, 2.0])


def _without_nan(y):
    d = y / np.array([0.0, 1.0])
    np.nan_to_num(d, copy=False, posinf=3.0)
    return d


def _real_part(y):
    dy = np.zeros(2)
    dy.real[...] = -2 * y
    return dy


def _at_an_index(y):
    dy = np.zeros(2)
    dy[np.argmin(y)] = 1.0
    dy[np.argmax(y) - 2] += 2.0
    return dy


def _dtype(y):
    return y if y.dtype == float else -y


def _type(y):
    return y if type(y[0]) is np.float64 else -y


@pytest.mark.parametrize(
    "term",
    [
        _copied,
        _diagonal,
        _at,
        _into(np.dot, _square, lambda y: y),
        _into(np.outer, np.tanh, lambda y: y, shape=(2, 2)),
        _into(np.max, _square, 1),
        _into(np.mean, _square, 0),
        _into(np.round, lambda y: y / 7e8, 1),
        _without_nan,
        _real_part,
        _at_an_index,
        lambda y: np.sort(-y) + np.median(y),
        lambda y: np.mean(y, where=y > 5.0) + 0 * y,
        lambda y: np.block([y[:1], 2.0]),
        lambda y: np.fromiter((-v for v in y), float),
        lambda y: np.vectorize(lambda v: v if v > 5 else 2.0 * v)(y),
        lambda y: np.vectorize(lambda v: 1 if v > 5 else 2.5)(y) * 1.0,
        _among,
        _dtype,
        _type,
    ],
)
def test_a_branch_that_the_check_does_not_reach(term):
    def fun(t, y):
        return term(y) if y[0] > 1e9 else -y

    agrees(fun)
    for given in (2e9, 1.0), (1e12, 3.0):
        mine = fastdyn.solve_ivp(fun, (0.0, 0.1), given)
        theirs = reference(fun, (0.0, 0.1), given)
        assert np.allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-9, atol=0)
