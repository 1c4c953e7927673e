"""Runs that are ready, of a prepared solver: memory, references, threads, processes."""

import gc
import math
import os
import sys
import tracemalloc
import warnings

import numpy as np
import pytest

from fastdyn.compile import background
from support.repeated import START, both_ways, in_threads, is_plain, pendulum


def test_no_reference_and_no_memory_is_lost():
    k = 0.3
    mine, _ = both_ways(args=(k,))
    args = (k,)
    watched = START, args, k, pendulum, float, np.ndarray, np.dtype(float), None, mine, math, "t"
    watched = [*watched, mine._solver.idle[0]]

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

    mine, plain = both_ways(fun, (0.0, end), args=(1.0,), t_eval=[end])
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
    mine, plain = both_ways()
    expected = plain([0.1, 0.2]).y.tobytes()
    child = os.fork()
    if child == 0:
        os._exit(0 if mine([0.1, 0.2]).y.tobytes() == expected else 1)
    assert os.waitpid(child, 0)[1] == 0


def test_what_is_not_plain():
    def fun(t, y):
        return [-y[0]]

    def in_python(t, y):
        return float(str(y[0])) - 0.5

    for options, is_ready in (
        ({"events": lambda t, y: y[0] - 0.5}, True), ({"dense_output": True}, True),
        ({"t_eval": [0, 1]}, True), ({"t_eval": []}, True), ({"project": lambda t, y: y}, True),
        ({"on_interrupt": "return"}, False), ({"events": in_python}, False),
    ):  # fmt: skip
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an event that runs in Python
            mine, plain = both_ways(fun, y0=[1.0], **options)
        assert is_plain(mine, [1.0]) == is_ready, options
        for name in ("t", "y", "nfev", "status"):
            assert np.array_equal(plain([1.0])[name], mine([1.0])[name])
