"""Functions of few evaluations: SciPy's own odeint calls them, as to compile them takes longer.

The evaluations of a function are counted over all its solves.  Where they are more than `MOST`, the
function is compiled, also in the middle of a solve, which then begins anew: tracing has shown that
the function does nothing but give its value.  A function that cannot be compiled stays SciPy's.
"""

import math
import os
import sys
import threading
import types as python
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from typing import Any

import numpy as np
import scipy

from fastdyn.compile import memory
from fastdyn.compile.callables import plain_function
from fastdyn.compile.python_callback import called_with, explained
from fastdyn.words.raised import argument_names, of_solve_ivp

from .equations import MOST_STEPS
from .messages import DONE, SAID
from .order import time_first

# To compile a function takes 10 to 30 ms, an evaluation in Python 1 to 2 us for a few numbers.  Of
# 74 scripts, those with fewer evaluations are slower with compiled code, those with more faster.
MOST = 16_000
# To count each evaluation costs 0.07 to 0.2 us.  Solves that can have no more steps than these, and
# those that are expected to have few, are counted afterwards.
FEW_STEPS = 100_000  # 0.2 s
FUNCTION, FLOAT = python.FunctionType, np.dtype(float)
FILE = "scipy.integrate._odepack"
SURELY = 4  # solves may have so many times the expected evaluations
_one_at_a_time = threading.Lock()
_solves = memory.Table()  # Spent, by the code of the function


class Spent:
    """The evaluations that a function has had in Python.

    Attributes
    ----------
    n : int
        Evaluations so far, as far as they were counted.
    solves : int
        Solves so far.
    a_row : float
        Evaluations for each row of the last solve that was counted; 0: none was.
    most : int
        Evaluations after which the function is compiled.
    ours : bool
        Whether solves are compiled from now on.
    code : object
        Is kept alive, as its id is the key.
    """

    def __init__(self, code, ours):
        self.n = 0
        self.solves = 0
        self.a_row = 0.0
        self.most = MOST
        self.ours = ours
        self.code = code

    def is_compiled(self, try_to, given):
        """Try to compile the function; if that fails, the next trial is far."""
        self.ours = try_to(given)
        self.most = 2 * self.n + MOST
        return self.ours

    def is_surely_few(self, n_rows, mxstep):
        """Whether a solve need not be counted while it runs."""
        if n_rows * (mxstep or MOST_STEPS) <= FEW_STEPS:
            return True
        return 0.0 < SURELY * self.a_row * n_rows < self.most - self.n

    def begin(self):
        """Whether a solve is to be counted: of the solves, that is the second, fourth, eighth."""
        self.solves += 1
        return self.solves > 1 and not self.solves & (self.solves - 1)

    def count(self, n_rows, n=None):
        """Count the `n` evaluations of a solve, or as many as a counted solve has had."""
        if n is None:
            n = self.a_row * n_rows
        else:
            self.a_row = n / n_rows
        self.n += int(n)


class _Overtaken(Exception):
    """The code of a function was made in the middle of a solve."""


def solved(spent, given, try_to):
    """What `odeint` returns, by SciPy's; None for the long way.

    Parameters
    ----------
    spent : Spent
    given : tuple
        The arguments of `odeint` from `func` to `mxords`, and `tfirst`, in this order.
    try_to : callable
        ``try_to(given)`` compiles the function, and tells whether it succeeded.
    """
    _, y0, t = given[:3]
    try:
        t = np.array(t, FLOAT)
        y0 = np.array(y0, FLOAT)
        if not (_is_usual(given) and y0.ndim < 2 and y0.size and _is_monotonic(t)):
            return None
        if not math.isfinite(sum(y0.ravel().tolist())):
            return None
    except (TypeError, ValueError):
        return None
    if spent.n >= spent.most and spent.is_compiled(try_to, given):
        return None
    if not _one_at_a_time.acquire(blocking=False):  # SciPy's code may keep its state in one place
        return None
    try:
        return _by_scipy(spent, given, y0, t, try_to)
    finally:
        _one_at_a_time.release()


def _by_scipy(spent, given, y0, t, try_to):
    """What SciPy's odeint returns, or None if it fails or the function is compiled meanwhile."""
    n_rows = len(t) - 1
    full = given[6]
    counts = spent.begin()
    fun = given[0]
    number: Any = None
    if not spent.is_surely_few(n_rows, given[16]):
        fun, number = _counted(spent, given, t, try_to)
    elif counts:
        full = True
    try:
        found = scipys()(fun, y0, t, given[3], *_for_scipy(given, full))
    except _Overtaken:
        return None
    except Exception as error:
        if _is_of(error, spent, given):
            raise
        return None  # which has a sentence for what SciPy refuses
    rows = found[0]
    if found[-1] != DONE or not math.isfinite(sum(rows[-1].tolist())):
        return None
    if number is not None:
        spent.count(n_rows, number())
    else:
        spent.count(n_rows, int(found[1]["nfe"][-1]) if full else None)
    if not given[6]:
        return rows
    found[1]["message"] = SAID[DONE]
    return rows, found[1]


@memory.cached
def scipys() -> Any:
    """SciPy's odeint without its checks of arguments, which take 5 us a call.

    To import all of `scipy.integrate` takes 0.4 s, its file with ODEPACK 0.01 s.
    """
    module = sys.modules.get(FILE)
    if module is None:
        folders = [os.path.join(folder, "integrate") for folder in scipy.__path__]
        spec: Any = PathFinder.find_spec(FILE, folders)
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
    return module.odeint


def _for_scipy(given, full):
    """The arguments behind `args`, as SciPy's `odeint` passes them on."""
    dfun, transposed, _, ml, mu = given[4:9]
    ml = -1 if ml is None else ml
    mu = -1 if mu is None else mu
    return dfun, transposed, ml, mu, bool(full), *given[9:-1], bool(given[-1])


def spent_of(func, tfirst):
    """The Spent of a function; None for what has no code."""
    try:
        code: Any = func.__code__ if func.__class__ is FUNCTION else plain_function(func).__code__
    except AttributeError:
        return None
    found = _solves.get(id(code))
    if found is None:
        other_order = not tfirst and of_solve_ivp(argument_names(func))  # has a sentence
        found = _solves.put(id(code), Spent(code, bool(other_order)))
    return found


def _is_usual(given):
    """Whether SciPy takes tolerances and limits as `odeint` does."""
    rtol, atol, _, h0, hmax, hmin, prints, mxstep, _, mxordn, mxords, _ = given[9:]
    for size in (rtol, atol):
        if size is not None and not (size > 0 if size.__class__ is float else np.all(size > 0)):
            return False
    if h0 or hmin or prints:
        return False
    return hmax >= 0 and mxstep >= 0 and mxordn >= 0 and mxords >= 0


def _is_monotonic(t):
    """Whether times rise or fall; two times always do."""
    if t.ndim != 1 or len(t) < 2:
        return False
    if len(t) == 2:
        return t[0] != t[1]
    gaps = t[1:] - t[:-1]
    return bool((gaps >= 0).all() or (gaps <= 0).all())


def _is_of(error, spent, given):
    """Whether the function of a call raised an exception, which then has its note."""
    inner = error.__traceback__
    while inner is not None and inner.tb_frame.f_code.co_filename == __file__:
        inner = inner.tb_next
    if inner is None:  # SciPy's, or of a call that does not fit
        return False
    func, _, _, args = given[:4]
    tfirst = given[-1]
    found = inner.tb_frame.f_locals
    pair = [found.get(name) for name in argument_names(func, inner.tb_frame.f_code)[:2]]
    if inner.tb_frame.f_code is spent.code and len(pair) == 2:
        t, y = pair if tfirst else reversed(pair)
        explained(error, called_with(time_first(func, tfirst), args), "fun", t, y)
    return True


def _counted(spent, given, t, try_to):
    """The function, which counts its evaluations, and the function that tells how many they are."""
    func, _, _, args = given[:4]
    tfirst = given[-1]
    left = most = spent.most - spent.n
    done = 0

    def look(*of_call):
        """Compile the function, unless the end is near; the evaluations to the next look."""
        nonlocal done
        done += most
        share = (of_call[not tfirst] - t[0]) / (t[-1] - t[0])
        ahead = done * (1.0 - share) / share if share > 0 else math.inf
        if ahead < MOST / 2:
            return MOST
        spent.n += done
        try:
            if spent.is_compiled(try_to, given):
                raise _Overtaken
            return spent.most - spent.n
        finally:
            spent.n -= done

    def alone(first, second):
        nonlocal left, most
        left -= 1
        if not left:
            left = most = look(first, second)
        return func(first, second)

    def with_args(first, second, *args):
        nonlocal left, most
        left -= 1
        if not left:
            left = most = look(first, second)
        return func(first, second, *args)

    return with_args if args else alone, lambda: done + most - left
