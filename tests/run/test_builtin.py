"""The builtin that makes plain solves: its results, what it leaves to Python, and its safety."""

import sys
import tracemalloc

import numpy as np
import pytest

from fastdyn import OdeResult, prepare
from fastdyn.run import outcome, ready
from fastdyn.specialise.builtin import builtin
from support.repeated import assert_same, in_threads

SPAN, START = (0.0, 1.0), [0.5, 0.25]
N = 40  # calls, of which the builtin makes those after the 32nd


@pytest.fixture(autouse=True)
def results_of_the_builtin(monkeypatch):
    """The results that users get: `support.repeated` has a function of its own in their place."""
    monkeypatch.setattr(ready, "results", outcome.results)


def driven(t, y, k):
    return [y[1], -k * y[0]]


def solver_of(*given, span=SPAN, **options):
    """A prepared solver after N calls, and its run."""
    solver = prepare(driven, span, START, *given, args=(2.0,), compile="shared", **options)
    for _ in range(N):
        solver()
    (run,) = solver._solver.idle
    return solver, run


@pytest.mark.parametrize("method", ["RK45", "DOP853", "Radau", "LSODA"])
@pytest.mark.parametrize("options", [{}, {"t_eval": [0.2, 0.7]}, {"t_eval": []}])
def test_a_result_is_that_of_a_first_solve(method, options):
    solver, run = solver_of(method, **options)
    for y0, k in (([1.0, 2.0], 3.0), ([0.0, -1.0], 0.5), ([1.0, 2.0], 2)):
        first = prepare(driven, SPAN, y0, method, args=(k,), **options)()
        assert_same(first, solver(y0, (k,)))
        found = run._quick(driven, y0, (k,))
        if k.__class__ is int:  # other code
            assert found is None
        elif method in ("Radau", "LSODA") or options == {"t_eval": []}:
            assert found == ready.FINISHED
        else:
            assert_same(first, found)


def test_other_values_are_left_to_python():
    solver, run = solver_of()
    solve = run._quick
    assert isinstance(solve(driven, START, (2.0,)), OdeResult)
    others = [
        tuple(START), [0.5], [*START, 1.0], [0.5, 1], [0.5, True], [0.5, np.float64(1.0)],
        [10**400, 0.0], ["a", 0.5], np.array(START), "ab", None,
    ]  # fmt: skip
    before = sys.getrefcount(None)
    for y0 in others:
        for _ in range(200):
            assert solve(driven, y0, (2.0,)) is None
    for _ in range(200):
        assert solve(driven, START, ("2",)) is None
    assert abs(sys.getrefcount(None) - before) < 100
    run._left[0] = 1
    assert solve(driven, START, (2.0,)) is None  # a comparison is due
    for y0 in ([0.5], ["a", 0.5], "ab"):
        with pytest.raises((ValueError, TypeError)):
            solver(y0)


def test_no_reference_and_no_memory_is_lost():
    solver, _ = solver_of()
    y0, k = [0.1234, 0.5678], 2.5
    args = (k,)
    watched = [y0, *y0, args, k, driven, list, float, OdeResult, np.ndarray, None, "t", "nfev"]

    def many(n):
        for _ in range(n):
            solver(y0, args)

    many(2000)
    before = [sys.getrefcount(each) for each in watched]
    tracemalloc.start()
    many(500)
    kept = tracemalloc.get_traced_memory()[0]
    many(2000)
    grown = tracemalloc.get_traced_memory()[0] - kept
    tracemalloc.stop()
    after = [sys.getrefcount(each) for each in watched]
    assert all(abs(b - a) < 100 for a, b in zip(before, after, strict=True)), (before, after)
    assert grown < 20_000


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, MemoryError])
def test_an_exception_of_a_reader_passes_through(error):
    _, run = solver_of()
    seen = []

    def read(fun, args, block):
        seen.append((fun, args, block))
        if args[0] > 1:
            raise error("said")
        return ()

    block = run._readers[0][1]
    solve = builtin(run.run.plan.launch, run.run.launch_at, read, block, run._left, run.room, None)
    before = sys.getrefcount(driven)
    for _ in range(200):
        with pytest.raises(error, match="said"):
            solve(driven, START, (2.0,))
        assert solve(driven, START, (0.0,)) == ready.FINISHED
    assert seen[0][0] is driven and seen[0][2] is block
    seen.clear()
    assert abs(sys.getrefcount(driven) - before) < 20


def test_threads_have_runs_of_their_own():
    solver, _ = solver_of(span=(0.0, 10.0), rtol=1e-8)
    expected = {k: solver(START, (k,)).y.tobytes() for k in (0.5, 1.0, 2.0, 4.0)}
    wrong = []

    def work(k):
        for _ in range(300):
            if solver([*START], (k,)).y.tobytes() != expected[k]:
                wrong.append(k)

    in_threads(work, expected)
    assert not wrong
