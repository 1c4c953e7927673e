"""Memory of a long endpoint-only run, in a process of its own."""

import subprocess
import sys

SCRIPT = """
import resource
from fastdyn import solve_ivp
from bench.problems import pendulum
def run(n):
    r = solve_ivp(pendulum, (0.0, n * 1e-3), [0.0, 0.1], "RK4", step=1e-3, t_eval=[n * 1e-3],
                  args=(9.81, 1.0), tier="specialised")
    return r.n_accepted, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
_, before = run(10**4)
n, after = run({n})
print(n, before, after)
"""


def rows(quick):
    """Largest resident memory after 10^4 steps and after all of them, in MiB."""
    n = 10**6 if quick else 10**8
    out = subprocess.run(
        [sys.executable, "-c", SCRIPT.format(n=n)], capture_output=True, text=True, check=True
    )
    steps, before, after = map(int, out.stdout.split())
    yield {
        "steps": steps,
        "mib_after_1e4": before / 1024,
        "mib_at_the_end": after / 1024,
        "target": "flat",
        "met": after - before < 1024,
    }
