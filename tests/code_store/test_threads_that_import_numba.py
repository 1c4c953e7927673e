"""Threads that import Numba at once, each through another module, all get all of it."""

import subprocess
import sys

import pytest

THREADS = """
import importlib, sys, threading, time
import numpy, fastdyn
sys.setswitchinterval(1e-5)
failed = []

def go(name, wait):
    time.sleep(wait)
    try:
        importlib.import_module(name)
    except Exception as error:
        failed.append(f"{name}: {error!r}")

names = sys.argv[2:]
threads = [
    threading.Thread(target=go, args=(name, i * float(sys.argv[1])))
    for i, name in enumerate(names)
]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
assert not failed, failed
"""
NAMES = (
    "fastdyn.compile.by_numba.pointer_form", "fastdyn.code_store.emit_object",
    "fastdyn.specialise.dispatchers", "fastdyn.code_store.deferred",
)  # fmt: skip


@pytest.mark.parametrize("wait", ["0.05", "0.2"])
def test_all_of_numba_is_there(wait):
    done = subprocess.run(
        [sys.executable, "-c", THREADS, wait, *NAMES], capture_output=True, text=True, timeout=110
    )
    assert done.returncode == 0, done.stderr[-900:]
