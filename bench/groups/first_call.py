"""From the start of a process to the first answer: new machine, new function, the same again."""

import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

from fastdyn import METHODS

from .. import rivals

ROOT = pathlib.Path(__file__).parents[2]
# The exponent makes the code of the functions differ.  It is odd: a damping of an even power drives
# what swings back to infinity.
TIMED = """
import time
import numpy
b = time.perf_counter()
{imports}
c = time.perf_counter()
{body}
solve()
answer = time.time()
d = time.perf_counter()
solve()
print(answer, c - b, time.perf_counter() - d)
"""
LONGEST = 300.0  # s
UNSET = {"NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "PYTHONPATH", "PYTHONDONTWRITEBYTECODE"}
LABELS = {
    "new machine": "new machine: first answer",
    "new function": "new function: first answer",
    "again": "again, to the end, over `import numpy`",
    "import": "import, over numpy",
    "second": "second call",
}
TARGETS = {
    ("fastdyn, wheel", "new machine"): 0.25,
    ("fastdyn, wheel", "new function"): 0.25,
    ("fastdyn, wheel", "again"): 0.1,
    ("fastdyn, wheel, a function for Numba", "new function"): 0.5,  # over the import of Numba
    ("fastdyn, checkout", "new machine"): 4.0,
    ("fastdyn, checkout", "again"): 0.1,
}


def _process(given, home, site=None):
    """The lines of a new process, when it began, and its seconds; caches lie below `home`."""
    env = {name: value for name, value in os.environ.items() if name not in UNSET}
    env |= {"HOME": str(home), "FASTDYN_SHARED_CODE": ""}
    if site is not None:
        env["PYTHONPATH"] = str(site)
    began = time.time()
    out = subprocess.run(
        [sys.executable, *given], env=env, cwd=home, capture_output=True, text=True, check=True,
        timeout=LONGEST,
    )  # fmt: skip
    return out.stdout.split(), began, time.time() - began


def _run(script, home, site, k, power, method="RK45"):
    """Seconds of a script: to the first answer, to import, to the second answer, to the end."""
    imports, body = script
    file = home / f"script_{power}.py"
    body = body.format(k=k, power=power, method=method)
    file.write_text(TIMED.format(imports=imports, body=body))
    (answer, imported, second), began, spent = _process([str(file)], home, site)
    return float(answer) - began, float(imported), float(second), spent


def _imports(module, home):
    return _process(["-c", f"import {module}"], home)[2]


def _site(folder):
    """A folder with the wheel that `make wheel` made; None if there is none."""
    wheels = list(ROOT.glob("dist/fastdyn-*.whl"))
    if not wheels:
        print("skipped what is installed from a wheel: `make wheel` makes one")
        return None
    install = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target"]
    subprocess.run([*install, folder, wheels[0]], check=True, stderr=subprocess.DEVNULL)
    return folder


def _cases(site):
    """{solver: (script, folder of packages)}; fastdyn from its wheel, too."""
    cases = {}
    for solver, script in rivals.first_calls().items():
        if not solver.startswith("fastdyn"):
            cases[solver] = script, None
            continue
        if site is not None:
            cases[solver.replace("fastdyn", "fastdyn, wheel")] = script, site
        cases[solver.replace("fastdyn", "fastdyn, checkout")] = script, None
    return cases


def rows(quick):
    """Least and median seconds of each, over a few fresh processes."""
    repeats = 1 if quick else 3
    with tempfile.TemporaryDirectory() as folder:
        site = _site(pathlib.Path(folder, "site"))
        yield from (bare := _bare(repeats))
        numba = bare[1]["median_s"] - bare[0]["median_s"]
        for solver, (script, packages) in _cases(site).items():
            seen = _seen(script, packages, repeats)
            for name, seconds in seen.items():
                target = TARGETS.get((solver, name))
                if target and "Numba" in solver:
                    target += numba
                yield _row(solver, LABELS[name], seconds, target)
        if site is not None:
            yield _slowest(rivals.first_calls()["fastdyn"], site, repeats)


def _bare(repeats):
    """What the imports take that others wait for."""
    found = []
    for module in ("numpy", "numpy, numba"):
        with tempfile.TemporaryDirectory() as home:
            seconds = [_imports(module, pathlib.Path(home)) for _ in range(repeats)]
        found.append(_row(f"import {module}", LABELS["new machine"], seconds, None))
    return found


def _seen(script, site, repeats):
    """{name: seconds, one a repetition} of a solver."""
    seen = {name: [] for name in LABELS}
    for i in range(repeats):
        with tempfile.TemporaryDirectory() as name:
            home = pathlib.Path(name)
            seen["new machine"].append(_run(script, home, site, 1.0, 3)[0])
            seen["new function"].append(_run(script, home, site, 2.0 + i, 5)[0])
            bare = _imports("numpy", home)
            _, imported, second, spent = _run(script, home, site, 2.0 + i, 5)
            seen["again"].append(spent - bare)
            seen["import"].append(imported)
            seen["second"].append(second)
    return seen


def _slowest(script, site, repeats):
    """The row of the method whose first answer on a new machine takes longest."""
    found = {method: [] for method in METHODS}
    for _ in range(repeats):
        for method, seconds in found.items():
            with tempfile.TemporaryDirectory() as home:
                seconds.append(_run(script, pathlib.Path(home), site, 1.0, 3, method)[0])
    method = max(found, key=lambda name: statistics.median(found[name]))
    solver = f"fastdyn, wheel, slowest of {len(found)} methods: {method}"
    return _row(solver, LABELS["new machine"], found[method], 0.25)


def _row(solver, label, seconds, target):
    median = statistics.median(seconds)
    return {
        "solver": solver,
        "what": label,
        "runs": len(seconds),
        "min_s": min(seconds),
        "median_s": median,
        "target": f"<= {target:.2g}" if target else "",
        "met": bool(median <= target) if target else None,
    }
