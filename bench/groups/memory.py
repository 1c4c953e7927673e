"""Memory of a long endpoint-only run, in a process of its own."""

import subprocess
import sys

# What is resident now, not `ru_maxrss`: on Linux that starts at the peak of the process that
# started this one, and growth below it would not be seen.
SCRIPT = """
import resource
from fastdyn import solve_ivp
from bench.problems import PENDULUM
def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 2**20
def run(n):
    r = solve_ivp(PENDULUM.fun, (0.0, n * 1e-3), PENDULUM.y0, "RK4", step=1e-3, t_eval=[n * 1e-3],
                  args=PENDULUM.args, compile="inlined")
    return r.n_accepted
run(10**4)
before = resident()
n = run({n})
print(n, before, resident())
"""
FLAT = 1.0  # MiB


def rows(quick):
    """Resident memory after 10^4 steps and after all of them, in MiB; Linux only."""
    if not sys.platform.startswith("linux"):
        return
    n = 10**6 if quick else 10**8
    out = subprocess.run(
        [sys.executable, "-c", SCRIPT.format(n=n)], capture_output=True, text=True, check=True
    )
    steps, before, after = map(float, out.stdout.split())
    yield {
        "steps": int(steps),
        "mib_after_1e4": before,
        "mib_at_the_end": after,
        "target": f"+{FLAT:g} MiB",
        "met": after - before < FLAT,
    }
