"""Calls again of functions that run in Python: whatever changes between two calls is seen."""

import copy
import functools
import gc
import math
import random
import signal
import types
import weakref

import numpy as np
import pytest
import scipy.integrate

from fastdyn import prepare, solve_ivp
from fastdyn.delays import prepare_dde
from fastdyn.integrate import odeint
from fastdyn.run import again
from fastdyn.run.again import MOST_IN_PYTHON
from fastdyn.run.functions import readers
from fastdyn.run.functions.interruptible import Interruptible
from fastdyn.run.ready import ReadyRun
from support.repeated import CALLS, START, assert_same, in_threads, is_plain, plain, warm, was_ready

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*runs in Python"),
    pytest.mark.filterwarnings("ignore:.*writes to the state"),
]
SPAN = (0.0, 0.5)
FACTOR = 2.0


class Plant:
    """A callable object with an effect, and an event of it."""

    def __init__(self):
        self.k = 2.0
        self.damping = [0.1]
        self.calls = []
        self.fails_at = -1
        self.writes = False
        self.form = list

    def __call__(self, t, y, *forces):
        self.calls.append((t, *y))
        if len(self.calls) == self.fails_at:
            raise ZeroDivisionError("as asked")
        value = self.form([y[1], -self.k * y[0] - self.damping[0] * y[1] + sum(forces)])
        if self.writes:
            y[0] = 0.0
        return value

    def passage(self, t, y, *forces):
        self.calls.append("event")
        return y[0] - 0.45

    def method(self, t, y, *forces):
        return self(t, y, *forces)

    def function(self):
        def fun(t, y, *forces):
            return self(t, y, *forces)

        return fun


FORMS = {
    "object": lambda plant: plant,
    "method": lambda plant: plant.method,
    "closure": lambda plant: plant.function(),
    "partial": lambda plant: functools.partial(Plant.method, plant),
}
CHANGES = [
    lambda draw, p: setattr(p, "k", draw.choice([1.0, 3, np.float64(2.5)])),
    lambda draw, p: p.damping.__setitem__(0, draw.choice([0.0, 0.2, 1])),
    lambda draw, p: setattr(p, "damping", np.array([draw.random()])),
    lambda draw, p: setattr(p, "form", draw.choice([list, tuple, np.array])),
    lambda draw, p: setattr(p, "fails_at", len(p.calls) + draw.randint(1, 12)),
    lambda draw, p: setattr(p, "writes", not p.writes),
]


def outcome(solve, fun, given):
    """The result of a call, or what the call raised."""
    try:
        return solve(fun, **given)
    except (ZeroDivisionError, ValueError) as error:
        return type(error), str(error), getattr(error, "__notes__", None)


@pytest.mark.few
@pytest.mark.parametrize("method", ["RK45", "LSODA", "Radau"])
@pytest.mark.parametrize("form", FORMS)
def test_calls_in_any_order_beside_the_long_way_and_scipy(form, method):
    draw, plant, n_ready = random.Random(form + method), Plant(), 0
    changes = CHANGES if method == "RK45" else CHANGES[:-1]  # SciPy solves the others from then on
    for _ in range(80):
        if draw.random() < 0.2:
            draw.choice(changes)(draw, plant)
        given = {
            "t_span": draw.choice([SPAN, (0, 0.25), (1.0, 0.5)]), "method": method,
            "y0": draw.choice([[0.5, 0.25], (0.5, 1), np.array([1.0, -1.0])]),
            "args": draw.choice([None, (0.5,), (1,)]),
        }  # fmt: skip
        if draw.random() < 0.3:
            given["events"] = plant.passage
        others = [copy.deepcopy(plant) for _ in range(2)]
        if "events" in given:
            given_to = [{**given, "events": other.passage} for other in others]
        else:
            given_to = [given, given]
        mine = outcome(solve_ivp, FORMS[form](plant), given)
        n_ready += was_ready(mine)
        expected = outcome(plain, FORMS[form](others[0]), given_to[0])
        if isinstance(mine, tuple):
            assert mine == expected
        else:
            assert_same(expected, mine)
            theirs = outcome(scipy.integrate.solve_ivp, FORMS[form](others[1]), given_to[1])
            first = int(plant.writes)  # SciPy's first column is the state that was written to
            assert theirs.nfev == mine.nfev
            assert np.allclose(theirs.y[:, first:], mine.y[:, first:], rtol=1e-6, atol=1e-9)
        if not plant.writes:
            assert plant.calls == others[0].calls
        plant.calls.clear()
        plant.fails_at = -1
    assert n_ready > 10


def counted(calls):
    def fun(t, y):
        calls.append(t)
        return [y[1], -y[0]]

    return fun


def test_a_solve_again_calls_the_function_as_the_first_did():
    calls = []
    fun = counted(calls)
    first = solve_ivp(fun, SPAN, START)
    of_first = calls[:]
    assert is_plain(solve_ivp, fun, SPAN, START)
    calls.clear()
    again = solve_ivp(fun, SPAN, START)
    assert was_ready(again) and calls[-first.nfev :] == of_first[-first.nfev :]
    assert_same(first, again)
    assert all(type(a) is type(b) for a, b in zip(calls, of_first[-first.nfev :], strict=True))


class Unlike:
    """A factor that the tracer refuses, and Numba too."""

    def __rmul__(self, other):
        return 2.0 * float(str(float(other)))


def test_a_function_that_can_be_compiled_later_is(monkeypatch):
    def fun(t, y):
        return [y[1], -(y[0] * FACTOR)]

    before = ready_runs()
    expected = solve_ivp(fun, SPAN, START)
    monkeypatch.setitem(globals(), "FACTOR", Unlike())
    assert is_plain(solve_ivp, fun, SPAN, START)
    (run,) = [each for each in ready_runs() if each not in before]
    assert run.in_python
    monkeypatch.setitem(globals(), "FACTOR", 2.0)
    for _ in range(MOST_IN_PYTHON + CALLS):
        found = solve_ivp(fun, SPAN, START)
        assert np.allclose(found.y, expected.y, rtol=1e-14)
    (run,) = [each for each in ready_runs() if each not in before]
    assert not run.in_python


def test_a_run_whose_trace_is_not_known_is_made_ever_less_often(monkeypatch):
    tried = []

    class Forgotten(readers.Attempt):
        def known(self, batches=False):
            tried.append(self)

    monkeypatch.setattr(readers, "Attempt", Forgotten)
    for _ in range(100):
        solve_ivp(lambda t, y: [y[1], -0.3 * y[0]], SPAN, START)
    assert 1 <= len(tried) <= math.log2(100)
    assert odeint(lambda y, t: -0.3 * y, [1.0], np.linspace(0.0, 3.0, 50)).shape == (50, 1)
    late = prepare_dde(lambda t, y, past: -past(t - 1.0), (0, 3), [1.0])
    assert [late().nfev for _ in range(10)] == 10 * [late().nfev]


def ready_runs():
    waiting = [each for entry in again.calls.entries.values() for each in entry.value.idle]
    return [each for each in waiting if isinstance(each, ReadyRun)]


def test_another_function_of_the_code_may_be_compiled():
    def made(log):
        def fun(t, y):
            if log is not None:
                log.append(t)
            return [y[1], -y[0]]

        return fun

    log = []
    before = ready_runs()
    first = solve_ivp(made(log), SPAN, START)
    assert is_plain(solve_ivp, made(log), SPAN, START)
    (run,) = [each for each in ready_runs() if each not in before]
    left = run.left
    for _ in range(3):
        assert_same(plain(made(None), SPAN, START), solve_ivp(made(None), SPAN, START))
    n = len(log)
    assert run.in_python and run.left == left
    assert_same(first, solve_ivp(made(log), SPAN, START))
    assert len(log) > n and run.left == left - 1


def test_a_prepared_solver_and_odeint():
    calls = []
    mine = prepare(counted(calls), SPAN, START)
    assert is_plain(mine, [0.1, 0.2])
    assert_same(plain(counted([]), SPAN, [0.3, 0.4], compile="inlined"), mine([0.3, 0.4]))
    t = np.array([0.0, 0.2, 0.4])

    def reversed_order(y, t, k):
        calls.append(t)
        return [y[1], -k * y[0]]

    for k in (1.0, 2.0, 3, 1.0, 5.0) * 4:
        found = odeint(reversed_order, [1.0, 0.5], t, (k,))
        n = len(calls)
        expected = scipy.integrate.odeint(reversed_order, [1.0, 0.5], t, (k,))
        assert np.allclose(found, expected, rtol=1e-6)
        assert len(calls) > n


def test_nothing_of_the_user_is_kept_between_solves():
    plant = Plant()
    warm(solve_ivp, plant, SPAN, START, args=(np.float64(1.0),))
    kept = weakref.ref(plant)
    del plant
    gc.collect()  # runs of the long way are cycles
    assert kept() is None


def test_an_exception_ends_one_solve_only():
    plant = Plant()
    warm(solve_ivp, plant, SPAN, START)
    plant.calls.clear()
    plant.fails_at = 5
    for _ in range(3):
        with pytest.raises(ZeroDivisionError, match="as asked"):
            solve_ivp(plant, SPAN, START)
        assert len(plant.calls) == 5
        plant.calls.clear()
    plant.fails_at = -1
    assert_same(plain(Plant(), SPAN, START), solve_ivp(plant, SPAN, START))


def test_threads_do_not_share_a_run():
    def work(k):
        def fun(t, y):
            seen[k].append(t)
            return [y[1], -k * y[0]]

        for _ in range(60):
            got = solve_ivp(fun, SPAN, START)
            if got.y.tobytes() != expected[k]:
                wrong.append(k)

    values = (0.5, 1.0, 2.0, 4.0)
    seen = {k: [] for k in values}
    wrong = []
    expected = {}
    n_calls = {}
    for k in values:

        def fun(t, y, k=k):
            seen[k].append(t)
            return [y[1], -k * y[0]]

        found = plain(fun, SPAN, START)
        expected[k] = found.y.tobytes()
        n_calls[k] = found.nfev
        seen[k].clear()
    in_threads(work, values)
    assert not wrong
    assert all(len(seen[k]) >= 60 * n_calls[k] for k in values)


def test_a_solve_inside_a_solve_of_the_same_code():
    depth = []

    def fun(t, y):
        if len(depth) < 1:
            depth.append(t)
            inner = solve_ivp(fun, SPAN, y)
            depth.pop()
            return [inner.y[1, -1], -y[0]]
        return [y[1], -y[0]]

    first = plain(fun, SPAN, START)
    for _ in range(12):
        assert_same(first, solve_ivp(fun, SPAN, START))


@pytest.mark.skipif(not hasattr(signal, "raise_signal"), reason="no signals")
def test_a_signal_is_handled_once():
    heard = []
    calls = []

    def fun(t, y):
        calls.append(t)
        if len(calls) % 5 == 0:
            signal.raise_signal(signal.SIGINT)
        return [y[1], -y[0]]

    before = signal.signal(signal.SIGINT, lambda number, frame: heard.append(number))
    try:
        warm(solve_ivp, fun, SPAN, START)
        assert len(heard) == len(calls) // 5
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(not hasattr(signal, "SIGALRM"), reason="no signals")
def test_a_timeout_between_two_calls_of_the_function_is_raised():
    class Late(Exception):
        pass

    heard = []

    def late(number, frame):
        heard.append(number)
        raise Late

    callback = types.SimpleNamespace(inside=False, pending=None)
    before = signal.signal(signal.SIGALRM, late)
    try:
        with pytest.raises(Late), Interruptible([callback]):
            signal.raise_signal(signal.SIGALRM)  # in the kernel, or where a callback begins
            with pytest.raises(Late):
                callback.pending()  # by the next call
            assert callback.pending is None
            callback.inside = True
            with pytest.raises(Late):  # in the user's function
                signal.raise_signal(signal.SIGALRM)
            callback.inside = False
            signal.raise_signal(signal.SIGALRM)  # behind the last call
        assert heard == 3 * [signal.SIGALRM]
        assert signal.getsignal(signal.SIGALRM) is late
    finally:
        signal.signal(signal.SIGALRM, before)
