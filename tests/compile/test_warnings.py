"""A function that stays in Python says why, once, at a line in its own file."""

import functools
import itertools
import re
import warnings

import numpy as np
import pytest

import fastdyn
from support import refused
from support.unsaid import unsaid

with open(refused.__file__) as file:
    LINES = file.read().splitlines()
# addresses, Numba's words and files, and ours
UNSAID = r"0x[0-9a-f]{4}| object at |(?i:numba|assert)|site-packages|fastdyn/|kws=|`value`|Error\b"
PROBLEM = {"t_span": (0, 0.1), "y0": [1.0, 0.5]}


@pytest.fixture(autouse=True)
def _unsaid(monkeypatch):
    unsaid(monkeypatch)


def said(fun, **options):
    """What is said by two solves."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for _ in range(2):
            fastdyn.solve_ivp(fun, **PROBLEM, **options)
    return caught


@pytest.mark.parametrize("name", refused.FUNCTIONS)
def test_the_line_of_the_user(name):
    (only,) = said(refused.FUNCTIONS[name])
    assert only.category is fastdyn.CompileWarning
    assert only.filename == __file__
    head = r"[\w.]+ cannot be compiled and runs in Python, many times slower"
    found = re.fullmatch(rf"{head}: (.+) \((.+), line (\d+)\)", str(only.message))
    assert found is not None, only.message
    sentence, file, line = found.groups()
    assert file == refused.__file__
    assert not re.search(UNSAID, sentence), sentence
    begun = LINES[int(line) - 1]
    body = (
        itertools.takewhile(bool, LINES[int(line) - 1 :]) if begun.startswith("def ") else [begun]
    )
    assert any("# here" in each for each in body), begun


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("appends", "it changes a list"),
        ("counts_in_a_global", "it changes a global variable"),
        ("draws_by_numpy", "it draws random numbers"),
        ("prints_a_state", "it calls print"),
        ("calls_scipy_in_a_loop", "`root = scipy.optimize.brentq(lambda z: z - x, -9, 9)` has no"),
        ("joins_numbers_in_a_loop", "`return np.r_[-x, y[1:]]` has no compiled form"),
        ("of_integers", "`bin` has no compiled form"),
    ],
)
def test_the_construct(name, sentence):
    (only,) = said(refused.FUNCTIONS[name])
    assert f"slower: {sentence}" in str(only.message)


def test_a_write_on_a_path_that_symbols_do_not_take_first():
    seen = []

    def fun(t, y):
        if y[0] < 0:
            return -y
        seen.append(t)
        return -y

    (only,) = said(fun)
    line = fun.__code__.co_firstlineno + 3
    assert f"it changes a list ({__file__}, line {line})" in str(only.message)


def test_each_partial_and_each_object_warns():
    def first(t, y, k):
        refused.LOG.append(t)
        return -k * y

    def second(t, y, k):
        refused.LOG.append(t)
        return -2 * k * y

    class Third:
        def __call__(self, t, y):
            refused.LOG.append(t)
            return -y

    class Fourth(Third):
        def __call__(self, t, y):
            refused.LOG.append(y)
            return -y

    functions = [functools.partial(f, k=1.0) for f in (first, second)]
    functions += [Third(), Fourth(), np.vectorize(lambda t, y: second(t, y, 1.0), otypes=[float])]
    messages = [str(only.message) for f in functions for only in said(f)]
    assert len(messages) == len(functions)
    for name, message in zip(
        ("first", "second", "Third", "Fourth", "lambda"), messages, strict=True
    ):
        assert name in message.partition(" cannot")[0]


def test_a_complex_state_in_python_is_told_once():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for _ in range(2):
            fastdyn.solve_ivp(refused.rotates, (0, 0.1), [1j], "Vern9")
    (only,) = caught
    assert "rotates cannot" in str(only.message) and "runs in Python" in str(only.message)
    assert only.filename == __file__ and refused.__file__ in str(only.message)


def test_numbas_own_warnings_are_kept():
    weights = np.arange(8.0)[::2]

    def sums(values):
        total = 0.0
        for v in values:
            while v > 1e-3:
                v /= 2
            total += v
        return total

    def fun(t, y):
        x = abs(y[0])
        while x > 1e-3:
            x /= 2
        return -y * sums([x, 1.0]) * (weights @ weights) / 14

    assert not said(fun)
