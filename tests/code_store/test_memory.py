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
for seed in range(40, 240):
    solved(seed)
print((resident() - before) / 200)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="it reads /proc")
def test_a_function_leaves_little():
    """Some 120 kB, while LLVM's passes stayed, and one linker had all pieces of code."""
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
