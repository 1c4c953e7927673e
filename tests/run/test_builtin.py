"""The builtin that makes plain solves: its results, what it leaves to Python, and its safety."""

import sys
import tracemalloc

import numpy as np
import pytest

from fastdyn import OdeResult, prepare
from fastdyn.run import outcome, ready
from fastdyn.specialise.builtin import builtin
from support.repeated import assert_first, assert_same, in_threads

SPAN, START = (0.0, 1.0), [0.5, 0.25]
N = 40  # calls, of which the builtin makes those after the 32nd


@pytest.fixture(autouse=True)
def results_of_the_builtin(monkeypatch):
    """The results that users get: `support.repeated` has a function of its own in their place."""
    monkeypatch.setattr(ready, "results", outcome.results)


def driven(t, y, k):
    return [y[1], -k * y[0]]


def passes(t, y, k):
    return y[0] - 0.4


def never(t, y, k):
    return y[0] - 10.0 * k


OTHER_FIELDS = {
    "dense": {"dense_output": True},
    "an event": {"events": passes},
    "events": {"events": [never, passes], "t_eval": [0.2, 0.7]},
    "no occurrence": {"events": never, "dense_output": True},
    "sensitivity": {"sensitivity": ("y0", "k")},
    "sensitivity to a number": {"sensitivity": "k", "t_eval": [0.2, 0.7]},
}


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
        found = run._quick(driven, y0, (k,), ())
        if k.__class__ is int:  # other code
            assert found is None
        elif method in ("Radau", "LSODA") or options == {"t_eval": []}:
            assert found == ready.FINISHED
        else:
            assert_same(first, found)


def test_a_short_array_of_floats_goes_to_the_builtin(monkeypatch):
    solver, _ = solver_of()
    first = prepare(driven, SPAN, [1.0, 2.0], args=(3.0,))()
    by_python = []
    take = ready.taken_from
    monkeypatch.setattr(ready, "taken_from", lambda *given: by_python.append(1) or take(*given))
    y0 = np.array([1.0, 2.0])
    for given in (y0, np.asfortranarray(np.c_[y0, y0])[:, 0], np.r_[y0, y0].astype(">f8")[::3]):
        assert_same(prepare(driven, SPAN, given, args=(3.0,))(), solver(given, (3.0,)))
    assert not by_python
    for given in (y0.astype(int), y0.astype(np.longdouble)):
        assert_same(first, solver(given, (3.0,)))
    assert len(by_python) == 2


@pytest.mark.parametrize("options", OTHER_FIELDS.values(), ids=OTHER_FIELDS)
def test_other_fields_are_those_of_a_first_solve(options):
    solver, run = solver_of(**options)
    events = solver._others
    found = []
    for y0, k in (([1.0, 2.0], 3.0), ([0.0, -1.0], 0.5), ([0.5, 0.1], 2.0)):
        first = prepare(driven, SPAN, y0, args=(k,), **options)()
        found.append((first, solver(y0, (k,)), run._quick(driven, y0, (k,), events)))
    for first, *again in found:  # after all solves: none has a part of another
        for each in again:
            assert each.__class__ is OdeResult
            assert_first(each, first)


def test_other_values_are_left_to_python():
    solver, run = solver_of()
    solve = run._quick
    assert isinstance(solve(driven, START, (2.0,), ()), OdeResult)
    others = [
        tuple(START), [0.5], [*START, 1.0], [0.5, 1], [0.5, True], [0.5, np.float64(1.0)],
        [10**400, 0.0], ["a", 0.5], np.array(START), "ab", None,
    ]  # fmt: skip
    before = sys.getrefcount(None)
    for y0 in others:
        for _ in range(200):
            assert solve(driven, y0, (2.0,), ()) is None
    for _ in range(200):
        assert solve(driven, START, ("2",), ()) is None
    assert abs(sys.getrefcount(None) - before) < 100
    run.run.compared.left[0] = 1
    assert solve(driven, START, (2.0,), ()) is None  # a comparison is due
    for y0 in ([0.5], ["a", 0.5], "ab"):
        with pytest.raises((ValueError, TypeError)):
            solver(y0)


@pytest.mark.parametrize("options", [{}, *OTHER_FIELDS.values()])
def test_no_reference_and_no_memory_is_lost(options):
    solver, _ = solver_of(**options)
    y0, k = [0.1234, 0.5678], 2.5
    args = (k,)
    watched = [y0, *y0, args, k, driven, list, float, OdeResult, np.ndarray, None, "t", "nfev"]

    def many(n):
        for _ in range(n):
            solver(y0, args)

    many(1000)
    before = [sys.getrefcount(each) for each in watched]
    tracemalloc.start()
    many(500)
    grown = []  # a comparison with the function, once in a while, keeps notes
    for _ in range(3):
        kept = tracemalloc.get_traced_memory()[0]
        many(1000)
        grown.append(tracemalloc.get_traced_memory()[0] - kept)
    tracemalloc.stop()
    after = [sys.getrefcount(each) for each in watched]
    assert all(abs(b - a) < 100 for a, b in zip(before, after, strict=True)), (before, after)
    assert min(grown) < 10_000


ERRORS = [RuntimeError, KeyboardInterrupt, MemoryError]


@pytest.mark.parametrize("error", ERRORS)
@pytest.mark.parametrize("is_alone", [True, False])
def test_an_exception_of_a_reader_passes_through(error, is_alone):
    _, run = solver_of()
    seen = []

    def read(*given):
        seen.append(given)
        if given[1][0] > 1:
            raise error("said")
        return ()

    block = run._readers[0][1] if is_alone else None
    solve = of_parts(run, read, block, None)
    events = (driven, never)
    before = sys.getrefcount(driven), sys.getrefcount(events)
    for _ in range(200):
        with pytest.raises(error, match="said"):
            solve(driven, START, (2.0,), events)
        assert solve(driven, START, (0.0,), events) == ready.FINISHED
    assert seen[0][0] is driven and seen[0][2] is (block if is_alone else events)
    seen.clear()
    after = sys.getrefcount(driven), sys.getrefcount(events)
    assert all(abs(b - a) < 20 for a, b in zip(before, after, strict=True))


def of_parts(run, read, block, plain, told=None):
    """A builtin for the kernel of a run."""
    kernel = run.run.plan.launch, run.run.launch_at
    return builtin(*kernel, read, block, run.run.compared.left, run.room, told, plain)


@pytest.mark.parametrize("error", ERRORS)
def test_an_exception_of_other_fields_passes_through(error):
    _, run = solver_of()
    made = []

    def more(found, copied):
        made.append(sys.getrefcount(copied))
        if copied is not run._result.plain.copies[len(found["t"])]:
            raise AssertionError
        found["sol"] = "said"
        if len(made) % 2:
            raise error("said")

    plain = run._result.plain._replace(more=more)
    run.run.compared.left[0] = 10_000
    solve = of_parts(run, *run._readers[0], plain)
    for _ in range(200):
        with pytest.raises(error, match="said"):
            solve(driven, START, (2.0,), ())
        assert solve(driven, START, (2.0,), ()).sol == "said"
    assert max(made) - min(made) < 3


def test_what_is_to_be_told_is_left_to_python():
    _, run = solver_of()
    count = np.zeros(1, np.int64)
    at = count.ctypes.data
    solve = of_parts(run, *run._readers[0], run._result.plain, at)
    assert isinstance(solve(driven, START, (2.0,), ()), OdeResult)
    count[0] = 1
    assert solve(driven, START, (2.0,), ()) == ready.FINISHED


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
