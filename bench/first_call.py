"""The first result of a function never seen, and of one seen in an earlier process."""

import os
import statistics
import subprocess
import sys
import tempfile

SCRIPT = """
import time
a = time.perf_counter()
import numba
b = time.perf_counter()
import fastdyn
c = time.perf_counter()
def fun(t, y):
    return [y[1], -{k} * y[0] - y[1] ** {power}]
r = fastdyn.solve_ivp(fun, (0.0, 5.0), [1.0, 0.0])
print(b - a, c - b, time.perf_counter() - c)
"""
TARGETS = {"never seen": 0.5, "new process": 0.1, "import": 0.2}


def _run(cache, k, power):
    script = SCRIPT.format(k=k, power=power)
    environment = os.environ | {"NUMBA_CACHE_DIR": cache}
    out = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
    )
    return [float(word) for word in out.stdout.split()]


def rows(quick):
    """Median seconds of each, over a few fresh processes."""
    seen = {"cold kernels": [], "never seen": [], "new process": [], "import": []}
    with tempfile.TemporaryDirectory() as cache:
        seen["cold kernels"].append(_run(cache, 1.0, 2)[2])
        for i in range(1 if quick else 7):
            seen["never seen"].append(_run(cache, 2.0, 3 + i)[2])
            _, ours, seconds = _run(cache, 2.0, 3 + i)
            seen["new process"].append(seconds)
            seen["import"].append(ours)
    for name, seconds in seen.items():
        target = TARGETS.get(name)
        median = statistics.median(seconds)
        yield {
            "what": {"import": "import fastdyn after import numba"}.get(name, name),
            "seconds": median,
            "target": f"<= {target}" if target else "",
            "met": bool(median <= target) if target else None,
        }
