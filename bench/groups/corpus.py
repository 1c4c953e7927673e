"""Right-hand sides as people write them, beside SciPy: answers, compiled or not, times."""

import contextlib
import functools
import io
import math
import multiprocessing
import os
import statistics
import sys
import tempfile
import time
import warnings

import scipy.integrate

from ..corpus import EXPLICIT, load
from ..report.timing import interleaved

LONGEST = 60.0  # s, of a case; then its process is ended
FIRST = 0.1  # s
TIMES, MORE = 1.5, 0.3  # what a first call may take: so many times SciPy, and s more


def is_compiled(said, calls, nfev):
    """Whether a function ran as machine code: no warning, and Python hardly saw it."""
    from fastdyn import CompileWarning

    return not any(issubclass(w.category, CompileWarning) for w in said) and 2 * calls < nfev


def rows(quick):
    """A row a case, from a process that has solved others; `first_s` is of a function never seen.

    The store of compiled code is new and holds kernels only.  `first_s` counts the whole solve.
    """
    names = list(load())[:: 10 if quick else 1]
    with tempfile.TemporaryDirectory() as folder:
        worker = _Worker(folder)
        for name in names:
            yield {"case": name} | worker.ask(name)
        worker.end()


def summary(found):
    """One line."""
    judged = [row for row in found if row["equal"] is not None]
    timed = [row for row in found if row["ratio"] is not None]
    explicit = [row["ratio"] for row in timed if row["method"] in EXPLICIT]
    machine_code = [r["ratio"] for r in timed if r["method"] in EXPLICIT and r["compiled"]]
    slower = [row["case"] for row in timed if row["ratio"] < 1 / 1.1]
    first = sum(row["first_s"] <= FIRST for row in timed)
    extra = sum(row["first_s"] - row["fastdyn_ms"] / 1e3 <= FIRST for row in timed)
    within = sum(row["first_s"] <= TIMES * row["scipy_ms"] / 1e3 + MORE for row in timed)
    compiled = sum(bool(row["compiled"]) for row in found)
    return (
        f"{len(found)} cases: answers equal {sum(r['equal'] for r in judged)} of {len(judged)}, "
        f"compiled {compiled / len(found):.0%}, "
        f"median warm ratio of explicit methods {statistics.median(explicit):.3g} "
        f"({statistics.median(machine_code):.3g} of those compiled), "
        f"slower than SciPy by more than 10 % {len(slower)}, first call within {FIRST} s "
        f"{first / len(timed):.0%} ({extra / len(timed):.0%} when a warm solve is subtracted), "
        f"within {TIMES} times SciPy and {MORE} s {within / len(timed):.1%}"
    )


class _Worker:
    """A process that solves cases; a new one after a case that hangs or crashes."""

    def __init__(self, folder):
        self.folder = folder
        self.process = None

    def ask(self, name):
        if self.process is None:
            self._start()
        why = f"no answer within {LONGEST:.0f} s"
        with contextlib.suppress(EOFError, OSError):
            self.pipe.send(name)
            if self.pipe.poll(LONGEST):
                return self.pipe.recv()
        self.process.join(1.0)
        if not self.process.is_alive():
            why = f"the process ended with code {self.process.exitcode}"
        self.end()
        return _row(load()[name]) | {"equal": False, "why": why}

    def end(self):
        if self.process is not None:
            self.process.kill()
            self.process.join()
        self.process = None

    def _start(self):
        context = multiprocessing.get_context("spawn")
        before = os.environ.get("NUMBA_CACHE_DIR")
        os.environ["NUMBA_CACHE_DIR"] = self.folder
        self.pipe, other = context.Pipe()
        self.process = context.Process(target=_serve, args=(other,), daemon=True)
        self.process.start()
        other.close()
        if before is None:
            del os.environ["NUMBA_CACHE_DIR"]
        else:
            os.environ["NUMBA_CACHE_DIR"] = before
        self.pipe.recv()


def _serve(pipe):
    cases = load()
    _warm_up()
    pipe.send("ready")
    while True:
        pipe.send(_measure(cases[pipe.recv()]))


def _warm_up():
    """Load the kernels of all methods and lengths, and Numba's compiler, by other functions."""
    import numpy as np

    import fastdyn

    matrix = -np.eye(40)
    functions = (
        lambda t, y: [-y[0] + math.sin(t), y[1] if t < 0 else -y[1]],
        lambda t, y: np.array([-y[0], -y[1] * np.cos(t)]),
        lambda t, y: -np.abs(y) + np.where(y > 1, 1.0, 0.5),
    )
    for method in (*EXPLICIT, "Radau", "BDF", "LSODA"):
        for fun in functions:
            for events in (None, lambda t, y: y[0] - 0.5):
                fastdyn.solve_ivp(fun, (0, 1), [1.0, 1.0], method, events=events)
        fastdyn.solve_ivp(lambda t, y, a: a @ y, (0, 1), np.ones(40), method, args=(matrix,))


def _measure(case):
    try:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            return _row(case) | _figures(case)
    except Exception as error:
        return _row(case) | {"equal": False, "why": f"{type(error).__name__}: {error}"}


def _row(case):
    names = (
        "n", "method", "error", "allowed", "nfev", "scipy_nfev", "equal", "compiled", "ratio",
        "scipy_ms", "fastdyn_ms", "first_s", "left_more", "why",
    )  # fmt: skip
    return dict.fromkeys(names) | {"n": len(case.y0), "method": case.method}


def _figures(case):
    import fastdyn
    from fastdyn.compile import background

    from ..corpus import agreement

    def left():
        return case.left() if case.left is not None else 0

    begun, at = time.perf_counter(), left()
    ours, said = agreement.run(fastdyn.solve_ivp, case)
    first, at_ours = time.perf_counter() - begun, left()
    theirs = agreement.run(scipy.integrate.solve_ivp, case).result
    more = None if case.left is None else (at_ours - at) - (left() - at_ours)
    background.finish()  # what the first solve did not wait for
    said = [*said, *agreement.run(fastdyn.solve_ivp, case).said]
    verdict = None if case.random else agreement.compare(case, ours, theirs)
    solvers = {"scipy": scipy.integrate.solve_ivp, "fastdyn": fastdyn.solve_ivp}
    given = {"method": case.method, "args": case.args} | case.options
    timed = {
        name: functools.partial(_solve, solver, case, given) for name, solver in solvers.items()
    }
    calls = _calls(timed["fastdyn"])
    least = {name: t[0] for name, t in interleaved(timed, 20, 0.6).items()}
    compile_said = [w for w in said if issubclass(w.category, fastdyn.CompileWarning)]
    return {
        "error": verdict and verdict.far,
        "allowed": verdict and verdict.allowed,
        "nfev": ours.nfev,
        "scipy_nfev": theirs.nfev,
        "equal": verdict and verdict.equal,
        "compiled": is_compiled(said, calls, ours.nfev),
        "ratio": least["scipy"] / least["fastdyn"],
        "scipy_ms": least["scipy"] * 1e3,
        "fastdyn_ms": least["fastdyn"] * 1e3,
        "first_s": first,
        "left_more": more,
        "why": "; ".join(str(w.message) for w in compile_said) or None,
    }


def _solve(solver, case, given):
    if case.reset is not None:
        case.reset()
    return solver(case.fun, case.t_span, case.y0, **given)


def _calls(solve):
    """How often Python enters a function of the corpus during a solve."""
    count = 0

    def seen(frame, event, _):
        nonlocal count
        count += event == "call" and "/corpus/" in frame.f_code.co_filename.replace("\\", "/")

    sys.setprofile(seen)
    try:
        solve()
    finally:
        sys.setprofile(None)
    return count
