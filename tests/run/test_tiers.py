"""The inlined kernel is made while the shared one works, and takes over with the same bits."""

import itertools
import os
import random
import subprocess
import sys
import threading

import numpy as np
import pytest

from fastdyn import code_store, prepare, solve_ivp
from fastdyn.compile import background, memory
from fastdyn.run import loop
from fastdyn.specialise import scalar, shared_or_inlined

START = [1.0, 0.0]


def motion():
    """A function whose code nobody has."""
    terms = " + ".join(f"1e-3 * y[0]**{random.randint(1, 3)}" for _ in range(40))
    names = {}
    exec(f"def fun(t, y): return [y[1], -y[0] + {terms}]", names)
    return names["fun"]


def numbers(fun, **options):
    if "step" not in options:
        options |= {"rtol": 1e-8, "atol": 1e-8}
    result = solve_ivp(fun, (0, 30), START, **options)
    return result.t, result.y


def same(a, b):
    return all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


@pytest.fixture(autouse=True)
def nothing_is_left():
    yield
    background.finish()


@pytest.fixture
def at_once(monkeypatch):
    """Inlined kernels are made after any time in the shared one."""
    monkeypatch.setattr(shared_or_inlined, "FOR_LLVM", 0.0)
    monkeypatch.setattr(shared_or_inlined, "FOR_A_NUMBER", 0.0)


@pytest.fixture(scope="module", autouse=True)
def what_all_functions_share():
    for name, tier in itertools.product(("RK45", "Vern9"), ("shared", "inlined")):
        numbers(motion(), method=name, compile=tier)  # processes of these tests compile neither


@pytest.fixture
def gate(monkeypatch):
    """The thread makes kernels only while the gate is open."""
    opened, original = threading.Event(), scalar.code_store.linked

    def linked(*given):
        assert background.is_here() and opened.wait(60)
        return original(*given)

    monkeypatch.setattr(scalar.code_store, "linked", linked)
    return opened


def test_a_solve_does_not_wait_and_a_later_one_is_inlined(at_once, gate):
    fun = motion()
    expected = numbers(fun, compile="shared")
    for _ in range(3):
        assert same(expected, numbers(fun))  # the gate is closed
    gate.set()
    background.finish()
    before = dict(code_store.COUNTS)
    with_kernel = prepare(fun, (0, 30), START, rtol=1e-8, atol=1e-8, compile="auto")()
    assert same(expected, (with_kernel.t, with_kernel.y))
    assert code_store.COUNTS == before


def test_a_long_solve_takes_the_kernel_on_the_way(at_once, monkeypatch):
    fun, taken = motion(), []
    expected = numbers(fun, compile="shared")
    monkeypatch.setattr(loop, "CHUNK_SECONDS", 0.0)  # one step a chunk
    step = loop.Run.step

    def noted(run, n_steps):
        if len(taken) == 20:
            background.finish()
        taken.append(run.tier.open)
        return step(run, n_steps)

    monkeypatch.setattr(loop.Run, "step", noted)
    assert same(expected, numbers(fun))
    assert taken[0] and not taken[-1]


def test_a_function_of_a_moment_gets_no_kernel(monkeypatch):
    monkeypatch.setattr(shared_or_inlined, "FOR_LLVM", 1e6)
    monkeypatch.setattr(background, "idle_job", None)
    fun = motion()
    assert same(numbers(fun, compile="shared"), numbers(fun))
    assert same(numbers(fun, compile="shared"), numbers(fun))


def test_the_time_that_others_take_of_the_processor_counts_for_nothing(monkeypatch):
    """Between any two looks at the clock of the wall, other processes work for a minute."""
    wall = itertools.count(step=60.0)
    for place in ("loop", "ready"):
        monkeypatch.setattr(f"fastdyn.run.{place}.perf_counter", wall.__next__, raising=False)
    monkeypatch.setattr(shared_or_inlined, "FOR_LLVM", 30.0)
    monkeypatch.setattr(background, "idle_job", None)
    solver = prepare(motion(), (0, 30), START, rtol=1e-8, atol=1e-8, compile="auto")
    assert all(same((r.t, r.y), (s.t, s.y)) for r, s in ((solver(), solver()) for _ in range(99)))


def test_numba_is_not_asked_for_a_moment(at_once, monkeypatch):
    """A kernel that waits for its function is made by Numba, in seconds."""
    asked = []

    def absent(name, n, build=False):
        asked.append(build)

    monkeypatch.setattr(shared_or_inlined, "kernel_without_function", absent)
    monkeypatch.setattr(scalar, "kernel_without_function", absent)
    fun = motion()
    expected = numbers(fun, compile="shared")
    for _ in range(3):
        assert same(expected, numbers(fun))
        background.finish()
    assert asked == [False]


def test_many_functions_wait_in_a_bounded_queue(at_once, gate):
    functions = [motion() for i in range(2 * background.MOST_IDLE)]
    expected = [numbers(fun, compile="shared") for fun in functions]
    for _ in range(2):
        for fun, answer in zip(functions, expected, strict=True):
            assert same(answer, numbers(fun))
    assert len(background._jobs) == background.MOST_IDLE
    waited_for = background.Job(lambda: None)
    assert [job for job in background._jobs if not job.idle] == [waited_for]
    assert background._jobs.index(waited_for) <= 1  # behind the one that runs
    gate.set()
    background.finish()
    for _ in range(2):  # those refused before are made now
        for fun, answer in zip(functions, expected, strict=True):
            assert same(answer, numbers(fun))
    background.finish()
    for fun, answer in zip(functions, expected, strict=True):
        assert same(answer, numbers(fun))


def test_a_kernel_that_cannot_be_made_is_not_tried_again(at_once, monkeypatch):
    tried = []

    def fails(*given):
        tried.append(given)
        raise RuntimeError

    monkeypatch.setattr(scalar.code_store, "linked", fails)
    fun = motion()
    expected = numbers(fun, compile="shared")
    for _ in range(4):
        assert same(expected, numbers(fun))
        background.finish()
    assert len(tried) <= 1


@pytest.mark.few(3)
@pytest.mark.parametrize("method", ["RK45", "DOP853", "Tsit5", "VelocityVerlet", "Gauss8"])
def test_llvm_alone_gives_numbas_bits(method, monkeypatch):
    options = {"step": 0.01} if method in ("VelocityVerlet", "Gauss8") else {}
    fun = motion()
    shared = numbers(fun, method=method, compile="shared", **options)
    assert same(shared, numbers(fun, method=method, compile="inlined", **options))
    memory.forget()
    monkeypatch.setattr(scalar, "links", lambda *_: False)
    monkeypatch.setattr(code_store, "stored", lambda *_: None)
    assert same(shared, numbers(fun, method=method, compile="inlined", **options))


BEGINNING = """
import os, random, sys, time
import numpy as np
from fastdyn import solve_ivp
from fastdyn.compile import background
from fastdyn.specialise import shared_or_inlined

shared_or_inlined.FOR_LLVM = shared_or_inlined.FOR_A_NUMBER = 0.0
terms = " + ".join(f"1e-3 * y[0]**{random.randint(1, 3)}" for _ in range(40))
exec(f"def fun(t, y): return [y[1], -y[0] + {terms}]")

def solve(**options):
    return solve_ivp(fun, (0, 30), [0.1, 0.0], "Vern9", rtol=1e-8, **options)

"""
ENDS = {
    "exit": """
for i in range(3):
    solve()
time.sleep(PAUSE)
""",
    "exit with a status": """
solve()
solve()
time.sleep(PAUSE)
sys.exit(0)
""",
    "a fork": """
expected = solve(compile="shared").y
for i in range(3):
    solve()
time.sleep(PAUSE)
child = os.fork()
ok = np.array_equal(solve().y, expected)
if child == 0:
    for i in range(3):
        ok = ok and np.array_equal(solve().y, expected)
        background.finish()
    os._exit(not ok)
_, status = os.waitpid(child, 0)
background.finish()
ok = ok and np.array_equal(solve().y, expected)
sys.exit(os.waitstatus_to_exitcode(status) or not ok)
""",
}


@pytest.mark.few(3)
@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("pause", [0.0, 0.05, 0.15])
def test_a_process_may_end_or_fork_while_the_kernel_is_made(end, pause, tmp_path):
    if end == "a fork" and not hasattr(os, "fork"):
        pytest.skip("no fork")
    text = (BEGINNING + ENDS[end]).replace("PAUSE", str(pause))
    found = subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, timeout=120, check=False
    )
    assert (found.returncode, found.stderr) == (0, "")


def test_linking_needs_no_numba():
    text = BEGINNING + "solve(compile='inlined')\nsys.exit('numba' in sys.modules)\n"
    for _ in range(2):  # the first may find no kernel to link to, and make that
        found = subprocess.run([sys.executable, "-c", text], timeout=120, check=False)
    assert found.returncode == 0
