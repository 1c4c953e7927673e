"""Answers of a fresh process, for functions that other processes have compiled or will.

    python across.py together NAME...     prints {name: numbers} as JSON
    python across.py apart NAME...        the same, by a process for each

A name is one of `everyday.CASES`, or the number of a drawn function, and a mode: "sine:pointer".
Functions are solved in the order given, in a tier of `solve_ivp` or in an ensemble of two.

Processes apart are forks of one that has compiled one function: Numba's counters stand the same
in each, which is when their names for different code are the same.
"""

import json
import os
import pathlib
import subprocess
import sys

import numba
import numpy as np
import scipy.integrate

HERE = pathlib.Path(__file__).parent
MODES = ("shared", "inlined", "ensemble")
TOLERANCES = {"rtol": 1e-6, "atol": 1e-9}
CLOSE = 1e-6  # both take the same steps; a wrong function is off by far more


def case_named(name):
    from support import drawn, everyday

    name, _ = name.split(":")
    if not name.isdigit():
        return everyday.CASES[name]
    found = drawn.module(int(name))
    return everyday.Case(found["fun"], found["args"], tuple(found["y0"]))


def answer(name):
    """Numbers that tell the function: the end state, the events, the fold."""
    return [float(x) for x in _solved(case_named(name), name.split(":")[1])]


def _solved(case, mode):
    import fastdyn

    given = {"events": case.events, "project": case.project, "method": "RK23", **TOLERANCES}
    if mode in ("shared", "inlined") and case.fold is None:
        r = fastdyn.solve_ivp(case.fun, (0, 1), case.y0, args=case.args, compile=mode, **given)
        return [*r.y[:, -1], *np.concatenate(r.t_events or [[]])]
    args = [a if np.ndim(a) == 0 else fastdyn.ensemble.Shared(a) for a in case.args]
    states = np.outer([1.0, 1.0], case.y0)
    found = fastdyn.solve_ensemble(
        case.fun, (0, 1), states, args=args, reduce=case.fold, threads=1, **given
    )
    folded = [] if case.fold is None else [v[1] for v in found.reduced.values()]
    events = [times[1] for times in found.t_events or []]
    return [*found.y_end[1], *np.concatenate([*events, folded])]


def expected(name):
    """The same by SciPy, or by functions that stay in Python where SciPy has no such thing."""
    case = case_named(name)
    if case.fold is not None:
        case = case._replace(fold=case.fold._replace(function=in_python(case.fold.function)))
        return _solved(case._replace(fun=in_python(case.fun)), "ensemble")
    if case.project is not None:
        case = case._replace(fun=in_python(case.fun), project=in_python(case.project))
        return _solved(case, "shared")
    r = scipy.integrate.solve_ivp(
        case.fun, (0, 1), case.y0, args=case.args, events=case.events, method="RK23", **TOLERANCES
    )
    return [*r.y[:, -1], *np.concatenate(r.t_events or [[]])]


def what_all_need():
    """Compile, or load, the kernels that are the same for all functions."""
    for mode in MODES:
        answer(f"first:{mode}")


def in_python(function):
    """The same function, which cannot be compiled."""
    return lambda *given: {"it": function}["it"](*given)


def start(cache, how, names):
    """A process that answers."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": _paths()}
    return subprocess.Popen(
        [sys.executable, "-W", "ignore", __file__, how, *names],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def _paths():
    return os.pathsep.join([str(HERE.parent), *filter(None, [os.environ.get("PYTHONPATH")])])


def answers(process, seconds=300):
    """{name: numbers} of a process that was started."""
    try:
        out, errors = process.communicate(timeout=seconds)
    finally:
        process.kill()
    assert process.returncode == 0, errors[-2000:]
    return json.loads(out)


def wrong(found, reference):
    """Names whose answers are not those of the reference."""
    return [
        name
        for name, numbers in found.items()
        if len(numbers) != len(reference[name])
        or not np.allclose(numbers, reference[name], rtol=CLOSE, atol=CLOSE)
    ]


def answer_of_fork(name):
    """The same, by a copy of this process."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.write(writing, json.dumps(answer(name)).encode())
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as pipe:
        found = pipe.read()
    assert os.waitpid(child, 0)[1] == 0, f"the process for {name} died"
    return json.loads(found)


if __name__ == "__main__":
    how, *names = sys.argv[1:]
    solved = answer if how == "together" else answer_of_fork
    if solved is answer_of_fork:
        numba.njit("float64(float64)")(lambda x: x)
    what_all_need()
    json.dump({name: solved(name) for name in names}, sys.stdout)
