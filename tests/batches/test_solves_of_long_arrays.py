"""Solves of long states beside SciPy: methods, events, values that change, sparse Jacobians."""

import numpy as np
import pytest
import scipy.sparse
from scipy.integrate import solve_ivp as reference

import fastdyn
from fastdyn.compile.traced import make as by_tracing
from support import long_arrays

N = 600
RATE = {"k": 1.0}


def heat(t, y, d=30.0):
    return d * (np.roll(y, 1) - 2 * y + np.roll(y, -1))


def brusselator(t, y, a=1.0, b=3.0):
    u, v = np.split(y, 2)
    u2v = u * u * v
    ends = [1.0], [3.0]
    lap = [np.diff(np.concatenate((e, w, e)), 2) for w, e in zip((u, v), ends, strict=True)]
    return np.concatenate((a + u2v - (b + 1) * u + 50 * lap[0], b * u - u2v + 50 * lap[1]))


def oscillators(t, y):
    return RATE["k"] + 0.5 * (np.mean(np.sin(y)) * np.cos(y) - np.mean(np.cos(y)) * np.sin(y))


def start(n=N):
    return 1.0 + 0.5 * np.sin(np.linspace(0.0, 2 * np.pi, n))


@pytest.fixture(autouse=True)
def all_in_batches(monkeypatch):
    """Each trace must be one in batches."""
    whole = by_tracing._traced

    def only(attempt, near, lifted, batches, facts):
        assert batches, "a trace number by number"
        return whole(attempt, near, lifted, batches, facts)

    monkeypatch.setattr(by_tracing, "_traced", only)


@pytest.mark.parametrize("method", ["RK45", "DOP853", "RK23"])
@pytest.mark.parametrize("fun", [heat, brusselator, oscillators])
def test_explicit_methods_take_scipys_steps(fun, method):
    given = {"method": method, "rtol": 1e-6, "atol": 1e-8, "t_eval": [0.01, 0.05]}
    mine, theirs = (f(fun, (0.0, 0.05), start(), **given) for f in (fastdyn.solve_ivp, reference))
    assert mine.nfev == theirs.nfev
    np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("method", ["Radau", "BDF"])
@pytest.mark.parametrize("fun", [heat, brusselator])
def test_implicit_methods_find_the_pattern(fun, method):
    _, traced = long_arrays.in_batches(fun, N)
    pattern = scipy.sparse.csc_matrix((np.ones(len(traced.pattern[0])), traced.pattern), (N, N))
    given = {"method": method, "rtol": 1e-4, "atol": 1e-7, "t_eval": [1.0]}
    mine = fastdyn.solve_ivp(fun, (0.0, 1.0), start(), **given)
    theirs = reference(fun, (0.0, 1.0), start(), jac_sparsity=pattern, **given)
    assert (mine.nfev, mine.nlu) == (theirs.nfev, theirs.nlu)
    np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-7, atol=1e-9)


def test_values_that_change_between_solves():
    for k in (1.0, -2.0, 0.0, 3.0):
        RATE["k"] = k
        mine, theirs = (f(oscillators, (0.0, 1.0), start()) for f in (fastdyn.solve_ivp, reference))
        np.testing.assert_allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-9)
    RATE["k"] = 1.0


@pytest.mark.filterwarnings("ignore::fastdyn.StiffnessWarning")
def test_events_on_a_long_state():
    def warm(t, y):
        return np.max(y) - 1.3

    def first(t, y):
        return y[0] - 1.05

    given = {"events": [warm, first], "args": (), "rtol": 1e-6}
    fun = lambda t, y: heat(t, y, 2000.0) - 0.5 * (y - 1.2)  # noqa: E731
    mine, theirs = (f(fun, (0.0, 2.0), start(), **given) for f in (fastdyn.solve_ivp, reference))
    for ours, others in zip(mine.t_events, theirs.t_events, strict=True):
        np.testing.assert_allclose(ours, others, rtol=1e-9, atol=1e-12)


def test_a_function_that_fails_on_the_way():
    def fun(t, y):
        dy = -y
        if t > 0.5:
            raise ValueError("too late")
        return dy

    with pytest.raises(ValueError, match="too late"):
        fastdyn.solve_ivp(fun, (0.0, 1.0), start())


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_state_that_is_written_to_is_left_to_others(monkeypatch):
    monkeypatch.undo()

    def fun(t, y):
        y[0] = 0.0
        return -y

    mine, theirs = (f(fun, (0.0, 1.0), start()) for f in (fastdyn.solve_ivp, reference))
    np.testing.assert_allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-9)


WHOLE = {"k": 2.0}


def test_numbers_that_an_array_rounds_are_seen_when_they_change(monkeypatch):
    monkeypatch.undo()  # left to the tracer of single numbers, or to Python

    def fun(t, y):
        return np.full(len(y), WHOLE["k"], dtype=int) - y

    for WHOLE["k"] in (2.0, 2.5):
        mine, theirs = (f(fun, (0.0, 1.0), start()) for f in (fastdyn.solve_ivp, reference))
        np.testing.assert_allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-9)


def test_masks_are_joined_and_copied_as_masks():
    def fun(t, y):
        hot = y > 1.0
        again = hot.astype(bool)
        again[0] = False
        near = np.concatenate([[False], hot[1:-1], [False]])
        return np.where(near, -y, 1.0) + np.where(hot, 0.5, 0.0) - np.where(again, 0.2, 0.1)

    mine, theirs = (f(fun, (0.0, 0.5), start()) for f in (fastdyn.solve_ivp, reference))
    assert mine.nfev == theirs.nfev
    np.testing.assert_allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-9)


def test_a_million_components():
    def fun(t, y):
        dy = np.zeros_like(y)
        dy[1:-1] = y[2:] - 2 * y[1:-1] + y[:-2]
        return dy

    y0 = start(10**6)
    given = {"t_eval": [0.1], "max_step": 0.05}
    mine, theirs = (f(fun, (0.0, 0.1), y0, **given) for f in (fastdyn.solve_ivp, reference))
    assert mine.nfev == theirs.nfev
    np.testing.assert_allclose(mine.y, theirs.y, rtol=1e-10)
