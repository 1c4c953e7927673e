"""Numbers and truth values of Python, and those of NumPy that look the same and differ."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp as reference

import fastdyn

pytestmark = [pytest.mark.filterwarnings("ignore"), pytest.mark.usefixtures("no_comparisons")]


def tried(value):
    try:
        return float(value())
    except Exception as error:
        return 0.01 * len(type(error).__name__)


def whole(y):
    return (y * 4).astype(int)[0]


VALUES = [
    lambda y: min(1 / whole(y - y), 3.0),
    lambda y: min(1 / np.argmax(y), 3.0),
    lambda y: min(1 / np.count_nonzero(y > 9.0), 3.0),
    lambda y: min(1 / int(y[0] - y[0]), 3.0),
    lambda y: min(1 / (float(y[0]) * (y[0] > 9.0)), 3.0),
    lambda y: min(1 / (float(y[0]) * (float(y[0]) > 9.0)), 3.0),
    lambda y: min(1 / (y.item(0) * 0.0), 3.0),
    lambda y: min(1 / (y[0].item() * 0.0), 3.0),
    lambda y: min(1 / (y.tolist()[0] * 0.0), 3.0),
    lambda y: 7 // whole(y - y),
    lambda y: whole(y) ** -1,
    lambda y: int(4 * y[0]) ** -1,
    lambda y: isinstance(whole(y), int),
    lambda y: isinstance(int(y[0]), np.integer),
    lambda y: isinstance(float(y[0]) > 0.5, bool),
    lambda y: isinstance(y[0] > 0.5, bool),
    lambda y: isinstance(math.isnan(y[0]), bool),
    lambda y: isinstance(any(y > 0.5), bool),
    lambda y: (y[0] > 0.5) - (y[1] > 0.1),
    lambda y: (y[0] > 0.5) + True,
    lambda y: np.add(float(y[0]) > 0.5, float(y[1]) > 0.1),
    lambda y: np.sum((y > 0.2) * (y > 0.3)),
    lambda y: 2.0 * ((y[0] > 0.5) * (y[1] > 0.1) + (y[0] > 0.4)),
    lambda y: np.dot(y > 0.2, y > 0.3),
    lambda y: np.maximum(y > 0.2, y > 0.3)[0] + np.maximum(y > 0.2, y > 0.3)[1],
    lambda y: ~bool(y[0] > 0.5),
    lambda y: float(np.exp(2000.0 * y[0])).is_integer(),
    lambda y: math.copysign(1.0, -int(0.1 * y[0])),
    lambda y: math.atan2(-int(0.1 * y[0]), -1.0),
    lambda y: math.atan2(round(-0.1 * y[0]), -1.0),
    lambda y: pow(7, int(4 * y[0]), 5),
    lambda y: np.frombuffer(y.tobytes())[0],
    lambda y: np.add(y, 0.5, dtype=int)[0],
]
OFFSET = np.array([[0.0], [1.0]])
OF_ARRAYS = [  # of short and of long arrays
    lambda y: np.sum(3 * y, dtype=int),
    lambda y: (3 * y).sum(dtype=int),
    lambda y: np.mean(3 * y, dtype=int),
    lambda y: np.cumsum(3 * y, dtype=int)[-1],
    lambda y: np.any(y > 0.7, where=np.arange(len(y)) % 2 == 1),
    lambda y: np.all(y > 0.7, where=np.arange(len(y)) % 2 == 0),
    lambda y: np.all(y > 0.2, keepdims=True).ndim,
    lambda y: (y > 0.2) @ (y > 0.3),
    lambda y: np.dot(y > 0.2, y > 0.3),
    lambda y: np.diff(y > 0.7)[0],
    lambda y: np.linalg.norm(y.reshape(2, -1) + OFFSET, 1, axis=(0, 1)),
    lambda y: np.linalg.norm(y.reshape(2, -1) + OFFSET, np.inf, axis=(0, 1)),
    lambda y: np.linalg.norm(np.vstack([y, y + 1.0]), 2, axis=(0, 1)),
    lambda y: np.linalg.norm(np.vstack([y, y + 1.0]), "fro"),
    lambda y: np.linalg.norm(y * (1.0 + 2.0j)),
    lambda y: np.gradient(np.vstack([y, y * y]))[0][0, 0],
    lambda y: np.angle(y * (1.0 + 2.0j), deg=True)[0] / 90.0,
    lambda y: np.interp(0.3 * y[0], [0.0, 0.2, 1.0], [1.0, 2.0, 0.0]),
]


@pytest.mark.parametrize("value", VALUES)
def test_it_is_what_python_says(value):
    def fun(t, y):
        return [-tried(lambda: value(y)), -y[1]]

    mine = fastdyn.solve_ivp(fun, (0.0, 0.1), [1.0, 0.5])
    theirs = reference(fun, (0.0, 0.1), [1.0, 0.5])
    assert np.allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-9, atol=0)


@pytest.mark.parametrize("n", [2, 80])
@pytest.mark.parametrize("value", OF_ARRAYS)
def test_options_of_reductions_and_norms_count(value, n):
    def fun(t, y):
        return -y * tried(lambda: value(y))

    start = np.resize([1.0, 0.5], n)
    mine, theirs = (f(fun, (0.0, 0.1), start) for f in (fastdyn.solve_ivp, reference))
    assert np.allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-9, atol=0)
