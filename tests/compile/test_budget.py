"""No solve waits long for compiled code: it runs in Python, and a later one finds the code."""

import itertools
import math
import os
import random
import signal
import subprocess
import sys
import textwrap
import threading
import time
import warnings

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.compile import background, budget, memory
from fastdyn.compile.bind import bind
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced import make
from fastdyn.compile.traced.code import Traced
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near, traced_function
from fastdyn.run import solve_problem
from fastdyn.trace.graph.clock import CLOCK, checked_by, look
from fastdyn.trace.graph.refusal import NotYet, OutOfTime

TEXT = """
def {name}(t, y):
    total, k, x = 0.0, 0, y[0]
    while x < 50.0 and k < 300:
        x = x * 1.01 + abs(np.sin(y[1]))
        k += 1
        total += x
    return np.array([y[1], -y[0] + 1e-9 * total * {number}])
"""
START = [0.3, 0.5]


def for_numba():
    """A function that only Numba compiles, and that nobody has seen."""
    names = {"np": np}
    exec(TEXT.format(name="looped", number=random.random()), names)
    return names["looped"]


def for_tracing(n):
    names = {"sin": math.sin, "n": n, "factor": random.random()}
    exec("def rates(t, y): return [factor * sin(y[i - 1]) * y[i] for i in range(n)]", names)
    return names["rates"]


@pytest.fixture
def seen(monkeypatch):
    """Whether each solve ran compiled code."""
    found, result_of = [], solve_problem.result_of

    def noted(problem, status, run):
        found.append(run.bounds[0].function is not None)
        return result_of(problem, status, run)

    monkeypatch.setattr(solve_problem, "result_of", noted)
    return found


@pytest.fixture(autouse=True)
def nothing_is_left():
    yield
    background.finish()


@pytest.mark.parametrize("make", [for_numba, lambda: for_tracing(300)], ids=["Numba", "trace"])
@pytest.mark.parametrize("method", ["RK45", "BDF"])
def test_a_solve_goes_on_in_python_and_the_next_is_compiled(make, method, seen, monkeypatch):
    fun = make()
    y0 = START if fun.__name__ == "looped" else np.linspace(0.1, 1, 300)
    monkeypatch.setattr(budget, "SECONDS", 0.001)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        first = fastdyn.solve_ivp(fun, (0, 1), y0, method, rtol=1e-9, atol=1e-9)
        background.finish()
        second = fastdyn.solve_ivp(fun, (0, 1), y0, method, rtol=1e-9, atol=1e-9)
    assert seen == [False, True]
    assert np.allclose(first.y[:, -1], second.y[:, -1], rtol=1e-7, atol=1e-7)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "options",
    [{"compile": "inlined"}, {"compile": "shared"}, {"method": "auto", "rtol": 1e-3}],
    ids=str,
)
def test_who_asks_for_compiled_code_waits(options, seen, monkeypatch):
    monkeypatch.setattr(budget, "SECONDS", 0.001)
    fastdyn.solve_ivp(for_numba(), (0, 1), START, **options)
    fastdyn.prepare(for_numba(), (0, 1), START)
    assert seen == [True]


def test_solves_wait_no_longer_than_the_budget_in_all(monkeypatch):
    monkeypatch.setattr(budget, "SECONDS", 0.2)
    go_on = threading.Event()
    monkeypatch.setattr(background.Job, "run", lambda job: go_on.wait(60) and (job.end() or True))
    fun, begin = for_numba(), time.monotonic()
    for _ in range(20):
        fastdyn.solve_ivp(fun, (0, 1), START)
    assert time.monotonic() - begin < 3
    go_on.set()


def test_only_the_work_of_the_thread_counts():
    """Where other processes have most of the machine, no more functions run in Python."""

    def work():
        end = time.thread_time() + 0.35
        while time.thread_time() < end:
            pass

    def against(do):
        return budget._against(budget._now() + 0.3, lambda: (do(), look()))

    against(lambda: time.sleep(0.35))
    with pytest.raises(OutOfTime):
        against(work)


def test_a_wait_counts_the_work_of_the_background_thread(monkeypatch):
    go_on = threading.Event()
    job, begin = background.Job(lambda: go_on.wait(60)), budget._now()
    try:
        assert not budget._waited_for(job, 0.02)  # which does not work: a tenth of the wall counts
        assert 0.02 <= budget._now() - begin < 1.0
        monkeypatch.setattr(background, "seconds", itertools.count().__next__)
        assert not budget._waited_for(job, 2.5)
        assert budget._now() - begin >= 3.0
    finally:
        go_on.set()
    assert budget._waited_for(job, 60.0)


def test_a_function_that_waits_long_for_its_code_is_told_of_once(monkeypatch, caplog):
    monkeypatch.setattr(budget, "SECONDS", 0.001)
    monkeypatch.setattr(budget, "LASTS", 0.0)
    go_on, fun = threading.Event(), for_numba()
    monkeypatch.setattr(background.Job, "run", lambda job: go_on.wait(60) and (job.end() or True))
    for _ in range(2):
        fastdyn.solve_ivp(fun, (0, 1), START)
    go_on.set()
    (said,) = caplog.messages
    assert said.startswith(
        "looped has run in Python for 0 s, because its compiled code is not ready"
    )


@pytest.mark.parametrize("stage", ["seconds_of", "compare_around"])
def test_values_that_change_while_code_is_made_behind_are_no_fault_of_the_code(stage, monkeypatch):
    weights, within = np.array([1, 2]), getattr(make, stage)

    def fun(t, y):
        return -weights * y

    def changed(*given, **named):
        weights[:] += 1
        return within(*given, **named)

    monkeypatch.setattr(make, stage, changed)
    near = Near(0.0, 1.0, np.ones(2))
    background.Job(lambda: traced_function(Attempt(fun, (), DERIVATIVE, 2), near))
    background.finish()
    monkeypatch.undo()
    assert Attempt(fun, (), DERIVATIVE, 2).left == (None, False)
    assert traced_function(Attempt(fun, (), DERIVATIVE, 2), near) is not None


def test_ctrl_c_ends_the_waiting(monkeypatch):
    monkeypatch.setattr(budget, "SECONDS", 60.0)
    go_on = threading.Event()
    monkeypatch.setattr(background.Job, "run", lambda job: go_on.wait(60) and (job.end() or True))
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        fastdyn.solve_ivp(for_numba(), (0, 1), START)
    assert time.monotonic() - begin < 10
    go_on.set()


def test_threads_take_short_turns_while_code_is_made_behind():
    before, within = sys.getswitchinterval(), []
    background.Job(lambda: within.append(sys.getswitchinterval()))
    background.finish()
    assert within == pytest.approx([background.SWITCH])
    assert sys.getswitchinterval() == before > 10 * within[0]


def test_the_filters_of_warnings_stay_those_of_the_user(monkeypatch):
    monkeypatch.setattr(budget, "SECONDS", 0.001)
    before = warnings.filters[:], warnings._showwarnmsg_impl
    with warnings.catch_warnings(record=True):
        fastdyn.solve_ivp(for_numba(), (0, 1), START)
        time.sleep(0.3)  # Numba has entered its own, and not left it
    background.finish()
    assert (warnings.filters, warnings._showwarnmsg_impl) == before


SCRIPT = """
import os, sys, time
import numpy as np
import fastdyn
from fastdyn.compile import background
{function}
fastdyn.solve_ivp(looped, (0, 1), [0.3, 0.5])
assert background._state.thread is not None
"""
FORK = """
def solved():
    return fastdyn.solve_ivp(looped, (0, 1), [0.3, 0.5]).success

child = os.fork()
if not child:
    ok = solved()
    background.finish()
    os._exit(not (ok and solved()))
assert solved()
_, status = os.waitpid(child, 0)
sys.exit(os.waitstatus_to_exitcode(status))
"""


def script(more=""):
    function = TEXT.format(name="looped", number=random.random())
    text = SCRIPT.format(function=function) + textwrap.dedent(more)
    environment = {**os.environ, "FASTDYN_BUDGET": "0.001"}
    done = subprocess.run(
        [sys.executable, "-W", "ignore::DeprecationWarning", "-c", text],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
    )
    return done.returncode, done.stderr


@pytest.mark.hunt
def test_it_does_not_keep_the_interpreter_from_exiting():
    for pause in (0.0, 0.05, 0.3, 0.7):
        begin = f"time.sleep({pause}); begin = time.monotonic()\n"
        ends = "import atexit; atexit.register(lambda: os.write(1, b''))\n"
        assert script(begin + ends) == (0, "")


@pytest.mark.hunt
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_it_survives_a_fork():
    assert script(FORK) == (0, "")


@pytest.mark.parametrize("stage", ["look", "text"])
def test_work_that_is_out_of_time_is_no_refusal(stage, monkeypatch):
    def out_of_time(*_):
        raise OutOfTime

    def fun(t, y):
        return [sum(math.sin(k * v) for k in range(40)) for v in y]

    if stage == "look":
        monkeypatch.setattr(CLOCK, "check", out_of_time)
    else:
        monkeypatch.setattr(Traced, "text", out_of_time)
    with pytest.raises(NotYet):
        traced_function(Attempt(fun, (), DERIVATIVE, 30), Near(0.0, 1.0, np.ones(30)))


def test_code_that_is_there_is_used_while_other_code_is_made(monkeypatch):
    """A global is deleted for one solve: the code of the solves before holds again behind it."""

    class Endless:
        def __init__(self, make):
            pass

        def wait(self, seconds):
            return False

    monkeypatch.setattr(background, "Job", Endless)
    monkeypatch.setattr(budget, "SECONDS", 60.0)
    scope = {"g": random.random()}
    exec("def fun(t, y): return [y[1], -g * y[0]]", scope)

    def is_compiled():
        with budget.limited():
            near = Near(0.0, 1.0, np.array(START))
            return bind(scope["fun"], (), DERIVATIVE, 2, near).function is not None

    assert is_compiled()
    monkeypatch.setattr(budget, "SECONDS", 0.1)  # which the next call waits out
    before = scope.pop("g")
    assert not is_compiled()
    scope["g"] = before
    assert is_compiled()


HEARD: list = []


def writes(t, y):
    HEARD.append(t)
    return [-y[0]]


def decides_often(t, y):
    for v in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9):
        if y[0] > v and t > v:
            HEARD.append(v)
    return [-y[0]]


def of_many(t, y):
    return [-float(np.cos(np.arange(100.0) * 1e-3 * y[0]).sum()) * 0.01]


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("fun", [writes, decides_often, of_many])
@pytest.mark.parametrize("last", range(6))
def test_the_end_of_the_time_never_leaves_a_solve(fun, last, monkeypatch):
    """Wherever the time is over, the solve goes on in Python."""
    looked = itertools.count()

    def check():
        if next(looked) >= last:
            raise OutOfTime

    def against(end, make):
        with checked_by(check):
            return make()

    monkeypatch.setattr(budget, "SECONDS", 60.0)
    monkeypatch.setattr(budget, "_against", against)
    memory.forget()
    run = fastdyn.solve_ivp(fun, (0, 1), [1.0])
    expected = scipy.integrate.solve_ivp(fun, (0, 1), [1.0])
    assert np.allclose(run.y, expected.y, rtol=1e-12)
