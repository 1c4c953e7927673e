"""Repeated calls of `solve_ivp` keep the promises of a solve: comparisons, warnings, memory."""

import gc
import math
import random
import sys
import warnings

import numpy as np
import pytest

import fastdyn
from fastdyn import solve_ivp
from fastdyn.compile import background
from fastdyn.compile.compare import Different
from fastdyn.run import again, loop
from fastdyn.run.functions import compared
from fastdyn.solve.repeated import Repeated
from support.repeated import (
    CALLS,
    START,
    assert_same,
    closure,
    in_threads,
    plain,
    warm,
    was_ready,
)


def pendulum(t, y):
    return [y[1], -9.81 * math.sin(y[0]) + 0.01 * t]


pytestmark = pytest.mark.usefixtures("nothing_known")


def test_stiffness_is_noticed():
    def stiff(t, y):
        return [-5000.0 * (y[0] - math.cos(t))]

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for end in (0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08):
            solve_ivp(stiff, (0, end), [1.5])
    with pytest.warns(fastdyn.StiffnessWarning):
        mine = solve_ivp(stiff, (0, 10), [1.5])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert_same(plain(stiff, (0, 10), [1.5]), mine)


def test_comparisons_are_due_as_before(monkeypatch):
    seen = []
    monkeypatch.setattr(compared, "compare", lambda run, count, *_: seen.append(count) or {})

    def fun(t, y):
        return [-y[0] if y[0] < 5.5 else 1.0 - y[0]]

    due = []
    for i in range(1, 40):
        seen.clear()
        result = solve_ivp(fun, (0, 1), [1.0])
        due += [i] if seen else []
    assert due == [1, 2, 4, 8, 16, 32] and was_ready(result)
    seen.clear()
    solve_ivp(fun, (0, 1), [7.0])
    solve_ivp(fun, (0, 1), [8.0])
    assert seen == [compared.AT_FIRST]


def test_a_difference_is_found(monkeypatch):
    def fun(t, y):
        return [-y[0] if y[0] < 5.5 else -1.5 * y[0]]

    warm(solve_ivp, fun, (0, 1), [1.0])
    different = compared.compare_along

    def wrong(bound, times, states, time):
        if max(map(np.max, states)) > 5.5:
            raise Different(bound, times[0], states[0], np.ones(1), np.zeros(1))
        return different(bound, times, states, time)

    monkeypatch.setattr(compared, "compare_along", wrong)
    with pytest.warns(fastdyn.CompileWarning):
        mine = solve_ivp(fun, (0, 1), [7.0])
    assert mine.y[0, 0] == 7.0
    assert not was_ready(solve_ivp(fun, (0, 1), [1.0]))  # it has been left to Python


def test_errors_of_numpy_are_heard():
    def root(t, y):
        return -np.sqrt(y) / y

    warm(solve_ivp, root, (0.0, 0.5), [1.0])
    with np.errstate(invalid="raise"), pytest.raises(FloatingPointError):
        solve_ivp(root, (0.0, 0.5), [-1.0])


def test_nothing_of_a_closure_is_held():
    class Thing(float):
        pass

    def make(a):
        held = Thing(3.0)

        def fun(t, y, q):
            return [-a * q * y[0]]

        fun_of.append(sys.getrefcount(held))
        return fun

    fun_of: list = []
    args = (1.5,)
    warm(solve_ivp, make(2.0), (0, 1), [1.0], args=args)
    gc.collect()
    before = sys.getrefcount(args)
    for end in (1.0, 500.0):  # plain, and going on after the first chunk
        fun = make(2.0)
        count = sys.getrefcount(fun)
        solve_ivp(fun, (0, end), [1.0], args=args)
        gc.collect()
        assert sys.getrefcount(fun) == count and sys.getrefcount(args) == before


def test_threads():
    expected = {q: plain(closure(q), (0, 5), START).y.tobytes() for q in (1.0, 2.0, 3.0, 4.0)}
    wrong = []

    def work(q):
        for _ in range(200):
            if solve_ivp(closure(q), (0, 5), START).y.tobytes() != expected[q]:
                wrong.append(q)

    in_threads(work, expected)
    assert not wrong


def test_auto_and_its_watch():
    """A long solve in the trial of `auto` is watched, although it begins on a run that is ready."""
    for _ in range(CALLS):
        mine = solve_ivp(pendulum, (0, 1), START, "auto")
    assert_same(plain(pendulum, (0, 1), START, "auto"), mine)


@pytest.mark.parametrize("first", [None, 3])
def test_a_faster_kernel_takes_over(first, monkeypatch):
    """Also where each solve goes on after the first chunk of steps."""
    from fastdyn.specialise import shared_or_inlined

    if first is not None:
        monkeypatch.setattr(loop.Run, "n_first", lambda run, problem=None: first)
        monkeypatch.setattr(loop, "next_chunk", lambda n_steps, spent: 10**6)
    terms = " + ".join(f"1e-3 * y[0]**{random.randint(1, 3)}" for _ in range(40))
    names = {}
    exec(f"def fun(t, y): return [y[1], -0.77 * y[0] + {terms}]", names)
    fun = names["fun"]
    for price in ("FOR_LLVM", "FOR_A_NUMBER", "FOR_NUMBA"):
        monkeypatch.setattr(shared_or_inlined, price, 0.0)
    expected = solve_ivp(fun, (0, 1), START, compile="shared")
    warm(solve_ivp, fun, (0, 1), START)
    kinds = [entry.value for entry in again.calls.entries.values()]
    (solver,) = [kind for kind in kinds if isinstance(kind, Repeated) and kind.idle]
    for _ in range(3):
        for _ in range(200):
            assert_same(expected, solve_ivp(fun, (0, 1), START))
        background.finish()
    (ready,) = solver.idle
    run = ready.run
    advance = run.words()[0][run.plan.at["kernels.advance"]]
    assert not run.tier.open and advance == run.tier.address
