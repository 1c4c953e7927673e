"""Processes that start at once with an empty cache compile each kernel once between them."""

import fcntl
import os
import pathlib
import signal
import subprocess
import sys
import time

import pytest

from fastdyn.code_store import one_at_a_time
from fastdyn.code_store.folders import folders

N = 4
SOLVE = """
import sys
import fastdyn
from fastdyn import code_store

sys.stdin.readline()
fastdyn.solve_ivp(lambda t, y: -y, (0, 1), [1.0])
print(code_store.COUNTS["compiled"])
"""
HOLD = """
import sys, time
from fastdyn.code_store.one_at_a_time import alone

with alone("entry"):
    print("held", flush=True)
    time.sleep(60)
"""


def start(text, cache):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache), "FASTDYN_SHARED_CODE": ""}
    return subprocess.Popen(
        [sys.executable, "-c", text], env=environment, text=True, stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )  # fmt: skip


def compiled(processes):
    return [int(process.communicate("go\n", timeout=240)[0]) for process in processes]


@pytest.mark.hunt
def test_each_kernel_is_compiled_once(tmp_path):
    (alone,) = compiled([start(SOLVE, tmp_path / "one")])
    together = [start(SOLVE, tmp_path / "many") for _ in range(N)]
    for process in together:
        process.stdin.write("go\n")
        process.stdin.flush()
    traces = 1  # of the function, which each may make
    assert alone <= sum(compiled(together)) <= alone + traces * (N - 1)
    assert not list((tmp_path / "many" / "fastdyn").glob("*.lock"))


def test_one_who_died_blocks_nobody(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    holder = start(HOLD, tmp_path)
    assert holder.stdout.readline() == "held\n"
    with open(pathlib.Path(folders.own()) / "entry.lock") as file, pytest.raises(BlockingIOError):
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    begin = time.monotonic()
    with one_at_a_time.alone("entry"):
        assert time.monotonic() - begin < 1


def test_one_who_stands_still_is_waited_for_no_longer_than_anything_takes(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(one_at_a_time, "LONGEST", 0.2)
    begin = time.monotonic()
    with one_at_a_time.alone("entry"), one_at_a_time.alone("entry"):
        assert 0.1 < time.monotonic() - begin < 2
