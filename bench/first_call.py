"""The first result of a function never seen, and of one seen before, for every compiled solver."""

import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

# {solver: (imports, a solve)}; the exponent makes the code of the functions differ.  It is odd: a
# damping of an even power drives what swings back to infinity.
SCRIPTS = {
    "fastdyn": (
        "import fastdyn",
        """
def fun(t, y):
    return [y[1], -{k} * y[0] - y[1] ** {power}]
def solve():
    return fastdyn.solve_ivp(fun, (0.0, 5.0), [1.0, 0.0])
""",
    ),
    "SciPy": (
        "import scipy.integrate",
        """
def fun(t, y):
    return [y[1], -{k} * y[0] - y[1] ** {power}]
def solve():
    return scipy.integrate.solve_ivp(fun, (0.0, 5.0), [1.0, 0.0])
""",
    ),
    "SciPy, njit": (
        "import numba, numpy as np, scipy.integrate",
        """
@numba.njit
def fun(t, y):
    return np.array([y[1], -{k} * y[0] - y[1] ** {power}])
def solve():
    return scipy.integrate.solve_ivp(fun, (0.0, 5.0), [1.0, 0.0])
""",
    ),
    "CyRK": (
        "import numpy as np; from CyRK import cyjit, nbsolve2_ivp",
        """
@cyjit
def fun(d, t, y, args):
    d[0] = y[1]
    d[1] = -{k} * y[0] - y[1] ** {power}
def solve():
    nbsolve2_ivp(fun.address, (0.0, 5.0), np.array([1.0, 0.0]), "RK45").free()
""",
    ),
    "heyoka": (
        "import heyoka as hy",
        """
x, v = hy.make_vars("x", "v")
def solve(made=[]):
    if not made:
        made.append(hy.taylor_adaptive([(x, v), (v, -{k} * x - v**{power})], [1.0, 0.0]))
    made[0].time = 0.0
    made[0].state[:] = [1.0, 0.0]
    made[0].propagate_until(5.0)
""",
    ),
    "diffrax": (
        "import diffrax, jax, jax.numpy as jnp",
        """
jax.config.update("jax_enable_x64", True)
def fun(t, y, args):
    return jnp.stack([y[1], -{k} * y[0] - y[1] ** {power}])
@jax.jit
def compiled(y0):
    return diffrax.diffeqsolve(
        diffrax.ODETerm(fun), diffrax.Dopri5(), 0.0, 5.0, None, y0, max_steps=10_000,
        stepsize_controller=diffrax.PIDController(rtol=1e-3, atol=1e-6),
    ).ys
def solve():
    return compiled(jnp.array([1.0, 0.0])).block_until_ready()
""",
    ),
    "CVODE, njit": (
        "import numba, numpy as np; from sksundae.cvode import CVODE",
        """
@numba.njit
def fun(t, y, d):
    d[0] = y[1]
    d[1] = -{k} * y[0] - y[1] ** {power}
def solve():
    return CVODE(fun, method="Adams").solve([0.0, 5.0], np.array([1.0, 0.0]))
""",
    ),
}
TIMED = """
import time
a = time.perf_counter()
{numba}
b = time.perf_counter()
{imports}
c = time.perf_counter()
{body}
solve()
d = time.perf_counter()
solve()
print(c - b, d - c, time.perf_counter() - d)
"""
LONGEST = 300.0  # s
TARGETS = {"never seen": 0.5, "new process": 0.1, "import": 0.2}
LABELS = {
    "import": "import",
    "never seen": "function never seen",
    "new process": "the same script in a new process",
    "second": "second call",
}


def _run(solver, folder, k, power):
    """Seconds to import, to the first result and to the second, of a script in a new process.

    fastdyn's import is counted after Numba's.
    """
    imports, body = SCRIPTS[solver]
    script = pathlib.Path(folder, f"script_{power}.py")
    script.write_text(
        TIMED.format(
            numba="import numba" if solver == "fastdyn" else "",
            imports=imports,
            body=body.format(k=k, power=power),
        )
    )
    out = subprocess.run(
        [sys.executable, str(script)],
        env=os.environ | {"NUMBA_CACHE_DIR": str(pathlib.Path(folder, "cache"))},
        capture_output=True,
        text=True,
        check=False,
        timeout=LONGEST,
    )
    if "ModuleNotFoundError" in out.stderr:
        return None
    out.check_returncode()
    return tuple(float(word) for word in out.stdout.split())


def rows(quick):
    """Least and median seconds of each, over a few fresh processes; fastdyn's kernels cached."""
    for solver in SCRIPTS:
        seen = {name: [] for name in LABELS}
        with tempfile.TemporaryDirectory() as folder:
            cold = _run(solver, folder, 1.0, 3)
            if cold is None:
                print(f"skipped {solver}: not installed")
                continue
            for i in range(1 if quick else 3):
                given = solver, folder, 2.0 + i, 5 + 2 * i
                seen["never seen"].append(_run(*given)[1])
                imported, again, second = _run(*given)
                seen["new process"].append(again)
                seen["import"].append(imported)
                seen["second"].append(second)
        yield _row(solver, "first function, nothing cached", [cold[1]], None)
        for name, seconds in seen.items():
            label = LABELS[name]
            if (solver, name) == ("fastdyn", "import"):
                label = "import after numba"
            yield _row(solver, label, seconds, TARGETS.get(name) if solver == "fastdyn" else None)


def _row(solver, label, seconds, target):
    median = statistics.median(seconds)
    return {
        "solver": solver,
        "what": label,
        "runs": len(seconds),
        "min_s": min(seconds),
        "median_s": median,
        "target": f"<= {target}" if target else "",
        "met": bool(median <= target) if target else None,
    }
