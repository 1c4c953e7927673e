"""What stays in memory of a function that was compiled."""

import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from fastdyn import code_store

CODE = """
import random
import time
import numpy as np
from fastdyn import solve_ivp

def resident():
    with open("/proc/self/statm") as file:
        return 4 * int(file.read().split()[1])

def solved(seed):
    rng, scope = random.Random(f"{seed} {time.time()}"), {"np": np}  # none is kept on disk
    terms = [
        f"np.{rng.choice(['sin', 'cos', 'tanh', 'arctan'])}({rng.random():.6f} * y[{i}])"
        for i in (0, 1, 0, 1)
    ]
    first, second = f"{terms[0]} * {terms[1]}", f"{terms[2]} - {terms[3]}"
    exec(f"def f(t, y): return [y[1] - .1 * {first}, {second}]", scope)
    solve_ivp(scope["f"], (0, 1), [1.0, 0.0])

for seed in range(40):
    solved(seed)
before = resident()
for seed in range(40, 640):
    solved(seed)
print((resident() - before) / 600)
"""


@pytest.mark.hunt
@pytest.mark.skipif(sys.platform != "linux", reason="it reads /proc")
def test_a_function_leaves_little():
    """Some 84 kB; 120, while LLVM's passes stayed, and one linker had all pieces of code."""
    run = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert float(run.stdout) < 95.0, run.stdout


def test_what_two_threads_make_at_once_is_one_and_stays():
    """Else the address that one thread has got would be that of code which left memory."""
    together = threading.Barrier(2)

    @code_store.first_kept
    def made(name):
        together.wait(10)
        return [name]

    with ThreadPoolExecutor(2) as pool:
        one, other = pool.map(made, ["a", "a"])
    assert one is other is made("a")


BETWEEN_LARGE_ARRAYS = """
import ctypes
import llvmlite.binding as llvm
from fastdyn.code_store.loader import load
from fastdyn.code_store.target import translated

numbers = ", ".join(f"double {i}.5" for i in range(64))
code, needs = translated(f'''
@table = private constant [64 x double] [{numbers}]
define double @entry(i64 %i) {{
  %place = getelementptr [64 x double], ptr @table, i64 0, i64 %i
  %value = load double, ptr %place
  ret double %value
}}''', "entry")
first = load(code, "entry", needs)
libc = ctypes.CDLL(None)
libc.mmap.restype = ctypes.c_void_p
libc.mmap.argtypes = [ctypes.c_void_p, ctypes.c_size_t, *3 * [ctypes.c_int], ctypes.c_long]
libc.munmap.argtypes = [ctypes.c_void_p, ctypes.c_size_t]
PRIVATE, NEVER_OVER_ANOTHER = 0x22, 0x100000
far, page = 3 << 30, 4096
large = libc.mmap(None, 4 * far, 0, PRIVATE, -1, 0)
with open("/proc/self/maps") as file:
    spans = [[int(end, 16) for end in line.split()[0].split("-")] for line in file]
for (_, begin), (end, _) in zip(spans, spans[1:]):
    if large < begin < end < begin + far:  # no gaps but those below
        libc.mmap(begin, end - begin, 0, PRIVATE | NEVER_OVER_ANOTHER, -1, 0)
for k in range(1, 5):  # room for one section each
    libc.munmap(large + k * far - page, page)
others = [load(code, "entry", needs) for _ in range(20)]
print([ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_int64)(other.address)(7) for other in others])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="it reads /proc")
def test_code_lies_beside_its_data_in_a_process_with_large_arrays():
    """LLVM's older linker ended the process: `isInt<32>(RealOffset)` was not so."""
    run = subprocess.run(
        [sys.executable, "-c", BETWEEN_LARGE_ARRAYS], capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr[-900:]
    assert run.stdout.strip() == str(20 * [7.5])
