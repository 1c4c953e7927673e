"""A module solved, by SciPy or by fastdyn: all that a user could see of it."""

import builtins
import contextlib
import decimal
import io
import linecache
import sys
import time
import types
import warnings
from typing import Any, NamedTuple

import numpy as np

from .solvers import ByFastdyn, ByScipy, InPython
from .ways import WAYS


class Outcome(NamedTuple):
    """What was seen: of each solve (times, end, events, status); what was raised; what is left."""

    runs: list
    raised: Any
    nfev: int
    left: Any
    warned: list
    seconds: float


def loaded(source, name):
    """A module of its own."""
    module = types.ModuleType(name)
    module.__file__ = f"/hostile/{name}.py"
    linecache.cache[module.__file__] = (len(source), None, source.splitlines(True), module.__file__)
    sys.modules[name] = module
    exec(compile(source, module.__file__, "exec"), vars(module))
    return module


def outcome(source, by, name="drawn", noise=0, rtol=None, keeps=False):
    """Solve what a module asks for.

    `by` is "scipy", "fastdyn", or "python" for fastdyn with the function in Python.  With `noise`
    the rates of SciPy's function have an error of a few units in the last place; if it `keeps`,
    SciPy gets the very array that the function returns.
    """
    module = loaded(source, name)
    how = dict(module.HOW)
    if rtol is not None:
        how |= {"rtol": rtol, "atol": rtol * 1e-2}
    ours = InPython if by == "python" else ByFastdyn
    solver: Any = ByScipy(module, how, noise, keeps) if by == "scipy" else ours(module, how)
    solver.again = lambda: loaded(source, name)
    raised, left, began = None, None, time.perf_counter()
    with _settings_kept(), warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            WAYS[how["way"]](solver)
        except Exception as error:
            raised = type(error).__name__, str(error), _in_module(error, module)
        with contextlib.suppress(Exception):
            left = repr(module.watched())
    seconds = time.perf_counter() - began
    said = [str(w.message) for w in caught if w.category.__name__ == "CompileWarning"]
    return Outcome(solver.runs, raised, solver.nfev, left, said, seconds)


@contextlib.contextmanager
def _settings_kept():
    """What a module sets for the whole process holds for one outcome."""
    limit, names = sys.getrecursionlimit(), dict(vars(builtins))
    with np.errstate(), decimal.localcontext(), contextlib.redirect_stdout(io.StringIO()):
        try:
            yield
        finally:
            sys.setrecursionlimit(limit)
            vars(builtins).update(names)


def _in_module(error, module):
    """Whether the user's own code raised, the libraries that he calls aside."""
    trace = error.__traceback__
    found = False
    while trace is not None:
        found = found or trace.tb_frame.f_code.co_filename == module.__file__
        trace = trace.tb_next
    return found
