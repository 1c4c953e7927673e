"""The first result of a function never seen, and of one seen in an earlier process."""

import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

# The exponent makes the code of the functions differ, not only a constant.
SCRIPT = """
import time
a = time.perf_counter()
import numba
b = time.perf_counter()
import fastdyn
c = time.perf_counter()
def fun(t, y):
    return [y[1], -{k} * y[0] - y[1] ** {power}]
d = time.perf_counter()
r = fastdyn.solve_ivp(fun, (0.0, 5.0), [1.0, 0.0])
print(c - b, time.perf_counter() - d)
"""
TARGETS = {"never seen": 0.5, "new process": 0.1, "import": 0.2}
LABELS = {
    "cold": "first function, nothing cached",
    "never seen": "function never seen, kernels cached",
    "new process": "the same script in a new process",
    "import": "import fastdyn after import numba",
}


def _run(folder, k, power):
    """(seconds to import fastdyn, seconds to the first result) of a script in a new process."""
    script = pathlib.Path(folder, f"script_{power}.py")
    script.write_text(SCRIPT.format(k=k, power=power))
    out = subprocess.run(
        [sys.executable, str(script)],
        env=os.environ | {"NUMBA_CACHE_DIR": str(pathlib.Path(folder, "cache"))},
        capture_output=True,
        text=True,
        check=True,
    )
    return tuple(float(word) for word in out.stdout.split())


def rows(quick):
    """Least and median seconds of each, over a few fresh processes."""
    seen = {name: [] for name in LABELS}
    for _ in range(1 if quick else 3):
        with tempfile.TemporaryDirectory() as folder:
            seen["cold"].append(_run(folder, 1.0, 2)[1])
            for i in range(1 if quick else 3):
                seen["never seen"].append(_run(folder, 2.0 + i, 3 + i)[1])
                ours, seconds = _run(folder, 2.0 + i, 3 + i)
                seen["new process"].append(seconds)
                seen["import"].append(ours)
    for name, seconds in seen.items():
        target = TARGETS.get(name)
        median = statistics.median(seconds)
        yield {
            "what": LABELS[name],
            "runs": len(seconds),
            "min_s": min(seconds),
            "median_s": median,
            "target": f"<= {target}" if target else "",
            "met": bool(median <= target) if target else None,
        }
