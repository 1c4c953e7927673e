"""Handlers, types, whole numbers: functions that careless machine code gets wrong."""

import math
import random

import numpy as np
import pytest
import scipy.integrate

import fastdyn


def same_as_scipy(fun, args=(), span=(0, 4), start=(1.0, 2.0)):
    found = []
    for solve in scipy.integrate.solve_ivp, fastdyn.solve_ivp:
        try:
            r = solve(fun, span, start, args=args)
        except Exception as error:
            found.append((type(error), str(error)))
        else:
            found.append(r)
    theirs, ours = found
    if isinstance(theirs, tuple):
        assert ours == theirs
    else:
        assert np.allclose(ours.y[:, -1], theirs.y[:, -1], rtol=1e-9, atol=1e-12)
        assert ours.nfev == theirs.nfev


TABLE, LETTERS = (1.0, 0.5, 0.25), "abc"
RAISE = {  # what raises for some t or y, and what catches it
    "tuple": (lambda t, y: TABLE[int(t)], IndexError),
    "letters": (lambda t, y: float(ord(LETTERS[int(t)])) / 100, IndexError),
    "root": (lambda t, y: math.sqrt(2.0 - t), ValueError),
    "logarithm": (lambda t, y: math.log(1.5 - float(y[0])), ValueError),
    "arcsine": (lambda t, y: math.asin(float(t) / 2), ValueError),
    "gamma": (lambda t, y: min(math.gamma(2.0 - int(t)), 2.0), ValueError),
    "exponential": (lambda t, y: min(math.exp(300 * t), 3.0), OverflowError),
    "power": (lambda t, y: min(10.0 ** float(200 * t), 2.0), OverflowError),
    "division": (lambda t, y: 1.0 / float(int(t)), ZeroDivisionError),
    "remainder": (lambda t, y: 7.5 % float(int(t)), ZeroDivisionError),
    "whole": (lambda t, y: int(np.log(t - 1.0) * 0 + 1), (ValueError, OverflowError)),
    "matrix": (
        lambda t, y: np.linalg.solve([[1.0, float(t > 1)], [1.0, 1.0]], [1.0, 2.0])[0] + 1.0,
        np.linalg.LinAlgError,
    ),
}
HANDLERS = ("its own", "Exception", "bare", "finally", "suppressing", "nested")


def handled(raising, error, how):
    import contextlib

    def own(t, y):
        try:
            k = raising(t, y)
        except error:
            k = 0.3
        return k

    def every(t, y):
        try:
            k = raising(t, y)
        except Exception:
            k = 0.4
        return k

    def bare(t, y):
        try:
            k = raising(t, y)
        except:  # noqa: E722
            k = 0.5
        return k

    def last(t, y):
        k = 0.6
        try:
            k = raising(t, y)
        finally:
            return k  # noqa: B012

    def suppressing(t, y):
        k = 0.7
        with contextlib.suppress(error):
            k = raising(t, y)
        return k

    def nested(t, y):
        try:
            try:
                k = raising(t, y)
            except KeyError:
                k = 9.0
        except error:
            k = 0.8
        return k

    return dict(zip(HANDLERS, (own, every, bare, last, suppressing, nested), strict=True))[how]


def handlers_drawn():
    every = [(name, how) for name in RAISE for how in HANDLERS]
    return random.Random(1).sample(every, 24)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("name", "how"), handlers_drawn())
def test_handlers_of_the_user(name, how):
    value = handled(*RAISE[name], how)
    same_as_scipy(lambda t, y: [-value(t, y) * y[0], y[0] - y[1]])


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", ["root", "exponential", "division", "remainder", "gamma"])
def test_what_nobody_catches_is_raised(name):
    value, _ = RAISE[name]
    same_as_scipy(lambda t, y: [-value(t, y) * y[0], y[0] - y[1]])


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", [int, float, np.int64, np.int32, np.int8, np.float32, bool])
def test_numbers_of_every_type_in_turn(kind):
    def fun(t, y, k):
        whole = 1.0 if isinstance(k, int) else 2.0
        array = 0.5 if hasattr(k, "shape") else 0.25
        return [-whole * y[0], -array * y[1] * float(k * k % 7)]

    for value in (kind(3), kind(1), 3, np.int64(3), kind(100)):
        same_as_scipy(fun, (value,))


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("seed", [3, 12345678, 2**30, 2**40 + 1, 2**53 + 1])
def test_whole_numbers_are_exact(seed):
    def fun(t, y, seed):
        drawn = (seed * 1103515245 + 12345) % 2**31
        n = 2 ** int(40 + 6 * t) + 1
        return [-y[0] * drawn / 2**31, -y[1] * (n % 3 + (float(n) == n))]

    same_as_scipy(fun, (seed,))


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    "term",
    [
        lambda y: np.hypot(1e160 * y[0], 1e160 * y[1]) / 1e160,
        lambda y: np.hypot(1e-170 * y[0], 1e-170) * 1e170,
        lambda y: abs(complex(1e160 * y[0], 1e160)) / 1e160,
        lambda y: hasattr(y[0], "hex") + 1.0,
        lambda y: hasattr(y[0], "is_integer") + 1.0,
        lambda y: float(~(float(y[0]) > 0.5)) / 10,
        lambda y: float(y[0] is y[0]) + 1.0,
        lambda y: abs((0.5 - float(y[0])) ** 0.3),
        lambda y: float(str(y[0])[0] == "1") + 1.0,
        lambda y: -(y[0] > 0.5),
    ],
)
def test_small_things(term):
    same_as_scipy(lambda t, y: [-term(y) * y[0], -y[1]])


@pytest.mark.filterwarnings("ignore")
def test_errors_of_numpy_that_are_exceptions():
    def fun(t, y):
        return [np.exp(400.0 * y[0]) * 0.0 + 1.0]

    assert fastdyn.solve_ivp(fun, (0, 1), [0.0]).status == 0
    with np.errstate(over="raise"), pytest.raises(FloatingPointError, match="exp"):
        fastdyn.solve_ivp(fun, (0, 5), [0.0])


POWERS = (
    "(3 + int(abs(y[0]))) ** 20 % 7",
    "pow(3 + int(abs(y[0])), 20) % 7",
    "(3 + int(abs(y[0]))) ** int(20 + t) % 13",
    "(3 + int(abs(y[0]))) ** 23 % 13",
)
PATHS = """
def fun(t, y):
    for j in range(int(abs(y[0]) * 0 + 3)):
        if j * t > 1e9:
            break
    return [0.1 * ({}) + 0.2, -y[1]]
"""


@pytest.mark.parametrize("power", POWERS)
def test_whole_numbers_are_exact_on_each_path(power):
    """The check of one path is none of another; powers are left to Python, not to Numba."""
    scope: dict = {}
    exec(PATHS.format(power), scope)
    with pytest.warns(fastdyn.CompileWarning, match="cannot be compiled and runs in Python"):
        same_as_scipy(scope["fun"], (), (0, 2), (5.2, 2.0))


@pytest.mark.filterwarnings("ignore")
def test_times_after_the_first_are_numpys():
    def fun(t, y):  # from 0.5 on NumPy's infinity, where Python's floats would raise
        return [-0.1 * min((float(y[0]) * (t < 0.5)) ** -1, 3.0)]

    same_as_scipy(fun, start=[1.0])
    kinds = set()

    def action(t, y):
        kinds.add(type(t))
        return y

    fastdyn.solve_ivp(lambda t, y: -y, (0, 1), [1.0], every=0.3, on_event=action)
    assert kinds == {np.float64}
