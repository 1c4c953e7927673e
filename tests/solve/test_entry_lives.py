"""The compiled entry of a prepared solver: memory, threads, processes, the switch."""

import gc
import math
import os
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest

import fastdyn
from fastdyn.compile import background
from fastdyn.solve.entry import load
from support.entries import START, by_c, in_c_and_python, in_threads, loaded, pendulum, prepared


def test_no_reference_and_no_memory_is_lost():
    k = 0.3
    mine, _ = in_c_and_python(args=(k,))
    args = (k,)
    watched = START, args, k, pendulum, float, np.ndarray, np.dtype(float), None, mine, math, "t"
    watched = [*watched, fastdyn.solve.entry.objects.TEMPLATE, mine._solver.idle[0]]

    def many(n):
        for _ in range(n):
            mine(START, args)
            mine([1, 2])
            try:
                mine([1.0])
            except ValueError:
                pass

    many(200)
    background.finish()  # memory and references are counted for all threads
    gc.collect()
    before = [sys.getrefcount(thing) for thing in watched]
    tracemalloc.start()
    many(200)
    kept = tracemalloc.get_traced_memory()[0]
    many(5000)
    gc.collect()
    grown = tracemalloc.get_traced_memory()[0] - kept
    tracemalloc.stop()
    assert grown < 20_000
    after = [sys.getrefcount(thing) for thing in watched]
    assert all(abs(b - a) < 100 for a, b in zip(before, after, strict=True)), (before, after)


@pytest.mark.parametrize("end", [0.01, 100.0])
def test_threads_share_a_solver(end):
    def fun(t, y, k):
        return [y[1], -k * y[0]]

    mine, plain = in_c_and_python(fun, (0.0, end), args=(1.0,), t_eval=[end])
    expected = {k: plain(START, (k,)).y.tobytes() for k in (0.5, 1.0, 2.0, 4.0)}
    wrong = []

    def work(k):
        for _ in range(300):
            if mine(START, (k,)).y.tobytes() != expected[k]:
                wrong.append(k)

    in_threads(work, expected)
    assert not wrong


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_a_forked_process_goes_on():
    mine, plain = in_c_and_python()
    expected = plain([0.1, 0.2]).y.tobytes()
    child = os.fork()
    if child == 0:
        os._exit(0 if mine([0.1, 0.2]).y.tobytes() == expected else 1)
    assert os.waitpid(child, 0)[1] == 0


SCRIPT = """
import numpy as np, sys, fastdyn
from fastdyn.solve.entry import load
solver = fastdyn.prepare(lambda t, y: [-y[0]], (0, 1), [1.0], compile="shared")
for _ in range(9):
    load.is_here(60.0)
    result = solver([1.0])
    other = fastdyn.solve_ivp(lambda t, y: [-y[0]], (0, 1), [1.0])
made = "fastdyn.solve.entry.emit" in sys.modules
print(result._unmade is None, load.is_here(), result.y[0, -1], made)
"""


def test_the_switch_and_the_kept_code():
    loaded()

    def said(**settings):
        environment = {**os.environ, **settings}
        run = subprocess.run(
            [sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True
        )
        assert not run.stderr, run.stderr
        return run.stdout.split()

    prepared()()
    said()
    on, off = said(), said(FASTDYN_ENTRY="off")
    assert on[:2] == ["True", "True"] and off[:2] == ["False", "False"] and on[2] == off[2]
    assert on[3] == "False"  # the code is kept


def test_what_only_python_can_solve_has_no_entry():
    def fun(t, y):
        return [-y[0]]

    for options in (
        {"events": lambda t, y: y[0] - 0.5}, {"dense_output": True}, {"t_eval": [0, 1]},
        {"t_eval": []}, {"on_interrupt": "return"}, {"project": lambda t, y: y},
    ):  # fmt: skip
        mine, plain = in_c_and_python(fun, y0=[1.0], **options)
        result = mine([1.0])
        assert not by_c(result)
        for name in ("t", "y", "nfev", "status"):
            assert np.array_equal(plain([1.0])[name], result[name])
    assert load.is_here()
